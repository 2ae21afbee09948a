"""One trial: what a worker gets, what it does, what comes back. A trial depends on nothing but its Task."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import pathlib
import platform
import sys
import traceback
from dataclasses import dataclass, field
from typing import Any, Mapping, Optional, Tuple

import numpy as np

from .. import _core
from .design import RESERVED, number
from .errors import StudyError, meant
from .expressions import Expression
from .functions import Shipped, call, words_of
from .scenes import SceneFile, run_scene, settings_of, world_of

MOST_NUMBERS = 32


@dataclass(frozen=True)
class Work:
    """What is tried: a function that measures, or a scene (a file, a function that makes it) that runs."""

    function: Optional[Shipped] = None
    scene: Optional[SceneFile] = None
    makes_scene: bool = False
    success: str = ""
    watch: Optional[Tuple[str, ...]] = None


@dataclass(frozen=True)
class Task:
    """A trial for a worker. timeout [s] of the clock; none: no limit."""

    number: int
    seed: int
    parameters: dict[str, Any]
    work: Work
    timeout: Optional[float] = None


@dataclass
class Reply:
    """What came of a trial.

    status: "done"; "failed" with an error; "timeout"; or "died", its process, which is tried again.
    """

    number: int
    status: str
    outcomes: dict[str, Any] = field(default_factory=dict)
    error: str = ""
    versions: str = ""
    seconds: float = 0.0
    host: str = ""
    process: int = 0
    output: str = ""


@functools.lru_cache(maxsize=1)
def versions() -> str:
    """Of what computes: the package, its compiled module by its bytes, numpy, Python, the processor's kind."""
    module = hashlib.sha256(pathlib.Path(_core.__file__).read_bytes()).hexdigest()[:12]
    python = ".".join(map(str, sys.version_info[:3]))
    return f"cloudcontact {_core.__version__} ({module}), numpy {np.__version__}, Python {python}, {platform.machine()}"


def scalar(name: str, value: Any) -> Any:
    """What a column of SQLite holds."""
    value = number(value)
    if value is None or isinstance(value, float):
        return value
    if isinstance(value, str):
        return str.__str__(value)  # not of a class of the function's, which nobody else has
    if isinstance(value, (bool, int)):
        return int(value) if abs(int(value)) < 2**63 else hex(value)
    raise TypeError(f"outcome '{name}': {type(value).__name__} is no number, text or bool; give these or a list")


def flat(outcomes: Mapping[str, Any]) -> dict[str, Any]:
    """As columns: a list of three becomes name_x, name_y, name_z, another name_0, name_1 ..."""
    out: dict[str, Any] = {}
    for name, value in outcomes.items():
        if not isinstance(name, str) or not name.isidentifier():
            raise TypeError(f"outcome {name!r}: is no name; give letters, digits and _")
        columns = {name: value}
        if isinstance(value, (list, tuple, np.ndarray)) and getattr(value, "ndim", 1) == 1:
            if len(value) > MOST_NUMBERS:
                raise TypeError(f"outcome '{name}': {len(value)} numbers; give {MOST_NUMBERS} or fewer")
            columns = {f"{name}_{e}": v for e, v in zip("xyz" if len(value) == 3 else range(len(value)), value)}
        for column, one in columns.items():
            if column in out:
                raise TypeError(f"outcome '{column}': another outcome has this name; give another")
            out[column] = scalar(name, one)
    return out


def measured(task: Task) -> dict[str, Any]:
    """The outcomes, without success."""
    work, values = task.work, task.parameters
    if work.scene is not None:
        settings = settings_of(values, work.scene.template.names)
        return run_scene(work.scene.load(values, task.seed), settings, work.watch)
    assert work.function is not None
    if work.makes_scene:
        own = words_of(work.function.load(), values)
        return run_scene(made_scene(task), settings_of(values, own), work.watch)
    outcomes = call(work.function.load(), values, task.seed)
    if not isinstance(outcomes, Mapping):
        raise TypeError(f"{work.function.label}: returned {type(outcomes).__name__}; give a dict of outcomes")
    return dict(outcomes)


def prepare(task: Task) -> None:
    """Makes the world of a trial, so that processes forked from this one have its shapes. Never raises.

    On the CPU: drivers of devices do not survive a fork.
    """
    work, values = task.work, task.parameters
    if work.scene is None:
        return
    with contextlib.suppress(Exception):
        settings = {**settings_of(values, work.scene.template.names), "backend": "cpu"}
        world_of(work.scene.load(values, task.seed), settings)


def made_scene(task: Task) -> _core.Scene:
    """Of a function that makes it, from the parameters that it takes."""
    assert task.work.function is not None
    function = task.work.function.load()
    scene = call(function, words_of(function, task.parameters), task.seed)
    if not isinstance(scene, _core.Scene):
        raise TypeError(f"{task.work.function.label}: returned {type(scene).__name__}; give a Scene")
    return scene


def run_here(task: Task) -> dict[str, Any]:
    """The columns of a trial, computed here and now."""
    out = flat(measured(task))
    taken = {*RESERVED, *(n.lower() for n in task.parameters)}
    for name in out:  # SQLite's columns know no capitals
        if name.lower() in taken:
            raise TypeError(f"outcome '{name}': another column has this name; give another")
        taken.add(name.lower())
    if task.work.success:
        if "success" in out:
            raise TypeError("outcome 'success': the study states it too; leave one of the two out")
        truth = Expression(task.work.success, "success")({**task.parameters, **out})
        out["success"] = int(bool(truth))
    if isinstance(out.get("success"), str):
        raise TypeError(f"outcome 'success': {out['success']!r} is a text; give true or false")
    return out


def run_trial(task: Task) -> Reply:
    """Runs it in this process; what it raises is its error."""
    reply = Reply(task.number, "done", versions=versions())
    try:
        reply.outcomes = run_here(task)
    except Exception as bad:
        traceback.print_exc()
        reply.status, reply.error = "failed", f"{type(bad).__name__}: {bad}"
        if isinstance(bad, StudyError):
            reply.error = str(bad)
    return reply


def known_names(names: set[str], text: str) -> None:
    """That `success` uses these names alone."""
    for name in sorted(Expression(text, "success").names - names):
        raise StudyError(f"success: '{name}' is no outcome and no parameter{meant(name, names)}")
