"""Studies: designs, expressions, trials, the file of results, the command, the guide's samples."""

import json
import math
import random
import re
import shutil
import sqlite3
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
import study_samples as samples
from study_samples import GUIDE, SOURCE, command, sample, write_pegs

import cloudcontact as cc
from cloudcontact import study
from cloudcontact.study import design, expressions, study_plots, trial

G = 9.81


def points(parameters, kind="grid", trials=None, repeats=1, seed=0):
    return design.plan(parameters, kind, trials, repeats, seed)


# Designs.


def test_a_grid_has_all_combinations_once():
    plan = points({"a": study.Range(0, 1, 3), "b": ["x", "y"], "c": 7})
    rows = [(p.parameters["a"], p.parameters["b"], p.parameters["c"]) for p in plan]
    assert rows == [(0, "x", 7), (0, "y", 7), (0.5, "x", 7), (0.5, "y", 7), (1, "x", 7), (1, "y", 7)]
    assert [p.number for p in plan] == list(range(6))


def test_ranges_meet_their_ends_and_keep_their_ratios():
    values = study.Range(1e-5, 1e-2, 4, log=True).values("x")
    assert values[0] == 1e-5 and values[-1] == 1e-2
    np.testing.assert_allclose(np.diff(np.log10(values)), 1, rtol=1e-12)
    assert study.Range(3, 9, 1).values("x") == [3]


@pytest.mark.parametrize("trials", [1, 7, 64])
def test_a_latin_hypercube_meets_each_part_once(trials):
    plan = points(
        {"a": study.Range(-1, 3), "b": study.Range(1e-3, 10, log=True), "c": ["x", "y", "z"]}, "latin", trials
    )
    a = np.array([p.parameters["a"] for p in plan])
    b = np.array([p.parameters["b"] for p in plan])
    assert sorted(np.floor((a + 1) / 4 * trials)) == list(range(trials))
    assert sorted(np.floor(np.log(b / 1e-3) / np.log(1e4) * trials)) == list(range(trials))
    counts = [sum(p.parameters["c"] == v for p in plan) for v in "xyz"]
    assert max(counts) - min(counts) <= 1 and sum(counts) == trials


def test_a_latin_hypercube_follows_its_seed():
    ranges = {"a": study.Range(0, 1), "b": study.Range(0, 1)}
    first, again, other = (points(ranges, "latin", 20, seed=s) for s in (3, 3, 4))
    assert first == again and first != other
    # Columns do not go along with each other: 20 ranks in common order have correlation 1.
    a, b = np.array([list(p.parameters.values()) for p in points(ranges, "latin", 400)]).T
    assert abs(np.corrcoef(a, b)[0, 1]) < 0.2


def test_lists_and_repeats():
    plan = points({"k": 5}, "list", [{"a": 1, "b": 2}, {"b": 3, "a": 4}], repeats=2)
    assert [p.parameters for p in plan] == 2 * [{"k": 5, "a": 1, "b": 2}] + 2 * [{"k": 5, "b": 3, "a": 4}]
    assert [p.repeat for p in plan] == [0, 1, 0, 1]


def test_seeds_depend_on_study_and_number_alone():
    seeds = {design.seed_of(s, n) for s in range(20) for n in range(200)}
    assert len(seeds) == 4000 and all(0 <= s < 2**63 for s in seeds)
    assert [p.seed for p in points({"a": [1, 2, 3]})] == [p.seed for p in points({"b": list("xyz")})]
    # Those of other versions of numpy are these, too.
    assert [design.seed_of(0, 0), design.seed_of(7, 1000)] == [8069282889424829228, design.seed_of(7, 1000)]


# Expressions.


