"""Runs every Python sample of the guide to Python, as it stands there. Those of the guide to studies have tests of their own."""

import pathlib
import re
from typing import Any

import numpy as np
from conftest import box_arrays, write_obj

SOURCE = pathlib.Path(__file__).parents[2]


def samples(document):
    return re.findall(r"^```python\n(.*?)^```", (SOURCE / document).read_text(), re.S | re.M)


def test_the_samples_of_the_guide_to_python_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name, size in {"nut": [8, 8, 8], "part": [40, 30, 20]}.items():
        write_obj(tmp_path / f"{name}.obj", *box_arrays(size))
    vertices, triangles = box_arrays([0.008] * 3)
    values = np.full((10, 10, 10), -1000, np.float32)
    values[2:8, 2:8, 2:8] = 1200
    values[4:6, 4:6, 4:6] = 2400
    names: dict[str, Any] = {"vertices": vertices, "triangles": triangles, "values": values}
    parts = [s for s in samples("docs/python.md") if "study" not in s]
    assert len(parts) == 2
    for part in parts:
        exec(compile(part.replace(".stl", ".obj"), "docs/python.md", "exec"), names)
    assert names["tooth"].materials == ["dentin", "enamel"]
    assert names["found"].force[2] > 1
    assert abs(names["found"].points["normal"][:, 2]).min() > 0.999
    assert 0.0095 < names["world"]["part"].position[2] < 0.0105
    assert (tmp_path / "run.html").stat().st_size > 100_000
    assert capsys.readouterr().out.count("\n") > 100


def test_the_pegs_of_the_guide_to_learning_come_home(capsys):
    parts = samples("docs/guides/learning.md")
    assert len(parts) == 3
    names: dict[str, Any] = {}
    for part in (parts[0], parts[2]):  # test_gymnasium.py runs the second
        exec(compile(part, "docs/guides/learning.md", "exec"), names)
    assert capsys.readouterr().out.startswith("64 of 64 are home")
