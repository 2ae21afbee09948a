"""Studies: the command cloudcontact-study."""

import json
import re

from study_samples import command, write_pegs


def test_help_has_examples_and_all_options():
    code, out, _ = command("--help")
    assert code == 0 and "examples:" in out and "mpirun" in out
    for option in ("--on", "--results", "--plots", "--again", "--try", "--summary", "--json", "--quiet", "--version"):
        assert option in out


def test_try_runs_one_trial_and_writes_nothing(tmp_path):
    write_pegs(tmp_path)
    code, out, error = command(tmp_path / "pegs.toml", "--try", 3)
    assert code == 0 and json.loads(out)["number"] == 3 and json.loads(out)["success"] in (0, 1)
    assert not (tmp_path / "pegs.sqlite").exists()
    assert command(tmp_path / "pegs.toml", "--try", 24)[0] == 2


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
