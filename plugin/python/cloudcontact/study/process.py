"""Each trial in a process of its own.

A worker (a thread, or a process of any executor) keeps a starter: a Python that has imported the
package and forks a child for each trial. So a trial that ends its process, or takes too long, ends
nothing else, and no trial sees what another left behind. The starter ends when its worker does, as its
input then ends, and takes a running trial with it. In the process of the study it ends with the run.
"""

from __future__ import annotations

import contextlib
import gc
import os
import pickle
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
from typing import IO, Any, Callable, Optional, Sequence, Tuple

from .trial import Reply, Task, prepare, run_trial, versions

LENGTH = struct.Struct("<Q")
LONGEST = 3600.0  # seconds of one wait: select() takes no more than some centuries
MOST_OUTPUT = 4000  # characters of a trial's output that are kept, the last ones
# Libraries of numpy start threads at import; a process that forks should have none.
SINGLE = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}


def send(pipe: int, thing: Any) -> None:
    data = pickle.dumps(thing)
    view = memoryview(LENGTH.pack(len(data)) + data)
    while view:
        view = view[os.write(pipe, view) :]


def take(pipe: int, size: int) -> bytes:
    out = b""
    while len(out) < size:
        part = os.read(pipe, size - len(out))
        if not part:
            raise EOFError
        out += part
    return out


def receive(pipe: int) -> Any:
    return pickle.loads(take(pipe, LENGTH.unpack(take(pipe, LENGTH.size))[0]))


def tail(log: IO[bytes]) -> str:
    """The end of what a trial wrote."""
    log.seek(max(0, log.seek(0, os.SEEK_END) - MOST_OUTPUT))
    return log.read().decode(errors="replace").strip()


def child(task: Task, answer: int, log: IO[bytes], pipes: Sequence[int]) -> None:
    """The trial's process, which it ends. pipes: the starter's, which are not its own."""
    code = 1
    try:
        for pipe in pipes:
            os.close(pipe)
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)
        reply = run_trial(task)
        sys.stdout.flush()
        sys.stderr.flush()
        send(answer, reply)
        code = 0
    finally:
        os._exit(code)


def await_answer(answer: int, requests: int, timeout: Optional[float]) -> Tuple[str, Optional[Reply]]:
    """What the child sends: a Reply; or "timeout", "died", or "left" where the worker has ended."""
    end = None if timeout is None else time.monotonic() + timeout
    while True:
        left = None if end is None else min(max(0.0, end - time.monotonic()), LONGEST)
        ready, _, _ = select.select([answer, requests], [], [], left)
        if answer in ready:
            try:
                return "", receive(answer)
            except EOFError:
                return "died", None
        if requests in ready:  # a worker asks again only after the answer: this is its end
            return "left", None
        if end is not None and time.monotonic() >= end:
            return "timeout", None


def fork_trial(task: Task, requests: int, replies: int) -> Optional[Reply]:
    """Runs a trial in a child. None where nobody waits for it any more."""
    start = time.monotonic()
    answer, inner = os.pipe()
    with tempfile.TemporaryFile() as log:
        pid = os.fork()
        if pid == 0:
            child(task, inner, log, (answer, requests, replies))
        os.close(inner)
        why, reply = await_answer(answer, requests, task.timeout)
        os.close(answer)
        if why in ("timeout", "left"):
            os.kill(pid, signal.SIGKILL)
        _, status = os.waitpid(pid, 0)
        if why == "left":
            return None
        if reply is None:
            reply = Reply(task.number, why, error=f"took longer than {task.timeout} s")
            if why == "died":
                reply.error = death(status)
        reply.output = tail(log)
    reply.seconds, reply.host, reply.process = time.monotonic() - start, socket.gethostname(), pid
    return reply


def death(status: int) -> str:
    code = os.waitstatus_to_exitcode(status)
    if code >= 0:
        return f"its process ended with code {code}"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = str(-code)
    return f"its process was ended by signal {name}"


