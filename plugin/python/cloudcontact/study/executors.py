"""Where trials run: local processes, a Dask cluster, MPI's ranks, or any executor of concurrent.futures."""

from __future__ import annotations

import concurrent.futures
import contextlib
import importlib
import os
import time
from typing import Any, Callable, Iterator, Optional, Union, cast

from .errors import StudyError

Executor = concurrent.futures.Executor
On = Union[str, Executor, Callable[[], Executor]]
ANSWER = 10.0  # seconds within which a scheduler answers
PLACES = "local, local:N, dask:ADDRESS or mpi"
EXECUTORS = "an executor of concurrent.futures, or a function that makes one"


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


def is_executor(thing: Any) -> bool:
    """Whether trials can be given to it; a class makes executors, and is none."""
    return callable(getattr(thing, "submit", None)) and not isinstance(thing, type)


def makes_executors(on: On) -> bool:
    return callable(on) and not is_executor(on)


@contextlib.contextmanager
def named(on: str) -> Iterator[Optional[Executor]]:
    """The executor of a text."""
    kind, _, rest = on.partition(":")
    where = f"on: '{on}'"
    if kind == "local" and (not rest or (rest.isdecimal() and int(rest) > 0)):
        with local(int(rest) if rest else processors()) as executor:
            yield executor
    elif kind == "dask" and rest:
        with dask(rest, where) as executor:
            yield executor
    elif on == "mpi":
        with mpi(where) as found:
            yield found
    else:
        raise StudyError(f"{where} is not known; give {PLACES}")


@contextlib.contextmanager
def made(on: Callable[[], Any]) -> Iterator[Executor]:
    """The executor that a function makes, open for as long as it is used."""
    thing = on()
    with thing if hasattr(thing, "__enter__") else contextlib.nullcontext(thing) as executor:
        if not is_executor(executor):
            raise StudyError(f"on: {getattr(on, '__name__', on)}() made {executor!r}; give {EXECUTORS}")
        yield executor


@contextlib.contextmanager
def open_executor(on: On) -> Iterator[Optional[Executor]]:
    """The executor that `on` means: "local", "local:N", "dask:ADDRESS", "mpi", an executor, or what makes one."""
    if isinstance(on, str):
        with named(on) as found:
            yield found
    elif is_executor(on):
        yield cast(Executor, on)
    elif callable(on):
        with made(on) as executor:
            yield executor
    else:
        raise StudyError(f"on: {on!r} is no place for trials; give {PLACES} as a text, {EXECUTORS}")
