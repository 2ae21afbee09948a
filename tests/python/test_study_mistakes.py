"""Studies: files, scenes and functions that cannot run are named."""

from typing import Any

import pytest
import study_samples as samples
from study_samples import SOURCE, sample, write_pegs

from cloudcontact import study


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
        (("scene = ", "watch = [7]\nscene = "), "watch: 7 is no name of a body"),
        (("clearance = \"m\"", "clearence = 'm'"), "units.clearence: is no outcome and .* did you mean 'clearance'"),
        (("clearance = \"m\"", "clearance = 7"), "units: must be texts by the names"),
        (("friction = 0.2", "law = 'rigid:3'"), "law: 'rigid:3' is not known"),
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


def test_a_file_of_functions_that_cannot_be_read_is_named(tmp_path):
    (tmp_path / "t.py").write_bytes(b"# \xfc\ndef t(n):\n    return {}\n")
    with pytest.raises(study.StudyError, match="trial: cannot read '.*t.py'"):
        study.Study(trial="t.py:t", parameters={"n": 1}, folder=tmp_path)
    (tmp_path / "t.py").write_bytes(b"# coding: latin-1\ndef t(n):\n    return {'u': '\xfc'}\n")
    assert study.Study(trial="t.py:t", parameters={"n": 1}, folder=tmp_path).once() == {"u": "\u00fc"}


def test_functions_import_from_their_own_folder(tmp_path):
    """Two studies in one process whose functions import files of the same name."""
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "shared_name.py").write_text(f"VALUE = '{name}'\n")
        (tmp_path / name / "t.py").write_text("def t(n):\n    import shared_name as s\n    return {'v': s.VALUE}\n")
    made = [study.Study(trial="t.py:t", parameters={"n": 1}, folder=tmp_path / name) for name in ("one", "two")]
    for name, one in zip(("one", "two"), made):
        with one.run(tmp_path / f"{name}.sqlite", "local:1", progress=False) as results:
            assert results.rows()[0]["v"] == name


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
        ({"trial": samples.square, "watch": "peg", "parameters": {"n": 1}}, "watch: 'peg' is no list of names"),
        ({"trial": samples.square, "success": "n <", "parameters": {"n": 1}}, "success: 'n <' is no expression"),
        ({"trial": samples.square, "success": max, "parameters": {"n": 1}}, "success: must be a text"),
        ({"trial": samples.square, "units": ["m"], "parameters": {"n": 1}}, "units: must be texts by the names"),
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
