"""A trial that runs a scene: the settings among its parameters, the file filled in, and what is measured."""

from __future__ import annotations

import contextlib
import hashlib
import os
import pathlib
import re
import tempfile
from dataclasses import dataclass
from typing import Any, Callable, Iterable, Mapping, Optional, Sequence

import numpy as np

from .. import _core
from .._typing import Law
from .errors import StudyError, meant
from .expressions import Template
from .scene_paths import NAMED, files_of, write_elsewhere

# Parameters that are settings of the world, not of the scene: lengths in m, times in s, stiffness in N/m
# (N/m^3 with the law foundation), damping in N s/m (N s/m^3).
WORLD = ("voxel", "friction", "samples", "reuse", "tolerance", "iterations", "method", "backend", "shell")
RUN = ("seconds", "step", "substeps")
LAW = ("law", "stiffness", "damping")
SETTINGS = (*WORLD, *RUN, *LAW)
LEAST = 1e-12
CHECKS: tuple[tuple[tuple[str, ...], tuple[type, ...], float, str], ...] = (
    (("voxel", "seconds", "step", "stiffness", "shell"), (int, float), LEAST, "a number above 0"),
    (("friction", "damping", "tolerance", "reuse"), (int, float), 0, "a number of 0 or more"),
    (("substeps", "samples", "iterations"), (int,), 1, "a whole number of 1 or more"),
)
ALWAYS = ("voxel", *RUN)  # settings of the run even where the scene uses their names, too

OF_BODY = (
    *("x", "y", "z", "qx", "qy", "qz", "qw", "speed", "spin", "tilt"),
    *("force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z", "peak_force", "peak_torque"),
)
OF_WORLD = ("time", "penetration", "energy", "hash")
UNITS = {"force": "N", "torque": "N m", "x": "m", "y": "m", "z": "m", "speed": "m/s", "spin": "rad/s", "tilt": "rad"}
OTHER_UNITS = {
    **{"voxel": "m", "tolerance": "m", "shell": "m", "seconds": "s", "step": "s"},
    **{"time": "s", "penetration": "m", "energy": "J"},
}


def unit_of(name: str) -> str:
    """Of a setting or a measure of a scene; "" where it has none."""
    for ending, unit in UNITS.items():
        if name.endswith("_" + ending) or f"_{ending}_" in name:
            return unit
    return OTHER_UNITS.get(name, "")


def column(name: str) -> str:
    """A body's name as the beginning of a column's."""
    return re.sub(r"\W+", "_", name)


def settings_of(values: Mapping[str, Any], own: Iterable[str]) -> dict[str, Any]:
    """The world's settings among parameters: what the scene itself uses is its own."""
    return {k: v for k, v in values.items() if k in SETTINGS and (k in ALWAYS or k not in set(own))}


def check_settings(values: Mapping[str, Any]) -> None:
    """That the numbers among a trial's settings are possible."""
    for names, kinds, least, words in CHECKS:
        for name in set(names) & set(values):
            value = values[name]
            fits = isinstance(value, kinds) and not isinstance(value, bool) and value >= least
            if not fits:
                raise StudyError(f"parameters.{name}: {value!r} must be {words}")
    law_of(values)


def law_of(values: Mapping[str, Any]) -> Optional[Law]:
    """Of the parameters law, stiffness and damping; none: the automatic spring."""
    name, stiffness, damping = values.get("law"), values.get("stiffness"), values.get("damping", 0.0)
    kind, _, numbers = str(name or "paper").partition(":")
    if kind == "rigid" and not numbers:
        return _core.Rigid()
    if kind in ("maxwell", "solid"):
        try:
            k = [float(n) for n in numbers.split(",")]
            return _core.Maxwell(*k) if kind == "maxwell" else _core.StandardLinearSolid(*k)
        except (ValueError, TypeError):
            raise StudyError(f"law: '{name}': give maxwell:K,C or solid:K,K1,C1") from None
    if kind not in ("paper", "foundation") or numbers:
        raise StudyError(f"law: '{name}' is not known; give paper, foundation, rigid, maxwell:K,C or solid:K,K1,C1")
    if stiffness is None:
        if kind == "foundation" or "damping" in values:
            raise StudyError(
                f"stiffness: {'damping' if 'damping' in values else 'the law foundation'} needs it; add it"
            )
        return None
    if kind == "paper":
        return _core.KelvinVoigt(float(stiffness), float(damping))
    return _core.Foundation(float(stiffness), float(damping))


