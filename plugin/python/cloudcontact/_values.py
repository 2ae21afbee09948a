"""Values as what they are made of: pickled for other processes, copied, and shown.

Clouds and fields travel as the bytes of their files. What works (finders, batches, loops, worlds) stays where it is.
Poses and half-spaces are pickled in C++: their constructors normalize, which can change the last bit.
"""

from __future__ import annotations

import copyreg
import os
import pathlib
import tempfile
from typing import Any, Callable, Tuple

from . import _core

# The arguments that make an equal value, by the names of its attributes. Laws and solids are shown by them, too.
SHOWN: dict[type, Tuple[str, ...]] = {
    _core.KelvinVoigt: ("stiffness", "damping"),
    _core.Foundation: ("stiffness", "damping"),
    _core.Rigid: (),
    _core.Maxwell: ("stiffness", "damping"),
    _core.StandardLinearSolid: ("stiffness", "branch_stiffness", "branch_damping"),
    _core.HalfSpace: ("normal", "offset"),
    _core.Sphere: ("radius",),
    _core.Box: ("half_extents",),
    _core.Ellipsoid: ("semi_axes",),
    _core.Capsule: ("radius", "half_height"),
    _core.Cylinder: ("radius", "half_height"),
    _core.Cone: ("radius", "half_height"),
}
PARTS: dict[type, Tuple[str, ...]] = {
    **SHOWN,
    _core.Tissue: ("name", "stiffness", "damping", "hardness", "density", "elasticity"),
    _core.Mesh: ("vertices", "triangles"),
    _core.CtVolume: ("values", "spacing", "origin"),
}
FILES = {_core.Cloud: ".cloud", _core.SurfaceField: ".field"}


def _parts(value: Any) -> Tuple[Any, ...]:
    return tuple(getattr(value, name) for name in PARTS[type(value)])


def _text(value: Any) -> str:
    parts = (f"{name}={_plain(part)}" for name, part in zip(PARTS[type(value)], _parts(value)))
    return f"{type(value).__name__}({', '.join(parts)})"


def _plain(part: Any) -> str:
    return str(tuple(part.tolist())) if hasattr(part, "tolist") else repr(part)


def _read(kind: Any, data: bytes) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "value" + FILES[kind])
        file.write_bytes(data)
        return kind.load(file)


def _written(value: Any) -> Tuple[Callable[..., Any], Tuple[Any, ...]]:
    kind = type(value)
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "value" + FILES[kind])
        value.save(file)
        return _read, (kind, pathlib.Path(file).read_bytes())


def _made(value: Any) -> Tuple[Callable[..., Any], Tuple[Any, ...]]:
    return type(value), _parts(value)


def register() -> None:
    """Teaches pickle, copy and repr the values of the library."""
    for kind in FILES:
        copyreg.pickle(kind, _written)
    for kind in PARTS.keys() - {_core.HalfSpace}:
        copyreg.pickle(kind, _made)
    for kind in SHOWN:
        setattr(kind, "__repr__", _text)
