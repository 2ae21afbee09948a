"""Contact between digital clouds: bodies of voxels that touch each other however concave they are.

SI units everywhere. Arrays are numpy's, indexed [x, y, z] where they are grids. Where a pose is
asked for, a Pose, three numbers (a position), seven (x y z qx qy qz qw) or a matrix (4, 4) do.

- Clouds: digitize(), Cloud, CtVolume, load_mesh().
- Contacts: SurfaceField, contact(), ContactFinder, ContactBatch.
- Workpieces: BaseVectorField, CollisionFinder, HapticLoop, Cutter.
- Worlds: Scene, World, Worlds, Replay.
"""

import numpy as _numpy

from . import _core
from ._core import (
    BaseVectorField,
    BatchContacts,
    Box,
    Capsule,
    Cloud,
    Collision,
    CollisionFinder,
    Cone,
    Contact,
    ContactBatch,
    ContactBody,
    ContactFinder,
    CtVolume,
    Cutter,
    CuttingProcess,
    Cylinder,
    Detection,
    DigitizeReport,
    Ellipsoid,
    Foundation,
    HalfSpace,
    HapticLoop,
    HapticOutput,
    KelvinVoigt,
    MassProperties,
    Maxwell,
    Mesh,
    MeshReport,
    Motor,
    PaperBody,
    PlacedSolid,
    Pose,
    Rigid,
    Scene,
    Sphere,
    StandardLinearSolid,
    SurfaceField,
    Tissue,
    World,
    WorldBody,
    WorldJoint,
    Worlds,
    WorldState,
    __version__,
    dental_tissues,
    digitize_volume,
    inspect,
    is_sheet,
    load_mesh,
    load_mesh_parts,
    load_volume,
    mended,
    opencl_devices,
    shell,
)
if int(_numpy.__version__.split(".")[0]) >= 2 and not _core._knows_numpy_2:
    raise ImportError(
        "cloudcontact was built with a pybind11 that knows numpy below 2; install numpy<2, or build "
        "it with pybind11 2.12 or later"
    )

from ._shapes import contact, digitize, digitize_report
from ._values import register as _register
from ._view import Replay

_register()

__all__ = [name for name in dir() if not name.startswith("_")] + ["__version__"]
