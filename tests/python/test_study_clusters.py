"""Studies on clusters, Dask's and MPI's, of which parts are killed: the same rows, each once, equal to the bit."""

import contextlib
import importlib.util
import json
import os
import pathlib
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import time

import pytest
from study_samples import COMMAND, TRIALS, check, descendants, one_by_one, rows_done, start, wait_for_rows, write_pegs

from cloudcontact import study

needs_dask = pytest.mark.skipif(importlib.util.find_spec("distributed") is None, reason="no dask.distributed")
needs_mpi = pytest.mark.skipif(
    importlib.util.find_spec("mpi4py") is None or shutil.which("mpirun") is None, reason="no mpi4py or no mpirun"
)
# Open MPI needs flags to run as root and with more ranks than cores. It looks for ssh, which one machine does not need.
MPI = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_plm": "isolated",
    "OMPI_MCA_btl_vader_single_copy_mechanism": "none",  # which containers forbid, with a line on stderr
}


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    return one_by_one(tmp_path_factory.mktemp("reference"))


# Dask.


@contextlib.contextmanager
def cluster(folder, workers):
    """A scheduler and workers over TCP, each a process; yields the scheduler's file and the workers."""
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder}
    file = folder / "scheduler.json"
    module = [sys.executable, "-m", "distributed.cli.dask_"]
    scheduler = [*module[:2], module[2] + "scheduler", "--host", "tcp://127.0.0.1", "--port", "0", "--no-dashboard"]
    processes = [subprocess.Popen([*scheduler, "--scheduler-file", str(file)], **quiet)]
    words = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--scheduler-file", str(file)]
    try:
        for _ in range(workers):
            processes.append(subprocess.Popen([*module[:2], module[2] + "worker", *words], **quiet))
        yield file, processes[1:]
    finally:
        for process in processes:
            process.kill()
            process.wait()


@needs_dask
def test_a_dask_cluster_with_a_worker_killed(tmp_path, reference):
    path = tmp_path / "pegs.sqlite"
    with cluster(tmp_path, 4) as (file, workers):
        end = time.monotonic() + 60
        while not file.exists():
            assert time.monotonic() < end, "the scheduler did not start"
            time.sleep(0.05)
        address = json.loads(file.read_text())["address"]
        assert address.startswith("tcp://")
        process = start(write_pegs(tmp_path), "--on", f"dask:{address}")
        wait_for_rows(path, 4, process)
        working = {pid for pid, in sqlite3.connect(path).execute("SELECT process FROM log")}
        assert working
        workers[0].kill()
        out, error = process.communicate(timeout=240)
        assert process.returncode == 0, error
        check(path, reference)
        made = study.load(tmp_path / "pegs.toml")
        made.run(tmp_path / "file.sqlite", f"dask:{file}", progress=False).close()
    check(tmp_path / "file.sqlite", reference)


@needs_dask
@pytest.mark.parametrize(
    "address, why",
    [
        ("tcp://127.0.0.1:9", "Timed out"),
        ("nowhere", "missing port"),
        ("pigeon://here:1", "scheme 'pigeon'"),
        ("none.json", "no such file"),
    ],
)
def test_no_dask_cluster(address, why, tmp_path, monkeypatch):
    monkeypatch.setattr(study.executors, "ANSWER", 1.0)
    made = study.load(write_pegs(tmp_path))
    with pytest.raises(study.StudyError, match=f"on: 'dask:{address}': no Dask scheduler answers there .*{why}"):
        made.run(tmp_path / "pegs.sqlite", f"dask:{address}")
    assert not (tmp_path / "pegs.sqlite").exists()


# MPI.


def mpirun(ranks, *words):
    done = subprocess.run(
        ["mpirun", "-n", str(ranks), *COMMAND, *map(str, words)],
        capture_output=True, text=True, timeout=240, env={**os.environ, **MPI},
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


@needs_mpi
def test_mpi(tmp_path, reference):
    file = write_pegs(tmp_path)
    code, out, error = mpirun(3, file, "--on", "mpi", "--json")
    assert code == 0, error
    assert json.loads(out)["counts"] == {"done": TRIALS}, "one rank speaks"
    check(tmp_path / "pegs.sqlite", reference)


@needs_mpi
def test_mpi_in_a_program(tmp_path, reference):
    """All ranks run it, and all get the results."""
    write_pegs(tmp_path)
    (tmp_path / "program.py").write_text(
        "from cloudcontact import study\n"
        "results = study.load('pegs.toml').run('pegs.sqlite', 'mpi')\n"
        "print(results.counts)\n"
    )
    done = subprocess.run(
        ["mpirun", "-n", "2", sys.executable, "program.py"],
        capture_output=True, text=True, timeout=240, cwd=tmp_path, env={**os.environ, **MPI},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.count(str({"done": TRIALS})) == 2
    check(tmp_path / "pegs.sqlite", reference)


@needs_mpi
def test_an_mpi_job_that_is_killed_goes_on(tmp_path, reference):
    path = tmp_path / "pegs.sqlite"
    file = write_pegs(tmp_path)
    words = ["mpirun", "-n", "3", *COMMAND, str(file), "--on", "mpi"]
    process = subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, **MPI}
    )
    wait_for_rows(path, 4, process)
    ranks = [pid for pid in descendants(process.pid) if "--on mpi" in cmdline(pid)]
    os.kill(ranks[-1], signal.SIGKILL)
    process.communicate(timeout=60)
    assert process.returncode != 0
    assert 4 <= rows_done(path) < TRIALS
    code, _, error = mpirun(3, file, "--on", "mpi")
    assert code == 0, error
    check(path, reference)


def cmdline(pid):
    with contextlib.suppress(OSError):
        return pathlib.Path(f"/proc/{pid}/cmdline").read_text().replace("\0", " ")
    return ""


@needs_mpi
def test_bad_input_ends_all_ranks(tmp_path):
    code, out, error = mpirun(2, tmp_path / "none.toml", "--on", "mpi")
    assert code == 2 and len(re.findall("none.toml: No such file", error)) == 1
    code, out, error = mpirun(1, write_pegs(tmp_path), "--on", "mpi")
    assert code == 2 and "there is one MPI process; start several" in error