def quietly(work: Callable[[Task], None], task: Task) -> None:
    """Without a word: the trial itself says it again."""
    kept, nothing = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 2)
    try:
        work(task)
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nothing)


def serve() -> None:
    """The starter's life: tasks come by its input, replies go by its output."""
    requests, replies = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    versions()  # once for all trials
    warm = False
    while True:
        try:
            task = receive(requests)
        except EOFError:
            return
        reply = fork_trial(task, requests, replies)
        if reply is None:
            return
        send(replies, reply)
        if not warm and reply.status == "done":  # in a process of its own nothing went wrong
            warm = True
            quietly(prepare, task)
            gc.freeze()  # or each child's collector copies the pages of all that is there


class Starter:
    """A worker's end of the pipes to a starter, and the run of a study that it works for."""

    def __init__(self) -> None:
        code = "import sys; sys.path[:] = sys.argv[1:]; from cloudcontact.study.process import serve; serve()"
        self.whose = ""
        self.process = subprocess.Popen(
            [sys.executable, "-c", code, *(p or os.getcwd() for p in sys.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, **SINGLE},
            bufsize=0,
            start_new_session=True,  # Ctrl-C is the study's, which then ends its starters
        )
        assert self.process.stdin and self.process.stdout
        self.requests, self.replies = self.process.stdin.fileno(), self.process.stdout.fileno()

    def run(self, task: Task) -> Reply:
        send(self.requests, task)
        reply = receive(self.replies)
        assert isinstance(reply, Reply)
        return reply

    def kill(self) -> None:
        """It and the trial that it runs: its session is a group of processes."""
        if self.process.returncode is None:  # else the number may be another's
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.process.pid, signal.SIGKILL)

    def close_pipes(self) -> None:
        """It ends, as nobody is left who asks."""
        assert self.process.stdin and self.process.stdout
        self.process.stdin.close()
        self.process.stdout.close()

    def close(self) -> None:
        self.close_pipes()
        self.process.wait()


# Those of this process. A worker serves the runs of several studies, in turn or at once.
_idle: list[Starter] = []
_busy: list[Starter] = []
_ended: set[str] = set()  # runs that work no more here
_lock = threading.Lock()


def forget_starters() -> None:
    """In a worker that was forked: they are its parent's, and so may be what holds the lock."""
    global _lock
    _lock = threading.Lock()
    for starter in (*_idle, *_busy):
        starter.close_pipes()
    _idle.clear()
    _busy.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=forget_starters)


def take_starter(run: str) -> Optional[Starter]:
    """One for a trial of a run; none where the run has ended."""
    with _lock:
        if run in _ended:
            return None
        starter = _idle.pop() if _idle else Starter()
        starter.whose = run
        _busy.append(starter)
    return starter


def give_back(starter: Starter) -> None:
    with _lock:
        _busy.remove(starter)
        late = starter.whose in _ended
        if not late:
            _idle.append(starter)
    if late:
        starter.close()


def end_starters(run: str) -> None:
    """Ends those of a run in this process, and what they run; it gets no other here."""
    with _lock:
        _ended.add(run)
        idle = [s for s in _idle if s.whose == run]
        _idle[:] = [s for s in _idle if s.whose != run]
        for starter in _busy:
            if starter.whose == run:
                starter.kill()  # its worker sees it and closes it
    for starter in idle:
        starter.close_pipes()
    for starter in idle:
        starter.process.wait()


def run_task(task: Task, run: str) -> Reply:
    """What an executor runs: a trial in a process of its own. run: of the study, for end_starters()."""
    starter = take_starter(run)
    if starter is None:
        return Reply(task.number, "died", error="its study has ended")
    try:
        reply = starter.run(task)
    except BaseException as bad:
        starter.kill()
        starter.close()
        with _lock:
            _busy.remove(starter)
        if not isinstance(bad, (EOFError, OSError)):  # Ctrl-C in a worker
            raise
        return Reply(task.number, "died", error="the process that starts trials was ended", host=socket.gethostname())
    give_back(starter)
    return reply
