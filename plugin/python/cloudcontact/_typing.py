"""Types of what the functions take."""

from __future__ import annotations

from typing import Union

import numpy.typing as npt

from ._core import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    Ellipsoid,
    Foundation,
    HalfSpace,
    KelvinVoigt,
    Maxwell,
    Pose,
    Rigid,
    Sphere,
    StandardLinearSolid,
)

Arrays = npt.ArrayLike
PoseLike = Union[None, Pose, npt.ArrayLike]
Solid = Union[Sphere, Box, Ellipsoid, Capsule, Cylinder, Cone, HalfSpace]
Law = Union[KelvinVoigt, Foundation, Rigid, Maxwell, StandardLinearSolid]
Unit = Union[float, str]
