"""A study: what is tried, its parameters, its trials."""

from __future__ import annotations

import contextlib
import hashlib
import os
import pathlib
from typing import Any, Callable, Iterable, Mapping, Optional, Sequence, Union

from .. import _core
from .._progress import Progress, TextLine, reporter
from .design import Parameter, Point, finite, number, plan
from .errors import StudyError, meant
from .executors import On, open_executor
from .expressions import Expression
from .functions import Shipped, check_call, loaded, ship, words_of
from .results import Lock, Recorder, Results
from .running import Run, run_all
from .scenes import SETTINGS, SceneFile, check_settings, outcomes_of, settings_of
from .trial import Reply, Task, Work, known_names, made_scene, run_here

MOST_COLUMNS = 1500


def names_of(watch: Any) -> tuple[str, ...]:
    """Of bodies: a text alone would be its letters."""
    if isinstance(watch, str) or not isinstance(watch, Iterable):
        raise StudyError(f"watch: {watch!r} is no list of names; give one, as ['peg']")
    names = tuple(watch)
    for name in names:
        if not isinstance(name, str):
            raise StudyError(f"watch: {name!r} is no name of a body")
    return names


def units_of(units: Any) -> dict[str, str]:
    if not isinstance(units, Mapping) or not all(isinstance(text, str) for pair in units.items() for text in pair):
        raise StudyError("units: must be texts by the names of parameters and outcomes, as {'offset': 'm'}")
    return dict(units)