def test_expressions_are_pythons():
    source = random.Random(1)
    names = {"a": 1.25, "b": -3.0, "c": 2}

    def make(depth):
        if depth == 0:
            return source.choice(["a", "b", "c", "0.5", "3"])
        kind = source.choice(["binary", "minus", "call", "compare", "chain", "and"])
        one, two, three = make(depth - 1), make(depth - 1), make(depth - 1)
        return {
            "binary": f"({one} {source.choice('+-*')} {two})",
            "minus": f"(-{one})",
            "call": f"{source.choice(['abs', 'cos'])}({one})",
            "compare": f"({one} {source.choice(['<', '<=', '>', '==', '!='])} {two})",
            "chain": f"({one} < {two} <= {three})",
            "and": f"({one} {source.choice(['and', 'or'])} not {two})",
        }[kind]

    for _ in range(300):
        text = make(4)
        expected = eval(text, {"abs": abs, "cos": math.cos}, names)
        assert repr(expressions.Expression(text, "x")(names)) == repr(expected), text


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os')",
        "a.b",
        "1 +",
        "a[0]",
        "lambda: 1",
        "abs(x=2)",
        "(1, 2)",
        "exec('1')",
        "b'x'",
        "a if a else a",
        "a is a",
    ],
)
def test_expressions_are_nothing_else_of_python(text):
    with pytest.raises(study.StudyError, match="success: "):
        expressions.Expression(text, "success")


def test_a_template_keeps_all_digits():
    text = expressions.Template("<p>${a} ${a / 3} ${name}</p>", "x.sdf").filled({"a": 0.1 + 0.2, "name": "n"}, 0)
    first, second = map(float, re.findall(r"[\d.e-]{5,}", text))
    assert first == 0.1 + 0.2 and second == (0.1 + 0.2) / 3 and "n</p>" in text


def test_a_template_draws_from_the_seed():
    template = expressions.Template("${uniform(2, 3)} ${normal(0, 1)}", "x.sdf")
    assert template.filled({}, 5) == template.filled({}, 5) != template.filled({}, 6)
    drawn = np.array([list(map(float, template.filled({}, s).split())) for s in range(400)])
    assert drawn[:, 0].min() >= 2 and drawn[:, 0].max() <= 3
    assert abs(drawn[:, 1].mean()) < 0.2 and abs(drawn[:, 1].std() - 1) < 0.15


# Trials.


@pytest.fixture(scope="module")
def pegs(tmp_path_factory):
    """24 pegs, run once."""
    folder = tmp_path_factory.mktemp("pegs")
    made = study.load(write_pegs(folder))
    return made, made.run(folder / "pegs.sqlite", "local:2", progress=False)


def test_pegs_go_in_where_the_clearance_is_larger_than_the_offset(pegs):
    made, results = pegs
    assert len(results) == len(made) == 24 and results.counts == {"done": 24}
    columns = results.columns()
    offset, clearance, success = columns["offset"], columns["clearance"], columns["success"]
    clear = abs(offset - clearance) > 0.1e-3  # the border is 0.07 mm beyond equal values
    assert clear.sum() > 12
    np.testing.assert_array_equal(success[clear], (offset < clearance)[clear])
    stands = success == 1
    np.testing.assert_allclose(columns["peg_z"][stands], 0.005, atol=1e-4)
    np.testing.assert_allclose(columns["peg_force_z"][stands], 0.02 * G, rtol=0.02)
    assert (columns["peg_peak_force"] >= np.abs(columns["peg_force_z"])).all()
    np.testing.assert_allclose(columns["time"], 0.15, rtol=1e-9)


def test_rows_are_what_a_trial_gives_to_the_bit(pegs):
    made, results = pegs
    for number in (0, 13):
        row, here = results.rows()[number], made.once(number)
        assert {name: row[name] for name in here} == here
        assert row["seed"] == made.points[number].seed
        assert all(row[name] == value for name, value in made.points[number].parameters.items())
        assert row["versions"] == trial.versions() and cc.__version__ in row["versions"]


def test_a_scenes_settings_are_the_worlds():
    """Stiffness, step and seconds of the parameters, against a world by hand."""
    made = study.Study(
        scene=samples.brick_scene,
        parameters={"height": 1e-4, "voxel": 0.002, "stiffness": 2000, "damping": 20, "seconds": 0.4, "step": 0.002},
    )
    row = made.once()
    world = cc.World(samples.brick_scene(1e-4), 0.002, False, law=cc.KelvinVoigt(2000, 20), threads=1)
    world.run(0.4, 0.002, progress=False)
    assert row["hash"] == f"{world.hash:016x}"
    assert row["brick_z"] == pytest.approx(0.01 - 0.2 * G / 2000, abs=1e-4)