@dataclass(frozen=True)
class SceneFile:
    """An SDFormat or URDF file with `${...}` in it, and the folder that its paths start from."""

    text: str
    file: str

    @staticmethod
    def read(file: pathlib.Path) -> SceneFile:
        try:
            return SceneFile(file.read_text("utf-8"), os.path.abspath(file))
        except (OSError, UnicodeDecodeError) as bad:
            raise StudyError(f"scene: cannot read '{file}': {getattr(bad, 'strerror', None) or bad}") from None

    @property
    def template(self) -> Template:
        return Template(self.text, pathlib.Path(self.file).name)

    def load(self, values: Mapping[str, Any], seed: int) -> _core.Scene:
        path = pathlib.Path(self.file)
        with tempfile.TemporaryDirectory() as folder:
            place = pathlib.Path(folder) / path.name
            copies = write_elsewhere(self.template.filled(values, seed), path.parent, place)
            try:
                return _core.Scene.load(place)
            except ValueError as bad:
                message = str(bad)
                for copy, file in {**copies, str(place): path.name, folder: str(path.parent)}.items():
                    message = message.replace(copy, file)
                raise StudyError(message) from None

    def check(self, names: Iterable[str]) -> None:
        """That each parameter is a setting or is in the file, and each name in the file a parameter."""
        holes, given = self.template.names, set(names)
        place = pathlib.Path(self.file).name
        for name in sorted(given - holes - set(SETTINGS)):
            near = meant(name, [*holes, *SETTINGS])
            raise StudyError(f"parameters.{name}: is no setting, and {place} has no ${{{name}}}{near}")
        for name in sorted(holes - given):
            raise StudyError(f"{place}: ${{{name}}} has no value; add parameters.{name}")

    def digest(self, *points: Mapping[str, Any]) -> str:
        """Of the text and the files that it names, with the parameters of any point."""
        whole, template = hashlib.sha256(self.text.encode()), self.template
        if not any("${" in match[0] for match in NAMED.finditer(self.text)):
            points = points[:1]  # the same files for all
        files: dict[str, None] = {}
        for values in points:
            with contextlib.suppress(StudyError):  # that trial fails, whatever its files are
                files.update(dict.fromkeys(files_of(template.filled(values, 0), pathlib.Path(self.file).parent)))
        for path in files:
            whole.update(pathlib.Path(path).read_bytes())
        return whole.hexdigest()


class Wrenches:
    """The contacts' force and torque on bodies, about each one's origin: now, and the largest so far."""

    def __init__(self, bodies: Sequence[_core.WorldBody]) -> None:
        self.bodies = bodies
        self.force = np.zeros((len(bodies), 3))
        self.torque = np.zeros((len(bodies), 3))
        self.peaks = np.zeros((len(bodies), 2))

    def __call__(self, world: _core.World) -> None:
        points = world.contacts()
        self.force[:], self.torque[:] = 0, 0
        for n, body in enumerate(self.bodies if len(points) else ()):
            sign = (points["b"] == body.index).astype(float) - (points["a"] == body.index)
            force = points["force"] * sign[:, None]
            self.force[n] = force.sum(axis=0)
            self.torque[n] = np.cross(points["position"] - body.position, force).sum(axis=0)
        lengths = np.stack([np.linalg.norm(self.force, axis=1), np.linalg.norm(self.torque, axis=1)], axis=1)
        np.maximum(self.peaks, lengths, out=self.peaks)


def watched(world: _core.World, watch: Optional[Sequence[str]]) -> list[_core.WorldBody]:
    """Bodies that are measured: those named, or all that move."""
    for name in watch or ():
        if name not in world.names:
            raise StudyError(f"watch: the scene has no body '{name}'{meant(name, world.names)}")
    bodies = [world[name] for name in (world.names if watch is None else watch)]
    return bodies if watch is not None else [b for b in bodies if b.mass > 0]


def up(body: _core.WorldBody) -> Any:
    return body.pose.matrix[:3, 2]


def world_of(scene: _core.Scene, values: Mapping[str, Any]) -> _core.World:
    """On one thread."""
    words = {name: values[name] for name in WORLD if name in values and name != "voxel"}
    return _core.World(scene, values.get("voxel"), False, threads=1, law=law_of(values), **words)


def run_scene(scene: _core.Scene, values: Mapping[str, Any], watch: Optional[Sequence[str]]) -> dict[str, Any]:
    """Runs it on one thread and measures: names of columns, values in SI units."""
    if "seconds" not in values:
        raise StudyError("seconds: the time to run is missing; add parameters.seconds")
    world = world_of(scene, values)
    bodies = watched(world, watch)
    measure, start = Wrenches(bodies), [up(body) for body in bodies]
    world.run(values["seconds"], values.get("step"), int(values.get("substeps", 1)), observe=measure, progress=False)
    out: dict[str, Any] = {}
    for n, body in enumerate(bodies):
        cosine = float(np.clip(start[n] @ up(body), -1, 1))
        columns: list[Any] = [*body.position, *body.orientation, np.linalg.norm(body.velocity)]
        columns += [np.linalg.norm(body.angular_velocity), np.arccos(cosine)]
        columns += [*measure.force[n], *measure.torque[n], *measure.peaks[n]]
        out.update({f"{column(body.name)}_{name}": float(v) for name, v in zip(OF_BODY, columns)})
    out.update(time=world.time, penetration=world.penetration(), energy=world.energy["bodies"])
    out["hash"] = f"{world.hash:016x}"
    return out


def outcomes_of(scene: _core.Scene, watch: Optional[Sequence[str]]) -> list[str]:
    """Names that run_scene() may give."""
    for name in watch or ():
        if name not in scene.bodies:
            raise StudyError(f"watch: the scene has no body '{name}'{meant(name, scene.bodies)}")
    names = scene.bodies if watch is None else watch
    return [*(f"{column(body)}_{measure}" for body in names for measure in OF_BODY), *OF_WORLD]


SceneMaker = Callable[..., _core.Scene]