class Study:
    """Trials of a scene or a function over parameters, each in a process of its own.

    A trial depends on its parameters and its seed alone, so a study has the same rows wherever it runs.
    """

    def __init__(
        self,
        name: str = "study",
        *,
        scene: Union[None, str, "os.PathLike[str]", Callable[..., _core.Scene]] = None,
        trial: Union[None, str, Callable[..., Mapping[str, Any]]] = None,
        parameters: Mapping[str, Parameter],
        design: str = "grid",
        trials: Union[None, int, Sequence[Mapping[str, Any]]] = None,
        repeats: int = 1,
        seed: int = 0,
        success: str = "",
        watch: Optional[Sequence[str]] = None,
        timeout: Optional[float] = None,
        units: Optional[Mapping[str, str]] = None,
        folder: Union[str, "os.PathLike[str]"] = ".",
    ) -> None:
        """States a study; run() runs it.

        scene: what is run and measured: an SDFormat or URDF file with `${expression}` where a parameter
            goes, a function that returns a Scene, or "FILE.py:FUNCTION". trial: in its place, a function
            that returns a dict of outcomes: numbers, bools, texts, lists of up to 32 numbers. Functions
            take parameters by name, and `seed` if they have it.
        parameters: of each a value, a list of values, or a Range. With a scene those named voxel [m],
            seconds [s], step [s], substeps, friction, law, stiffness [N/m], damping [N s/m], samples,
            reuse, tolerance [m], iterations, method, backend and shell [m] are settings of World.
        design: "grid", all combinations; "latin", a Latin hypercube of `trials` points; "list", `trials`
            is a list of dicts.
        repeats: of each point, with other seeds. seed: from which the trials' seeds come.
        success: an expression of outcomes and parameters, as "peg_z < 0.006". A trial function may
            return `success` itself.
        watch: bodies of a scene that are measured; none: all that move.
        timeout: of a trial [s]; what takes longer is ended, and its row says so.
        units: of parameters and outcomes, for plots: {"offset": "m"}.
        folder: from which files are seen.

        Raises StudyError that names the field.
        """
        self.name, self.success, self.timeout = name, success, number(timeout)
        if not isinstance(success, str):
            raise StudyError("success: must be a text, an expression of outcomes and parameters")
        self.units = units_of(units or {})
        self.folder = pathlib.Path(folder)
        self.watch = None if watch is None else names_of(watch)
        self.points: list[Point] = plan(parameters, design, trials, repeats, seed)
        self.design, self.repeats, self.seed = design, int(repeats), int(seed)
        if timeout is not None and not (finite(self.timeout) and self.timeout > 0):
            raise StudyError("timeout: must be a number of seconds above 0")
        if (scene is None) == (trial is None):
            raise StudyError("scene, trial: give one of the two")
        if watch is not None and scene is None:
            raise StudyError("watch: bodies are measured of a scene; leave it out")
        self.work = self._work(scene, trial)
        self._check()

    def _work(self, scene: Any, trial: Any) -> Work:
        what, where = (scene, "scene") if trial is None else (trial, "trial")
        is_file = isinstance(what, (str, os.PathLike)) and (where == "scene") and ":" not in os.path.basename(what)
        if is_file:
            return Work(scene=SceneFile.read(self.folder / what), success=self.success, watch=self.watch)
        if not callable(what) and not isinstance(what, str):
            raise StudyError(f"{where}: give a function" + (", or a file" if where == "scene" else ""))
        shipped = ship(what, self.folder, where)
        return Work(shipped, makes_scene=where == "scene", success=self.success, watch=self.watch)

    def _check(self) -> None:
        """Finds what is wrong before a thousand trials do: names, the scene of the first trial."""
        if self.success:
            Expression(self.success, "success")
        first = self.points[0]
        names, scene = set(first.parameters), self.work.scene
        if scene is not None:
            scene.check(names)
            self._check_scene(scene.load(first.parameters, first.seed), scene.template.names)
            return
        assert self.work.function is not None
        where = "scene" if self.work.makes_scene else "trial"
        function, label = loaded(self.work.function, where), self.work.function.label
        own = set(words_of(function, first.parameters))
        check_call(function, label, (names - set(SETTINGS)) | own if self.work.makes_scene else names)
        if self.work.makes_scene:
            try:
                made = made_scene(self.task(first))
            except Exception as bad:
                raise StudyError(f"scene: {label}: {type(bad).__name__}: {bad}") from bad
            self._check_scene(made, own)

    def _check_scene(self, scene: _core.Scene, own: set[str]) -> None:
        first = self.points[0].parameters
        settings = settings_of(first, own)
        if "seconds" not in settings:
            raise StudyError("parameters.seconds: the time that a scene runs is missing; add it")
        for point in self.points:
            check_settings(settings_of(point.parameters, own))
        outcomes = outcomes_of(scene, self.watch)
        if len(outcomes) + len(first) > MOST_COLUMNS:
            raise StudyError(f"watch: {len(scene.bodies)} bodies make too many columns; name those to measure")
        known = {*outcomes, *first, "success"}
        if self.success:
            known_names(known - {"success"}, self.success)
        for name in self.units:
            if name not in known:
                raise StudyError(f"units.{name}: is no outcome and no parameter{meant(name, known)}")

    def __len__(self) -> int:
        """Trials."""
        return len(self.points)

    @property
    def statement(self) -> dict[str, Any]:
        """What the file of results keeps, and compares before it goes on."""
        work = self.work
        if work.scene is not None:
            source = work.scene.digest(*(p.parameters for p in self.points))
        else:
            assert work.function is not None
            text = work.function.source or work.function.module
            source = hashlib.sha256(text.encode() + work.function.pickled).hexdigest()
        rows = repr([(p.number, p.repeat, p.seed, p.parameters) for p in self.points])
        return {
            "name": self.name,
            "names": list(self.points[0].parameters),
            "scene" if work.scene or work.makes_scene else "trial": source,
            "parameters": hashlib.sha256(rows.encode()).hexdigest(),
            "trials": len(self.points),
            "seed": self.seed,
            "success": self.success,
            "watch": None if self.watch is None else list(self.watch),
        }

    def task(self, point: Point) -> Task:
        """What a worker gets for a trial."""
        return Task(point.number, point.seed, point.parameters, self.work, self.timeout)

    def once(self, number: int = 0) -> dict[str, Any]:
        """The outcomes of one trial, run here and now: to try a study before it runs. Raises what it raises."""
        if not 0 <= number < len(self.points):
            raise IndexError(f"number: there are trials 0 to {len(self.points) - 1}")
        return run_here(self.task(self.points[number]))

    def run(
        self,
        results: Union[str, "os.PathLike[str]"],
        on: On = "local",
        *,
        again: bool = False,
        progress: Progress = None,
    ) -> Results:
        """Runs the trials that are not in the file of results yet, and returns it.

        results: a SQLite file, made where there is none. It is written as trials end; a study that ended
            early goes on with it. on: "local", "local:N" processes, "dask:ADDRESS" of a scheduler, "mpi"
            (in all ranks of mpirun), an executor of concurrent.futures, or a function that makes one, which
            is called again if the executor breaks. again: runs trials that failed again. progress: see
            cloudcontact.digitize().

        Raises StudyError where the file is of another study, StudyStopped where the executor breaks.
        """
        path = pathlib.Path(os.path.abspath(results))  # whatever folder a trial or a callback goes to
        if on == "mpi":
            with open_executor(on) as executor:
                if executor is not None:
                    self._run(path, executor, again, progress)
        else:
            self._run(path, on, again, progress)
        return Results(path)

    def _run(self, path: pathlib.Path, on: On, again: bool, progress: Progress) -> None:
        if path.is_dir():
            raise StudyError(f"results: '{path}' is a folder; give a file in it")
        if not path.parent.is_dir():
            raise StudyError(f"results: no folder '{path.parent}'")
        with Lock(path), contextlib.ExitStack() as at_end:

            def begin() -> Run:
                recorder = Recorder(path, self.statement, self.points, self.units)
                at_end.callback(recorder.close)
                left = recorder.open(again)
                tasks = [self.task(p) for p in self.points if p.number in left]
                return Run(tasks, recorder, self._teller(len(tasks), progress))

            run_all(begin, on)

    def _teller(self, todo: int, progress: Progress) -> Callable[[Sequence[Reply]], None]:
        """What shows progress as replies come."""
        tell = reporter(progress, self.name)
        ended = failed = 0

        def teller(replies: Sequence[Reply]) -> None:
            nonlocal ended, failed
            ended += len(replies)
            failed += sum(reply.status != "done" for reply in replies)
            if isinstance(tell, TextLine):
                done = len(self.points) - todo + ended
                tell.label = f"{self.name}: {done} of {len(self.points)}" + (f", {failed} failed" if failed else "")
            if tell is not None:
                tell(ended / todo)

        return teller
