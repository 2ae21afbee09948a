"""Runs the trials that are open on an executor and writes each as it ends.

What ends with its worker, or whose process ends, runs again, up to ATTEMPTS times; then its row says
"crashed". A row is written once, whatever an executor runs twice.
"""

from __future__ import annotations

import collections
import concurrent.futures
import queue
import time
import uuid
from typing import Callable, Optional, Sequence

from .errors import StudyError, StudyStopped
from .executors import EXECUTORS, On, makes_executors, open_executor
from .process import end_starters, run_task
from .results import Recorder
from .trial import Reply, Task

ATTEMPTS = 3
AHEAD = 10_000  # trials that an executor holds at most
TOGETHER = 200  # rows written in one go at most
BREATH = 0.1  # seconds of giving out trials after which those that have ended are written
Ended = Callable[[Sequence[Reply]], object]
Future = concurrent.futures.Future[Reply]


class Broken(Exception):
    """The executor takes no more work."""


class Run:
    """The trials that are still to end, over one executor or several in turn."""

    def __init__(self, tasks: Sequence[Task], recorder: Recorder, ended: Ended) -> None:
        self.waiting = collections.deque(tasks)
        self.recorder, self.ended = recorder, ended
        self.attempts: collections.Counter[int] = collections.Counter()
        self.running: dict[Future, Task] = {}
        self.left = len(tasks)

    def on(self, executor: concurrent.futures.Executor) -> None:
        """Until all trials have ended. Raises Broken where the executor breaks; what ran is waiting again then."""
        done: queue.SimpleQueue[Future] = queue.SimpleQueue()
        name = uuid.uuid4().hex
        try:
            while self.left:
                self.give_out(executor, name, done)
                futures = [done.get()]
                while not done.empty() and len(futures) < TOGETHER:
                    futures.append(done.get())
                self.take(futures)
        finally:
            for future in self.running:
                future.cancel()
            self.waiting.extendleft(reversed(self.running.values()))
            self.running.clear()
            end_starters(name)

    def give_out(self, executor: concurrent.futures.Executor, name: str, done: queue.SimpleQueue[Future]) -> None:
        """Submits what waits, until something has ended that should not wait in turn.

        An executor may work in submit(), or hold it up until a worker is free.
        """
        end = time.monotonic() + BREATH
        while self.waiting and len(self.running) < AHEAD:
            future = self.submit(executor, self.waiting[0], name)
            self.running[future] = self.waiting.popleft()
            future.add_done_callback(done.put)
            if future.done() or (time.monotonic() > end and not done.empty()):
                return

    def submit(self, executor: concurrent.futures.Executor, task: Task, name: str) -> Future:
        try:
            future = executor.submit(run_task, task, name)
        except RuntimeError as bad:  # broken, or shut down
            raise Broken(str(bad)) from bad
        if not isinstance(future, concurrent.futures.Future):
            kind = type(future)
            raise StudyError(
                f"on: submit() of {executor!r} returned a {kind.__module__}.{kind.__name__}; give {EXECUTORS}"
            )
        if future.done() and not future.cancelled() and isinstance(future.exception(), KeyboardInterrupt):
            raise KeyboardInterrupt  # Ctrl-C in a trial that submit() itself ran
        return future

    def take(self, futures: Sequence[Future]) -> None:
        """Writes what has ended, and lets the rest run again."""
        replies: list[Reply] = []
        broken: Optional[BaseException] = None
        for future in futures:
            task = self.running.pop(future)
            error = concurrent.futures.CancelledError("cancelled") if future.cancelled() else future.exception()
            if isinstance(error, concurrent.futures.BrokenExecutor):  # says nothing of this trial
                self.waiting.append(task)
                broken = error
                continue
            self.attempts[task.number] += 1
            reply = Reply(task.number, "died", error=f"its worker: {error!r}") if error else future.result()
            if reply.status == "died" and self.attempts[task.number] < ATTEMPTS:
                self.waiting.append(task)
                continue
            if reply.status == "died":
                reply.status, reply.error = "crashed", f"{reply.error}, {ATTEMPTS} times"
            replies.append(reply)
        if replies:
            self.recorder.record([(r, self.attempts[r.number]) for r in replies])
            self.left -= len(replies)
            self.ended(replies)
        if broken:
            raise Broken(str(broken)) from broken


def run_all(begin: Callable[[], Run], on: On) -> None:
    """Runs where `on` says what begin() makes, once there is an executor.

    Raises StudyStopped where the executor breaks and no other can be made.
    """
    run: Optional[Run] = None
    breaks = left = 0
    while True:
        try:
            with open_executor(on) as executor:
                if executor is not None:
                    run = run or begin()
                    left = run.left
                    run.on(executor)
            return
        except Broken as bad:
            assert run is not None
            breaks = breaks + 1 if run.left == left else 0
            if not makes_executors(on) or breaks >= ATTEMPTS:
                raise StudyStopped(
                    f"the executor broke: {bad}; {run.left} trials are left, run the study again"
                ) from bad
