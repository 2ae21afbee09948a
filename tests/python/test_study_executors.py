"""Studies on other executors, and what dies while they run: the same rows, each once, equal to the bit."""

import concurrent.futures
import contextlib
import json
import os
import pathlib
import signal
import sqlite3
import time

import pytest
from study_samples import TRIALS, check, command, descendants, one_by_one, rows_done, start, wait_for_rows, write_pegs

from cloudcontact import study


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    return one_by_one(tmp_path_factory.mktemp("reference"))


def test_any_number_of_processes(tmp_path, reference):
    made = study.load(write_pegs(tmp_path))
    made.run(tmp_path / "three.sqlite", "local:3", progress=False).close()
    check(tmp_path / "three.sqlite", reference)


def test_executors_of_the_standard_library(tmp_path, reference):
    made = study.load(write_pegs(tmp_path))
    for make in (concurrent.futures.ThreadPoolExecutor, concurrent.futures.ProcessPoolExecutor):
        path = tmp_path / f"{make.__name__}.sqlite"
        with make(2) as executor:
            made.run(path, executor, progress=False).close()
        check(path, reference)


def test_an_executor_that_breaks(tmp_path, reference):
    """A worker of a pool is killed: one that can be made again goes on, another is a message, and then goes on."""
    made = study.load(write_pegs(tmp_path))
    pools = []

    def pool():
        pools.append(concurrent.futures.ProcessPoolExecutor(2))
        return pools[-1]

    def kill_one(done):
        if done > 0.2 and len(pools) == 1 and not pools[0]._broken:
            os.kill(next(iter(pools[0]._processes)), signal.SIGKILL)

    made.run(tmp_path / "renewed.sqlite", pool, progress=kill_one).close()
    assert len(pools) == 2
    check(tmp_path / "renewed.sqlite", reference)
    del pools[:]
    with pytest.raises(study.StudyStopped, match="trials are left, run the study again"):
        made.run(tmp_path / "stopped.sqlite", pool(), progress=kill_one)
    assert 0 < rows_done(tmp_path / "stopped.sqlite") < TRIALS
    made.run(tmp_path / "stopped.sqlite", "local:2", progress=False).close()
    check(tmp_path / "stopped.sqlite", reference)


def test_workers_that_are_killed(tmp_path, reference):
    """Each process that a local study has started is killed once."""
    path = tmp_path / "pegs.sqlite"
    process = start(write_pegs(tmp_path), "--on", "local:2")
    for least in (3, 8):
        wait_for_rows(path, least, process)
        for pid in descendants(process.pid):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
    out, error = process.communicate(timeout=240)
    assert process.returncode == 0, error
    check(path, reference)
    attempts = sqlite3.connect(path).execute("SELECT max(attempts) FROM log").fetchone()[0]
    assert attempts > 1


@pytest.mark.parametrize("way", [signal.SIGKILL, signal.SIGINT])
def test_a_study_that_is_killed_goes_on(way, tmp_path_factory, reference):
    folder = tmp_path_factory.mktemp("killed")
    path = folder / "pegs.sqlite"
    process = start(write_pegs(folder), "--on", "local:2")
    wait_for_rows(path, 6, process)
    children = descendants(process.pid)
    process.send_signal(way)
    _, error = process.communicate(timeout=60)
    assert process.returncode == (-9 if way == signal.SIGKILL else 130), error
    assert way == signal.SIGKILL or "run it again to go on" in error and "Traceback" not in error
    before = rows_done(path)
    assert 6 <= before < TRIALS
    ended = dict(sqlite3.connect(path).execute("SELECT number, ended || process FROM log"))
    end = time.monotonic() + 30
    while any(pathlib.Path(f"/proc/{pid}").exists() for pid in children):
        assert time.monotonic() < end, "its processes go on without it"
        time.sleep(0.05)
    assert rows_done(path) == before
    code, out, error = command(folder / "pegs.toml", "--on", "local:2", "--json")
    assert code == 0 and json.loads(out)["counts"] == {"done": TRIALS}, error
    check(path, reference)
    after = dict(sqlite3.connect(path).execute("SELECT number, ended || process FROM log"))
    assert {n: after[n] for n in ended} == ended, "what was done did not run again"


def test_two_studies_at_once_on_one_file(tmp_path, reference):
    path = tmp_path / "pegs.sqlite"
    process = start(write_pegs(tmp_path), "--on", "local:1")
    wait_for_rows(path, 2, process)
    code, _, error = command(tmp_path / "pegs.toml", "--on", "local:1")
    assert code == 2 and "another study writes it now" in error
    assert process.wait(timeout=240) == 0
    process.communicate()
    check(path, reference)


def test_what_is_not_installed_is_named(tmp_path):
    """Without dask, mpi4py and matplotlib studies run; what needs them says what to install."""
    (tmp_path / "bare").mkdir()
    for name in ("distributed", "mpi4py", "matplotlib"):
        (tmp_path / "bare" / f"{name}.py").write_text(f"raise ImportError('no {name}')\n")
    file = write_pegs(tmp_path, 1, 1)
    bare = {**os.environ, "PYTHONPATH": f"{tmp_path / 'bare'}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"}
    for words, extra in (
        (["--on", "dask:tcp://a:1"], "distributed"),
        (["--on", "mpi"], "mpi4py"),
        (["--plots", tmp_path], "matplotlib"),
    ):
        code, _, error = command(file, *words, env=bare)
        assert code == 2 and f"pip install {extra}" in error, error
    assert not (tmp_path / "pegs.sqlite").exists()
    assert command(file, env=bare)[0] == 0 and rows_done(tmp_path / "pegs.sqlite") == 1
