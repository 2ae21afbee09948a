"""Studies: the file of results."""

import math
import re
from typing import Any, cast

import numpy as np
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


def test_any_file_of_a_scene_makes_another_study(tmp_path):
    """A robot's meshes, those of a model that is included, and that model; those of any point."""
    (tmp_path / "a.obj").write_text("v 0 0 0\n")
    (tmp_path / "r.urdf").write_text(f"<robot><mesh scale='1' filename='package://{tmp_path.name}/b.obj'/></robot>")
    for name in ("b.obj", "c2.obj"):
        (tmp_path / name).write_text(name)
    scene = "<sdf><uri>r.urdf</uri><mesh filename='file://a.obj'/><uri>c${n}.obj</uri></sdf>"
    file = cc.study.scenes.SceneFile(scene, str(tmp_path / "s.sdf"))
    digests = {file.digest({"n": 1}, {"n": 2})}
    for n, name in enumerate(["a.obj", "b.obj", "r.urdf", "c2.obj"]):
        with open(tmp_path / name, "a") as changed:
            changed.write("\n")
        digests.add(file.digest({"n": 1}, {"n": 2}))
        assert len(digests) == n + 2, name
    assert file.digest({"n": 1}) not in digests


def test_other_files_are_refused(tmp_path):
    made = study.Study(trial=samples.square, parameters={"n": 1})
    (tmp_path / "text.sqlite").write_text("no database" * 100)
    with pytest.raises(study.StudyError, match="text.sqlite': holds no results"):
        made.run(tmp_path / "text.sqlite")
    with pytest.raises(study.StudyError, match="no folder"):
        made.run(tmp_path / "none" / "s.sqlite")
    assert (tmp_path / "text.sqlite").read_text().startswith("no database")
    with pytest.raises(study.StudyError, match=f"results: '{tmp_path}' is a folder; give a file in it"):
        made.run(tmp_path)
    with pytest.raises(study.StudyError, match=f"results: '{tmp_path}' is a folder; give the file in it"):
        study.Results(tmp_path)


def test_one_study_writes_at_a_time(tmp_path):
    made = study.Study(trial=samples.square, parameters={"n": 1})
    with cc.study.results.Lock(tmp_path / "s.sqlite"):
        with pytest.raises(study.StudyError, match="s.sqlite: another study writes it"):
            made.run(tmp_path / "s.sqlite", "local:1", progress=False)
    made.run(tmp_path / "s.sqlite", "local:1", progress=False).close()
    assert sorted(f.name for f in tmp_path.iterdir()) == ["s.sqlite"]


def test_a_lock_that_was_removed_hides_no_error(tmp_path):
    lock = tmp_path / "s.sqlite.lock"
    with pytest.raises(KeyError, match="the real one"):
        with cc.study.results.Lock(tmp_path / "s.sqlite"):
            lock.unlink()
            raise KeyError("the real one")
    with cc.study.results.Lock(tmp_path / "s.sqlite") as first:
        lock.unlink()
        with cc.study.results.Lock(tmp_path / "s.sqlite"):
            first.__exit__()
            first.file = -1
            assert lock.exists(), "it is another study's"


def test_results_go_where_the_run_began(tmp_path, monkeypatch):
    """Whatever folder the program goes to meanwhile."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "inner").mkdir()
    made, first = study.Study(trial=samples.square, parameters={"n": 1}), cast(int, np.int64(0))
    with made.run("s.sqlite", "local:1", progress=lambda share: monkeypatch.chdir(tmp_path / "inner")) as results:
        assert results.counts == {"done": 1} and results.output(first) == ""
    assert sorted(f.name for f in tmp_path.iterdir()) == ["inner", "s.sqlite"]


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
        ("{'a': [[1], [1, 2]]}", "outcome 'a': list is no number"),
        ("{'a': [1, 2, 3], 'a_x': 4}", "outcome 'a_x': another outcome has this name"),
        ("7", "returned int; give a dict"),
        ("{'success': 'yes'}", "outcome 'success': 'yes' is a text; give true or false"),
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
        ("__import__('enum').Enum('Kind', {'KNIFE': 'knife'}, type=str).KNIFE", "knife"),
        ("__import__('numpy').array(2.5)", 2.5),
        ("__import__('fractions').Fraction(1, 4)", 0.25),
    ],
)
def test_extreme_outcomes_are_kept(value, kept, tmp_path):
    (tmp_path / "t.py").write_text(f"def t(n):\n    return {{'a': {value}}}\n")
    with study.Study(trial="t.py:t", parameters={"n": 1}, folder=tmp_path).run(
        tmp_path / "s.sqlite", "local:1", progress=False
    ) as results:
        assert results.rows()[0]["a"] == kept
