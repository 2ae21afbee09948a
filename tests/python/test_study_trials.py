"""Studies: trials, what they measure, and what ends one of them."""

import concurrent.futures
import re
import shutil
import sqlite3
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
import study_samples as samples
from conftest import box_arrays, write_obj

import cloudcontact as cc
from cloudcontact import study
from cloudcontact.study import design, trial

G = 9.81


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


def test_the_digest_sees_a_bit(pegs, tmp_path):
    shutil.copy(pegs[1].path, tmp_path / "s.sqlite")
    with sqlite3.connect(tmp_path / "s.sqlite") as database:
        (energy,) = database.execute("SELECT energy FROM trials WHERE number = 3").fetchone()
        assert study.Results(tmp_path / "s.sqlite").digest() == pegs[1].digest()
        database.execute("UPDATE trials SET energy = ? WHERE number = 3", [np.nextafter(energy, 1)])
    assert study.Results(tmp_path / "s.sqlite").digest() != pegs[1].digest()


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


ROBOT = """<robot name="r"><link name="part">
  <inertial><mass value="0.2"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><mesh filename="${mesh}" scale="1 1 1"/></geometry></collision>
</link></robot>
"""
TABLE = """<sdf version="1.9"><world name="table">
  <include><uri>${robot}</uri><pose>0 0 0.01 0 0 0</pose></include>
  <model name="table"><static>true</static><link name="l">
    <collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>
  </link></model>
</world></sdf>
"""
BOX = """<sdf version="1.9"><model name="box"><link name="l"><collision name="c">
  <geometry><mesh><uri>model://urdf/../meshes/second part.obj</uri></mesh></geometry>
</collision></link></model></sdf>
"""
# As a robot names its meshes, and where they are beside its folder.
MESHES = {
    "part.obj": "part.obj",
    "../meshes/second part.obj": "../meshes/second part.obj",
    "package://r\u00f6bot &amp; co/meshes/\u00fc&quot;.obj": '../meshes/\u00fc".obj',
    "package://r\u00f6bot &amp; co/urdf/part.obj": "part.obj",
    "file://it's.obj": "it's.obj",
}
ROBOTS = [*(f"{n}.urdf" for n in range(len(MESHES))), "boxed"]


def robot_in(folder):
    """The folder of robots in a package whose name has a blank, an umlaut and an ampersand; boxes of many heights."""
    home = folder / "a b" / "r\u00f6bot & co" / "urdf"
    (home.parent / "meshes").mkdir(parents=True)
    home.mkdir()
    for n, file in enumerate(sorted(set(MESHES.values()))):
        write_obj(home / file, *box_arrays([0.04, 0.03, 0.0202 + 0.0002 * n]))
    for n, mesh in enumerate(MESHES):
        (home / f"{n}.urdf").write_text(ROBOT.replace("${mesh}", mesh), "utf-8")
    for n, robot in enumerate(ROBOTS):
        (home / f"{n}.sdf").write_text(TABLE.replace("${robot}", robot), "utf-8")
    (home / "boxed").mkdir()
    (home / "boxed" / "model.config").write_text(
        "<model><name>b</name><version>1</version><sdf version='1.9'>box.sdf</sdf></model>"
    )
    (home / "boxed" / "box.sdf").write_text(BOX)
    (home / "robot.urdf").write_text(ROBOT, "utf-8")
    (home / "table.sdf").write_text(TABLE, "utf-8")
    return home


def hash_of(file):
    """Of a scene as cc.World runs it."""
    world = cc.World(file, 0.005, False, threads=1)
    world.run(0.01, progress=False)
    return f"{world.hash:016x}"


@pytest.mark.parametrize("scene, name, values", [("robot.urdf", "mesh", [*MESHES]), ("table.sdf", "robot", ROBOTS)])
def test_scenes_find_their_meshes_as_in_a_world(scene, name, values, tmp_path, monkeypatch):
    """Robots, and scenes that include them, on any executor, whatever folder is the working one."""
    home = robot_in(tmp_path)
    text = f'scene = "{scene}"\n[parameters]\n{name} = {values}\nvoxel = 0.005\nseconds = 0.01\n'
    (home / "study.toml").write_text(text, "utf-8")
    monkeypatch.chdir(home.parent)
    made = study.load("urdf/study.toml")
    hashes = [hash_of(home / f"{n}.{scene.split('.')[1]}") for n in range(len(values))]
    assert name == "mesh" or len(set(hashes)) == len(set(MESHES.values())) + 1, "the table feels the height"
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    with concurrent.futures.ProcessPoolExecutor(1) as pool:
        places: list[Any] = ["local:2", pool]
        for on in places:
            with made.run(f"{type(on).__name__}.sqlite", on, progress=False) as results:
                assert [(r["status"], r["hash"]) for r in results.rows(None)] == [("done", h) for h in hashes]


def test_what_a_scene_includes_is_named_in_messages(tmp_path):
    home = robot_in(tmp_path)
    (home / "part.obj").unlink()
    (home / "2.urdf").write_text("<robot>", "utf-8")
    for robot, words in (("0.urdf", "table.sdf: body 'r' .* no file '.*/urdf/part.obj'"), ("2.urdf", "table.sdf: .*")):
        with pytest.raises(study.StudyError, match=words) as bad:
            study.Study(scene=home / "table.sdf", parameters={"robot": robot, "seconds": 1})
        assert "/tmp/tmp" not in str(bad.value)


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
