"""Studies: summaries and plots."""

import json
from typing import Any

import numpy as np
import pytest

from cloudcontact import study
from cloudcontact.study import study_plots


def test_the_summary_counts(pegs):
    summary = study.summarize(pegs[1])
    columns = pegs[1].columns()
    assert summary.success == columns["success"].mean()
    for name in ("offset", "clearance"):
        for value, (_, share, count) in zip(np.unique(columns[name]), summary.by[name]):
            who = columns[name] == value
            if len(np.unique(columns[name])) <= 5:
                assert share == columns["success"][who].mean() and count == who.sum()
        assert sum(count for *_, count in summary.by[name]) == 24
    assert summary.outcomes["peg_z"][1] == np.median(columns["peg_z"])
    text = str(summary)
    assert "24 done of 24" in text and "offset [m]" in text and summary.digest[:16] in text
    assert json.loads(json.dumps(summary.json()))["counts"] == {"done": 24}


def test_the_map_of_success_shows_each_cell(pegs, tmp_path):
    pytest.importorskip("matplotlib")
    figure = study.plot_success(pegs[1], "offset", "clearance", tmp_path / "map.png")
    axes = figure.axes[0]
    assert axes.get_xlabel() == "offset [mm]" and axes.get_ylabel() == "clearance [mm]"
    columns = pegs[1].columns()
    drawn = np.asarray(axes.collections[0].get_array()).reshape(4, 6)
    for x, y, success in zip(columns["offset"], columns["clearance"], columns["success"]):
        row, column = round((y - 1e-4) / 5e-4 * 3), round(x / 8e-4 * 5)
        assert drawn[row, column] == success
    assert (tmp_path / "map.png").read_bytes()[:4] == b"\x89PNG"


def test_wrenches_are_all_drawn(pegs, tmp_path):
    pytest.importorskip("matplotlib")
    figure = study.plot_wrenches(pegs[1], "offset", tmp_path / "wrenches.png")
    force = figure.axes[0]
    assert sum(bar.get_height() for bar in force.patches) == 24
    assert force.get_xlabel() == "peg peak force [N]" and (tmp_path / "wrenches.png").stat().st_size > 10_000


def test_scattered_trials_and_one_parameter(tmp_path):
    pytest.importorskip("matplotlib")
    (tmp_path / "t.py").write_text("def t(a, b=0):\n    return {'success': a > 0.5, 'a_force': a}\n")
    ranges = {"a": study.Range(0, 1), "b": study.Range(0, 1)}
    for design_of, name in ((ranges, "two"), ({"a": ranges["a"]}, "one")):
        made = study.Study(name, trial="t.py:t", parameters=design_of, design="latin", trials=20, folder=tmp_path)
        results = made.run(tmp_path / f"{name}.sqlite", "local:2", progress=False)
        axes = study.plot_success(results, file=tmp_path / f"{name}.svg").axes[0]
        if name == "two":
            assert sum(len(marks.get_offsets()) for marks in axes.collections) == 20
        else:
            assert axes.lines[0].get_ydata().tolist() == 10 * [0] + 10 * [1]
    with pytest.raises(study.StudyError, match="no column 'c'"):
        study.plot_success(results, "c")


def test_texts_are_an_axis(tmp_path):
    pytest.importorskip("matplotlib")
    (tmp_path / "t.py").write_text("def t(law, k):\n    return {'success': (law == 'paper') == (k < 3)}\n")
    laws: dict[str, Any] = {"law": ["rigid", "paper"], "k": [1, 2, 3]}
    made = study.Study("laws", trial="t.py:t", parameters=laws, folder=tmp_path)
    results = made.run(tmp_path / "s.sqlite", "local:2", progress=False)
    axes = study.plot_success(results, "k", "law", tmp_path / "laws.png").axes[0]
    assert [tick.get_text() for tick in axes.get_yticklabels()] == ["paper", "rigid"]
    np.testing.assert_array_equal(np.asarray(axes.collections[0].get_array()).reshape(2, 3), [[1, 1, 0], [0, 0, 1]])
    assert study.summarize(results).by["law"] == [("paper", 2 / 3, 3), ("rigid", 1 / 3, 3)]


def test_what_cannot_be_drawn_is_named(tmp_path):
    pytest.importorskip("matplotlib")
    (tmp_path / "t.py").write_text(
        "def t(**more):\n    return {'success': None, 'a_force': None, 'b_force': 'none', 'up': None}\n"
    )
    cases: list[dict[str, Any]] = [{}, {"n": [1, 2]}]
    bare, plain = (
        study.Study(trial="t.py:t", parameters=parameters, folder=tmp_path).run(
            tmp_path / f"{len(parameters)}.sqlite", "local:1", progress=False
        )
        for parameters in cases
    )
    assert study.summarize(plain).success is None
    for words, draw in (
        ("plot: the study has no parameters", lambda: study.plot_success(bare)),
        ("plot: the study has no parameters", lambda: study.plot_wrenches(bare, names=["a_force"])),
        ("plot: no trial has an outcome whose name ends in force", lambda: study.plot_wrenches(plain)),
        ("plot: no trial has a value of 'up'", lambda: study.plot_wrenches(plain, names=["up"])),
    ):
        with pytest.raises(study.StudyError, match=words):
            draw()


@pytest.mark.parametrize(
    "values, unit, label, largest",
    [
        ([0, 8e-4], "m", "x [mm]", 0.8),
        ([3e-6], "N m", "x [\u00b5N m]", 3),
        ([2, 3], "m", "x [m]", 3),
        ([0.002], "", "x", 0.002),
    ],
)
def test_axes_take_a_unit_of_their_size(values, unit, label, largest):
    axis = study_plots.Axis("x", np.array(values, float), unit)
    assert axis.label == label and axis.values.max() == pytest.approx(largest)
