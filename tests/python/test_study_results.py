"""Studies: the file of results."""

import math
import re
from typing import Any

import pytest
import study_samples as samples

import cloudcontact as cc
from cloudcontact import study
from cloudcontact.study import trial


def test_a_file_of_another_study_is_refused(tmp_path):
    words: dict[str, Any] = {"trial": samples.square, "parameters": {"n": [1, 2, 3]}}
    first = study.Study(**words).run(tmp_path / "s.sqlite", "local:1", progress=False)
    changes: list[tuple[dict[str, Any], str]] = [
        ({"seed": 3}, "seed"),
        ({"parameters": {"n": [1, 2, 4]}}, "parameters"),
        ({"trial": samples.kills_itself, "parameters": {"way": "x"}}, "names"),
    ]
    for change, named in changes:
        with pytest.raises(study.StudyError, match=f"its study differs in .*{named}"):
            study.Study(**{**words, **change}).run(tmp_path / "s.sqlite", "local:1", progress=False)
    assert first.counts == {"done": 3}


def test_a_mesh_that_changed_makes_another_study(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\n")
    scene = "<sdf version='1.9'><world name='w'><uri>a.obj</uri></world></sdf>"
    file = cc.study.scenes.SceneFile(scene, str(tmp_path / "s.sdf"))
    before = file.digest({})
    (tmp_path / "a.obj").write_text("v 0 0 1\n")
    assert file.digest({}) != before


def test_other_files_are_refused(tmp_path):
    made = study.Study(trial=samples.square, parameters={"n": 1})
    (tmp_path / "text.sqlite").write_text("no database" * 100)
    with pytest.raises(study.StudyError, match="text.sqlite': holds no results"):
        made.run(tmp_path / "text.sqlite")
    with pytest.raises(study.StudyError, match="no folder"):
        made.run(tmp_path / "none" / "s.sqlite")
    assert (tmp_path / "text.sqlite").read_text().startswith("no database")


def test_one_study_writes_at_a_time(tmp_path):
    made = study.Study(trial=samples.square, parameters={"n": 1})
    with cc.study.results.Lock(tmp_path / "s.sqlite"):
        with pytest.raises(study.StudyError, match="s.sqlite: another study writes it"):
            made.run(tmp_path / "s.sqlite", "local:1", progress=False)
    made.run(tmp_path / "s.sqlite", "local:1", progress=False).close()
    assert sorted(f.name for f in tmp_path.iterdir()) == ["s.sqlite"]


def test_a_row_is_written_once(tmp_path):
    """An executor that runs a trial twice gives two replies; the first counts."""
    made = study.Study(trial=samples.square, parameters={"n": [1, 2]})
    recorder = cc.study.results.Recorder(tmp_path / "s.sqlite", made.statement, made.points, {})
    for square in (1, 7):
        recorder.record([(trial.Reply(0, "done", {"square": square}, seconds=square), 1)])
    assert recorder.open(again=True) == {1}
    recorder.close()
    with study.Results(tmp_path / "s.sqlite") as results:
        assert [r["square"] for r in results.rows(None)] == [1, None]
        assert results.database.execute("SELECT number, seconds FROM log").fetchall() == [(0, 1)]


@pytest.mark.parametrize(
    "outcomes, words",
    [
        ("{'n': 1}", "outcome 'n': another column has this name"),
        ("{'Seed': 1}", "outcome 'Seed': another column"),
        ("{'a': 1, 'A': 2}", "outcome 'A': another column"),
        ("{'a b': 1}", "outcome 'a b': is no name"),
        ("{'a': {}}", "outcome 'a': dict is no number"),
        ("{'a': [0] * 33}", "outcome 'a': 33 numbers"),
        ("7", "returned int; give a dict"),
    ],
)
def test_bad_outcomes_are_named(outcomes, words, tmp_path):
    (tmp_path / "t.py").write_text(f"def t(n):\n    return {outcomes}\n")
    made = study.Study(trial="t.py:t", parameters={"n": 1}, folder=tmp_path)
    with made.run(tmp_path / "s.sqlite", "local:1", progress=False) as results:
        assert re.search(words, results.rows("failed")[0]["error"])


@pytest.mark.parametrize(
    "value, kept",
    [
        ("2**63", "0x8000000000000000"),
        ("float('nan')", None),
        ("float('inf')", math.inf),
        ("True", 1),
        ("-2**63 + 1", -(2**63) + 1),
    ],
)
def test_extreme_outcomes_are_kept(value, kept, tmp_path):
    (tmp_path / "t.py").write_text(f"def t(n):\n    return {{'a': {value}}}\n")
    with study.Study(trial="t.py:t", parameters={"n": 1}, folder=tmp_path).run(
        tmp_path / "s.sqlite", "local:1", progress=False
    ) as results:
        assert results.rows()[0]["a"] == kept
