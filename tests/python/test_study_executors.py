"""Studies on other executors, and what dies while they run: the same rows, each once, equal to the bit."""

import concurrent.futures
import contextlib
import json
import os
import pathlib
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from typing import Any

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


# Several studies in one process, and executors of the user's own.

GATE = """import os, pathlib, time
def wait(gate):
    pathlib.Path(gate + ".pid").write_text(f"{os.getpid()} ")
    while not pathlib.Path(gate).exists():
        time.sleep(0.01)
    return {"pid": os.getpid()}
"""


def gated(folder, *gates):
    """A study of a trial for each gate: it waits for a file of this name, and says before who it is."""
    (folder / "gate.py").write_text(GATE)
    gate: Any = [str(folder / name) for name in gates]
    return study.Study(trial="gate.py:wait", parameters={"gate": gate}, folder=folder)


def process_at(gate):
    """Of the trial that waits there."""
    file, end = gate.with_name(gate.name + ".pid"), time.monotonic() + 60
    while not (file.exists() and file.read_text().endswith(" ")):
        assert time.monotonic() < end, f"nobody is at {gate}"
        time.sleep(0.01)
    return int(file.read_text())


def await_end_of(pid):
    end = time.monotonic() + 10
    while pathlib.Path(f"/proc/{pid}").exists():
        assert time.monotonic() < end, "it goes on"
        time.sleep(0.01)


@pytest.mark.parametrize("way", ["ends", "is interrupted"])
def test_a_study_ends_its_own_processes_alone(way, tmp_path):
    """One waits in a thread while another, which has a trial that would wait for ever, ends."""
    other = gated(tmp_path, "other")
    run = threading.Thread(target=lambda: other.run(tmp_path / "other.sqlite", "local:1", progress=False).close())
    run.start()
    process_at(tmp_path / "other")
    (tmp_path / "free").touch()
    if way == "ends":
        gated(tmp_path, "free").run(tmp_path / "s.sqlite", "local:1", progress=False).close()
    else:

        def stop(share):
            process_at(tmp_path / "held")
            raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            gated(tmp_path, "free", "held").run(tmp_path / "s.sqlite", "local:2", progress=stop)
        await_end_of(process_at(tmp_path / "held"))
    (tmp_path / "other").touch()
    run.join(60)
    with study.Results(tmp_path / "other.sqlite") as results:
        assert results.counts == {"done": 1}
        assert results.database.execute("SELECT attempts FROM log").fetchall() == [(1,)]


def test_a_forked_worker_has_starters_of_its_own():
    """Another study may hold the lock just then."""
    process = study.process
    starter: Any = process.take_starter("a run")
    try:
        with process._lock:
            child = os.fork()
            if child == 0:
                free = process._lock.acquire(timeout=1) and starter.process.stdin.closed and not process._busy
                os._exit(0 if free else 1)
        assert os.waitpid(child, 0)[1] == 0
    finally:
        process.give_back(starter)
        process.end_starters("a run")
    assert starter.process.returncode == 0


class Here(concurrent.futures.Executor):
    """Works in submit()."""

    def submit(self, function, /, *words, **more):
        future: concurrent.futures.Future = concurrent.futures.Future()
        try:
            future.set_result(function(*words, **more))
        except BaseException as bad:
            future.set_exception(bad)
        return future


class Alike:
    """An executor by its methods alone."""

    def __init__(self):
        self.submit = Here().submit


class OneAtATime(concurrent.futures.ThreadPoolExecutor):
    """Whose submit() waits until a worker is free."""

    def __init__(self):
        super().__init__(1)
        self.free = threading.Semaphore(1)

    def submit(self, function, /, *words, **more):
        self.free.acquire()
        future = super().submit(function, *words, **more)
        future.add_done_callback(lambda _: self.free.release())
        return future


@pytest.mark.parametrize("kind, most", [(Here, 1), (Alike, 1), (OneAtATime, 12)])
def test_rows_are_written_while_submit_works(kind, most, tmp_path):
    """Of 40 trials of 20 ms; an executor that holds submit() up gives rows every tenth of a second."""
    (tmp_path / "t.py").write_text("import time\ndef t(n):\n    time.sleep(0.02)\n    return {}\n")
    made = study.Study(trial="t.py:t", parameters={"n": list(range(40))}, folder=tmp_path)
    rows: list[int] = []
    made.run(tmp_path / "s.sqlite", kind(), progress=lambda _: rows.append(rows_done(tmp_path / "s.sqlite"))).close()
    assert rows[-1] == 40 and max(after - before for before, after in zip([0, *rows], rows)) <= most


def starters():
    """Processes of this one that start trials."""
    out = []
    for pid in descendants(os.getpid()):
        with contextlib.suppress(OSError):
            out += [pid] if "study.process" in pathlib.Path(f"/proc/{pid}/cmdline").read_text() else []
    return out


def test_no_process_stays_after_a_run(tmp_path):
    """A pool of threads that goes on and one that is a function's, an executor that works in submit()."""
    gates = ["free", "open", "none"]
    for gate in gates:
        (tmp_path / gate).touch()
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for n, on in enumerate([pool, lambda: concurrent.futures.ThreadPoolExecutor(2), Here()]):
            with gated(tmp_path, *gates).run(tmp_path / f"{n}.sqlite", on, progress=False) as results:
                assert results.counts == {"done": 3}
            assert starters() == []


INTERRUPTED = """import sys
sys.path.insert(0, sys.argv[1])
from test_study_executors import *
gated(pathlib.Path(sys.argv[2]), "held").run("s.sqlite", Here(), progress=False)
"""


def test_ctrl_c_in_submit_ends_the_study(tmp_path):
    """Even where the executor catches it."""
    words = [sys.executable, "-c", INTERRUPTED, str(pathlib.Path(__file__).parent), str(tmp_path)]
    process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True, cwd=tmp_path)
    trial = process_at(tmp_path / "held")
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=30)
    assert process.returncode != 0 and "KeyboardInterrupt" in error
    await_end_of(trial)


class Deferred:
    """Whose futures do not tell when they end."""

    def submit(self, function, /, *words, **more):
        return "later"


@pytest.mark.parametrize(
    "on, words",
    [
        (4, "on: 4 is no place for trials; give local, .* mpi as a text, an executor"),
        (None, "on: None is no place"),
        (object(), "on: <object object at .*> is no place"),
        (lambda: 4, r"on: <lambda>\(\) made 4; give an executor of concurrent.futures"),
        (Deferred(), r"on: submit\(\) of .*Deferred.* returned a builtins.str; give an executor"),
        ("local:\u00b2", "on: 'local:\u00b2' is not known"),
    ],
)
def test_what_is_no_executor_is_named(on, words, tmp_path):
    (tmp_path / "free").touch()
    with pytest.raises(study.StudyError, match=words):
        gated(tmp_path, "free").run(tmp_path / "s.sqlite", on, progress=False)