def test_what_a_scene_uses_is_its_own():
    """brick_scene() takes friction, so the world gets none for all pairs; the voxel is the run's in any case."""
    assert cc.study.scenes.settings_of({"friction": 1, "voxel": 2, "height": 3}, ["friction", "height", "voxel"]) == {
        "voxel": 2
    }


@pytest.mark.parametrize("law", ["paper", "foundation", "rigid", "maxwell:2e4,20", "solid:2e4,1e4,20"])
def test_laws(law):
    kind = {"p": cc.KelvinVoigt, "f": cc.Foundation, "r": cc.Rigid, "m": cc.Maxwell, "s": cc.StandardLinearSolid}
    assert isinstance(cc.study.scenes.law_of({"law": law, "stiffness": 1e4}), kind[law[0]])


def test_the_wrench_on_a_body_is_about_its_origin():
    """A block stands on a post beside its middle: force m g, no torque about its own origin."""
    scene = cc.Scene("overhang")
    scene.add("post", cc.Box((0.01, 0.01, 0.01)), (0.104, 0, -0.01), static=True, friction=0.5)
    scene.add("block", cc.Box((0.02, 0.01, 0.01)), (0.1, 0, 0.01), mass=0.5, friction=0.5)
    world = cc.World(scene, voxel=0.002, threads=1)
    wrench = cc.study.scenes.Wrenches([world["block"]])
    world.run(0.5, observe=wrench, progress=False)
    np.testing.assert_allclose(wrench.force[0], [0, 0, 0.5 * G], atol=0.02)
    # About the post's middle it is 0.5 G 0.004 = 0.02 N m, about the world's origin 0.5 N m.
    np.testing.assert_allclose(wrench.torque[0], 0, atol=2e-3)


def test_a_function_gives_columns(tmp_path):
    made = study.Study(trial=samples.square, parameters={"n": [1, 2, 3]}, seed=4)
    with made.run(tmp_path / "s.sqlite", "local:2", progress=False) as results:
        rows = results.rows()
    assert [r["square"] for r in rows] == [1, 4, 9]
    assert [r["seeded"] for r in rows] == [r["seed"] for r in rows] == [design.seed_of(4, n) for n in range(3)]
    assert rows[0]["list_y"] == 2.5 and rows[0]["four_3"] == 4 and rows[0]["none"] is None


def test_what_ends_a_trial_ends_nothing_else(tmp_path):
    ways = ["raises", "fine", "killed", "sleeps", "exits", "well"]
    made = study.Study(trial=samples.kills_itself, parameters={"way": ways}, timeout=5)
    results = made.run(tmp_path / "s.sqlite", "local:2", progress=False)
    rows = results.rows(None)
    assert [r["status"] for r in rows] == ["failed", "done", "crashed", "timeout", "crashed", "done"]
    errors = [r["error"] for r in rows]
    assert results.database.execute("SELECT seconds FROM log WHERE number = 3").fetchone()[0] < 30
    assert "KeyError: 'no such thing'" in errors[0] and errors[1] is None
    assert "SIGKILL" in errors[2] and "3 times" in errors[2]
    assert "longer than 5 s" in errors[3] and "code 3" in errors[4]
    assert rows[1]["pid"] != rows[5]["pid"], "each trial is a process"
    assert "about to raise" in results.output(0) and "line" in results.output(0)
    attempts = dict(results.database.execute("SELECT number, attempts FROM log"))
    assert attempts == {0: 1, 1: 1, 2: 3, 3: 1, 4: 3, 5: 1}
    code, _, error = show(results, tmp_path)
    assert code == 1 and "2 crashed; the first, trial 2: its process was ended by signal SIGKILL" in error


