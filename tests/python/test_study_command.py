"""Studies: the command cloudcontact-study."""

import json
import re
import shutil
import subprocess

import pytest
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
        ([file, "--results", tmp_path], "results: '.*' is a folder; give a file in it"),
        ([file, "--plots", file], "--plots: no folder '.*pegs.toml' can be made: File exists"),
    ):
        code, out, error = command(*words)
        assert code == 2 and re.search(message, error) and not out, error
        assert "Traceback" not in error


def options():
    """Those of the help, each at the beginning of its line."""
    return set(re.findall(r"^  (?:-\w, )?(--[a-z]+)", command("--help")[1], re.M))


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_shells_complete_all_options(shell):
    code, out, _ = command("--completion", shell)
    assert code == 0 and len(options()) == 12
    for option in options():
        assert (f"-l {option[2:]} " if shell == "fish" else option) in out
    if shutil.which(shell):
        assert subprocess.run([shell, "-n"], input=out, text=True).returncode == 0


@pytest.mark.parametrize(
    "words, offered",
    [("--sum", "--summary"), ("--completion f", "fish"), ("peg", "pegs.toml"), ("pegs.toml --on", "--on")],
)
def test_bash_completes(words, offered, tmp_path):
    (tmp_path / "pegs.toml").touch()
    line = words.split()
    ask = f"COMP_WORDS=(cloudcontact-study {words})\nCOMP_CWORD={len(line)}\n_cloudcontact_study\n"
    script = command("--completion", "bash")[1] + ask + "echo ${COMPREPLY[*]}\n"
    done = subprocess.run(["bash"], input=script, capture_output=True, text=True, cwd=tmp_path)
    assert (done.stdout, done.stderr) == (offered + "\n", "")


def test_the_manual_page_has_the_help_and_the_examples():
    code, out, _ = command("--manual")
    text = out.replace("\\-", "-")
    assert code == 0 and text.startswith(".TH CLOUDCONTACT-STUDY 1")
    examples = re.findall(r"^  (.*cloudcontact-study .*)$", command("--help")[1], re.M)
    assert len(examples) >= 8
    for words in [*options(), *examples]:
        assert words in text
    if shutil.which("groff"):
        done = subprocess.run(["groff", "-man", "-Tascii", "-ww"], input=out, capture_output=True, text=True)
        assert done.returncode == 0 and done.stderr == ""
