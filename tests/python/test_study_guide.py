"""Studies: the samples of docs/studies.md and docs/python.md, and docstrings."""

import re
import sqlite3
from typing import Any

import numpy as np
import pytest
from study_samples import GUIDE, SOURCE, command, sample, write_pegs

from cloudcontact import study


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


def test_docstrings_and_types_are_there():
    for name in study.__all__:
        thing = getattr(study, name)
        assert thing.__doc__, name
        for line in thing.__doc__.split("\n"):
            assert len(line) <= 110
