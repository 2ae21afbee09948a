"""Where trials run: local processes, a Dask cluster, MPI's ranks, or any executor of concurrent.futures."""

from __future__ import annotations

import concurrent.futures
import contextlib
import importlib
import os
import time
from typing import Any, Callable, Iterator, Optional, Union

from .errors import StudyError
from .process import end_starters

Executor = concurrent.futures.Executor
On = Union[str, Executor, Callable[[], Executor]]
ANSWER = 10.0  # seconds within which a scheduler answers


def processors() -> int:
    """Cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not Linux
        return os.cpu_count() or 1


@contextlib.contextmanager
def local(workers: int) -> Iterator[Executor]:
    """Threads that each wait for a process: a trial has one of its own anyway."""
    executor = concurrent.futures.ThreadPoolExecutor(workers)
    try:
        yield executor
    finally:
        executor.shutdown(wait=False, cancel_futures=True)
        end_starters()


def library(name: str, where: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as missing:
        raise StudyError(f"{where}: {missing}; pip install {name.split('.')[0]}") from None


def check_address(address: str) -> None:
    """Raises ValueError where it is no address: a Client does so, too, but then takes 20 s to be deleted."""
    comm = importlib.import_module("distributed.comm")
    scheme, host = comm.parse_address(address)
    importlib.import_module("distributed.comm.registry").get_backend(scheme)
    if scheme in ("tcp", "tls"):
        comm.parse_host_port(host)


def await_file(file: str) -> None:
    """Waits until a scheduler has written its file: a Client would do so for ever."""
    end = time.monotonic() + ANSWER
    while not os.path.isfile(file):
        if time.monotonic() > end:
            raise ValueError(f"no such file within {ANSWER:g} s")
        time.sleep(0.05)


@contextlib.contextmanager
def dask(address: str, where: str) -> Iterator[Executor]:
    """A cluster by its scheduler's address, or the file in which the scheduler wrote it."""
    distributed = library("distributed", where)
    place = {"scheduler_file": address} if address.endswith(".json") else {"address": address}
    try:
        if "address" in place:
            check_address(address)
        else:
            await_file(address)
        client = distributed.Client(**place, timeout=ANSWER, set_as_default=False)
    except (OSError, ValueError) as bad:
        raise StudyError(f"{where}: no Dask scheduler answers there ({bad}); start one with: dask scheduler") from None
    with client:
        yield client.get_executor(pure=False)


@contextlib.contextmanager
def mpi(where: str) -> Iterator[Optional[Executor]]:
    """The ranks of mpirun: an executor in the first; the others work until it is done, and get None."""
    futures, world = library("mpi4py.futures", where), library("mpi4py.MPI", where).COMM_WORLD
    if world.Get_size() == 1:
        raise StudyError(f"{where}: there is one MPI process; start several: mpirun -n 5 cloudcontact-study ...")
    with futures.MPICommExecutor(world, root=0) as executor:
        yield executor


@contextlib.contextmanager
def open_executor(on: On) -> Iterator[Optional[Executor]]:
    """The executor that `on` means: "local", "local:N", "dask:ADDRESS", "mpi", an executor, or what makes one."""
    if isinstance(on, Executor):
        yield on
        return
    if not isinstance(on, str):
        with on() as made:
            yield made
        return
    kind, _, rest = on.partition(":")
    where = f"on: '{on}'"
    if kind == "local" and (not rest or (rest.isdigit() and int(rest) > 0)):
        with local(int(rest) if rest else processors()) as executor:
            yield executor
    elif kind == "dask" and rest:
        with dask(rest, where) as executor:
            yield executor
    elif on == "mpi":
        with mpi(where) as found:
            yield found
    else:
        raise StudyError(f"{where} is not known; give local, local:N, dask:ADDRESS or mpi")