def show(results, folder):
    """The command's summary of a file of results: of a study that is not its own, so by the module."""
    done = subprocess.run(
        [sys.executable, "-c", f"from cloudcontact.study import command as c, Results; import argparse; "
         f"raise SystemExit(c.show(Results({str(results.path)!r}), argparse.Namespace(json=False, plots=None)))"],
        capture_output=True, text=True,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


def test_what_died_once_runs_again_and_is_done(tmp_path):
    made = study.Study(trial=samples.dies_once, parameters={"file": str(tmp_path / "mark"), "n": [1, 2, 3, 4]})
    results = made.run(tmp_path / "s.sqlite", "local:2", progress=False)
    assert [r["square"] for r in results.rows()] == [1, 4, 9, 16]
    assert {n for n, in results.database.execute("SELECT attempts FROM log")} == {2}


def test_failed_trials_run_again_where_that_is_asked(tmp_path):
    file = tmp_path / "mend.py"
    words: dict[str, Any] = {"trial": "mend.py:mend", "parameters": {"n": [1, 2, 3]}, "folder": tmp_path}
    text = (
        "import pathlib\ndef mend(n):\n    return {'half': 1 / n} if n != 2 or pathlib.Path(%r).exists() else 1 / 0\n"
    )
    file.write_text(text % str(tmp_path / "mended"))
    for again, expected in ((False, {"done": 2, "failed": 1}), (False, {"done": 2, "failed": 1}), (True, {"done": 3})):
        with study.Study(**words).run(tmp_path / "s.sqlite", "local:1", again=again, progress=False) as results:
            assert results.counts == expected
        (tmp_path / "mended").touch()
    assert study.Results(tmp_path / "s.sqlite").rows()[1]["half"] == 0.5


def test_progress_counts(tmp_path, capsys):
    made = study.Study("few", trial=samples.kills_itself, parameters={"way": ["raises", "well", "fine", "good"]})
    shares: list[float] = []
    made.run(tmp_path / "a.sqlite", "local:1", progress=shares.append).close()
    assert shares == sorted(shares) and shares[-1] == 1
    made.run(tmp_path / "b.sqlite", "local:1", progress=True).close()
    shown = capsys.readouterr().err
    assert re.search(r"few: [123] of 4.*\[#+-+\]", shown) and "1 failed" in shown


# The file of results.


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


def test_the_digest_sees_a_bit(pegs, tmp_path):
    shutil.copy(pegs[1].path, tmp_path / "s.sqlite")
    with sqlite3.connect(tmp_path / "s.sqlite") as database:
        (energy,) = database.execute("SELECT energy FROM trials WHERE number = 3").fetchone()
        assert study.Results(tmp_path / "s.sqlite").digest() == pegs[1].digest()
        database.execute("UPDATE trials SET energy = ? WHERE number = 3", [np.nextafter(energy, 1)])
    assert study.Results(tmp_path / "s.sqlite").digest() != pegs[1].digest()


# Summaries and plots.


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


# The command and the guide.


def test_help_has_examples_and_all_options():
    code, out, _ = command("--help")
    assert code == 0 and "examples:" in out and "mpirun" in out
    for option in ("--on", "--results", "--plots", "--again", "--try", "--summary", "--json", "--quiet", "--version"):
        assert option in out


def test_the_guide_runs(tmp_path, monkeypatch):
    """Its files, its commands and its Python, with fewer trials."""
    monkeypatch.chdir(tmp_path)
    write_pegs(tmp_path, 4, 2)
    lines = [
        line.split("#")[0].split()[1:] for line in re.findall(r"```sh\n(.*?)```", GUIDE, re.S)[0].split("\n") if line
    ]
    assert len(lines) == 3
    for words in lines:
        code, out, error = command(*words)
        assert code == 0, error
        assert "--plots" not in words or "pegs: 100 % of the trials" in error
    assert "8 done of 8" in out
    assert (tmp_path / "plots" / "wrenches.png").is_file() and (tmp_path / "plots" / "success.png").is_file()
    (tmp_path / "python").mkdir()
    write_pegs(tmp_path / "python", 3, 2)
    monkeypatch.chdir(tmp_path / "python")
    values: dict[str, Any] = {}
    exec(compile(re.findall(r"```python\n(.*?)```", GUIDE, re.S)[0], "guide", "exec"), values)
    assert values["results"].counts == {"done": 6} and (tmp_path / "python" / "success.png").is_file()
    query = re.findall(r"```sql\n(.*?)```", GUIDE, re.S)[0]
    rows = sqlite3.connect(tmp_path / "pegs.sqlite").execute(query).fetchall()
    assert len(rows) == 2 and rows[0][1] <= rows[1][1]


def test_the_packages_page_runs(tmp_path, monkeypatch):
    write_pegs(tmp_path)
    page = (SOURCE / "docs/python.md").read_text().split("## Studies")[1]
    text = re.findall(r"```python\n(.*?)```", page, re.S)[0].replace("25)", "2)").replace("40)", "3)")
    monkeypatch.chdir(tmp_path)
    values: dict[str, Any] = {}
    exec(compile(text, "docs/python.md", "exec"), values)
    assert values["results"].counts == {"done": 6}


@pytest.mark.parametrize("name, python, trials", [("round_pegs", "round_peg", "24"), ("slides", "slide", "")])
def test_the_guides_functions_run(name, python, trials, tmp_path):
    (tmp_path / f"{python}.py").write_text(sample(f"{python}.py"))
    text = sample(f"{name}.toml").replace("trials = 200", f"trials = {trials}")
    (tmp_path / f"{name}.toml").write_text(text)
    code, out, error = command(tmp_path / f"{name}.toml", "--on", "local:2", "--json")
    assert code == 0, error
    with study.Results(tmp_path / f"{name}.sqlite") as results:
        columns = results.columns()
    if name == "slides":
        np.testing.assert_array_equal(columns["success"], columns["slope"] < columns["friction"])
    else:
        in_hole = columns["offset"] < columns["clearance"] - 1e-4  # beyond that the chamfer leads it in, or not
        assert in_hole.sum() >= 4
        assert columns["success"][in_hole].all() and len(columns["success"]) == 24
        assert not columns["success"][columns["offset"] > columns["clearance"] + columns["chamfer"] + 1e-4].any()


def test_try_runs_one_trial_and_writes_nothing(tmp_path):
    write_pegs(tmp_path)
    code, out, error = command(tmp_path / "pegs.toml", "--try", 3)
    assert code == 0 and json.loads(out)["number"] == 3 and json.loads(out)["success"] in (0, 1)
    assert not (tmp_path / "pegs.sqlite").exists()
    assert command(tmp_path / "pegs.toml", "--try", 24)[0] == 2


@pytest.mark.parametrize(
    "change, words",
    [
        (("success = ", "sucess = "), "sucess: is not known; did you mean 'success'"),
        (("peg_z", "pg_z"), "success: 'pg_z' is no outcome and no parameter; did you mean 'peg_z'"),
        (("peg.sdf", "none.sdf"), "scene: cannot read '.*none.sdf': No such file"),
        (("clearance = {", "clearence = {"), "parameters.clearence: is no setting, .* did you mean 'clearance'"),
        (("seconds = 0.15", ""), "parameters.seconds: the time"),
        (("count = 6", "cuont = 6"), "parameters.offset.cuont: is not known; did you mean 'count'"),
        (("count = 6", "count = 0"), "parameters.offset: count must be"),
        (("from = 0.0", "from = nan"), "parameters.offset: from and to must be finite"),
        (("friction = 0.2", "law = 'elastic'"), "law: 'elastic' is not known"),
        (("friction = 0.2", "damping = 3"), "stiffness: damping needs it"),
        (("voxel = 5e-4", "voxel = [5e-4, -1]"), "parameters.voxel: -1 must be a number above 0"),
        (("friction = 0.2", "friction = 'low'"), "parameters.friction: 'low' must be a number of 0 or more"),
        (("friction = 0.2", "substeps = 1.5"), "parameters.substeps: 1.5 must be a whole number of 1 or more"),
        (("friction = 0.2", "friction = []"), "parameters.friction: has no value"),
        (("friction = 0.2", "Voxel = 1"), "parameters.Voxel: another parameter has this name"),
        (("friction = 0.2", "seed = 1"), "parameters.seed: is a column of the results"),
        (("scene = ", "trial = 'a.py:b'\nscene = "), "scene, trial: give one of the two"),
        (("scene = ", "design = 'girds'\nscene = "), "design: 'girds' is not known"),
        (("scene = ", "seed = -1\nscene = "), "seed: must be a whole number of 0 or more"),
        (("scene = ", "timeout = 0\nscene = "), "timeout: must be a number of seconds above 0"),
        (("scene = ", "watch = ['pge']\nscene = "), "watch: the scene has no body 'pge'; did you mean 'peg'"),
        (("scene = ", "seed = 'x'\nscene = "), "seed: must be a whole number"),
        (("scene = ", "scene == "), "pegs.toml: "),
        (('scene = "peg.sdf"', "trial = 'none.py:f'"), "trial: no file '.*none.py'"),
        (('scene = "peg.sdf"', "trial = 'peg.sdf'"), "trial: 'peg.sdf': give FILE.py:FUNCTION"),
        (('scene = "peg.sdf"', "trial = 'nonsense:f'"), "trial: nonsense:f\\(\\): ModuleNotFoundError"),
    ],
)
def test_bad_studies_are_named(change, words, tmp_path):
    file = write_pegs(tmp_path)
    assert change[0] in file.read_text()
    file.write_text(file.read_text().replace(*change))
    with pytest.raises(study.StudyError, match="pegs.toml: " + words.replace("pegs.toml: ", "")):
        study.load(file)


def test_bad_scenes_are_named(tmp_path):
    file = write_pegs(tmp_path)
    scene = tmp_path / "peg.sdf"
    for change, words in (
        (("${offset}", "${offset"), "peg.sdf"),
        (("${offset}", "${ofset}"), "parameters.offset: is no setting, and peg.sdf has no .*; did you mean 'ofset'"),
        (("${offset}", "${f(offset)}"), "peg.sdf: 'f\\(\\)' in 'f\\(offset\\)' is not known"),
        (
            ("<box><size>0.008 0.008 0.01</size></box>", "<mesh><uri>none.obj</uri></mesh>"),
            "peg.sdf: body 'peg' .* no file '.*none.obj'",
        ),
    ):
        text = sample("peg.sdf")
        assert change[0] in text
        scene.write_text(text.replace(*change))
        with pytest.raises(study.StudyError, match=words):
            study.load(file)


def test_bad_functions_are_named(tmp_path):
    def inner(n):
        return {}

    cases: list[tuple[dict[str, Any], str]] = [
        (
            {"trial": samples.square, "parameters": {"m": 1}},
            r"parameters.m: study_samples.py:square\(\) does not take it",
        ),
        ({"trial": samples.square, "parameters": {}}, r"parameters: study_samples.py:square\(\) needs 'n'; add it"),
        ({"trial": 3, "parameters": {"n": 1}}, "trial: give a function"),
        ({"scene": samples.square, "parameters": {"n": 1, "seconds": 1}}, "scene: .*returned dict; give a Scene"),
        (
            {"trial": "study_samples.py:sqare", "parameters": {"n": 1}, "folder": SOURCE / "tests/python"},
            "did you mean 'square'",
        ),
        ({"trial": samples.square, "watch": ["a"], "parameters": {"n": 1}}, "watch: bodies are measured of a scene"),
    ]
    for words, message in cases:
        with pytest.raises(study.StudyError, match=message):
            study.Study(**words)
    try:
        import cloudpickle  # noqa: F401
    except ImportError:
        with pytest.raises(study.StudyError, match="is not at the top of a file"):
            study.Study(trial=inner, parameters={"n": 1})
    else:
        made = study.Study(trial=lambda n: {"twice": 2 * n}, parameters={"n": [1, 2]})
        with made.run(tmp_path / "s.sqlite", "local:1", progress=False) as results:
            assert [r["twice"] for r in results.rows()] == [2, 4]


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


def test_bad_words_of_the_command_end_with_2(tmp_path):
    file = write_pegs(tmp_path)
    for words, message in (
        ([tmp_path / "none.toml"], "none.toml: No such file"),
        ([file, "--on", "cluster"], "on: 'cluster' is not known; give local"),
        ([file, "--on", "local:0"], "on: 'local:0' is not known"),
        ([file, "--summary"], "no results '.*pegs.sqlite'; run the study first"),
        ([file, "--results", tmp_path / "none" / "a"], "results: no folder"),
        ([file, "--fast"], "unrecognized arguments: --fast"),
    ):
        code, out, error = command(*words)
        assert code == 2 and re.search(message, error) and not out, error
        assert "Traceback" not in error


def test_docstrings_and_types_are_there():
    for name in study.__all__:
        thing = getattr(study, name)
        assert thing.__doc__, name
        for line in thing.__doc__.split("\n"):
            assert len(line) <= 110
