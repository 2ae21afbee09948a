"""From meshes, arrays and files to clouds, and the contact of two bodies in one call."""

from __future__ import annotations

import os
from typing import Mapping, Optional, Tuple, Union

from . import _core
from ._core import Cloud, Contact, ContactBody, DigitizeReport, KelvinVoigt, Mesh, SurfaceField
from ._progress import Progress
from ._typing import Arrays, Law, PoseLike, Solid, Unit

Parts = Mapping[str, Union[Mesh, Tuple[Arrays, Arrays]]]
Source = Union[Mesh, Parts, Tuple[Arrays, Arrays], str, "os.PathLike[str]"]
MOST_BYTES = 4 << 30


def _meshes(source: Union[Mesh, Parts, Tuple[Arrays, Arrays]], unit: Unit) -> Union[Mesh, dict[str, Mesh]]:
    if isinstance(source, Mesh):
        return source
    if isinstance(source, Mapping):
        if not source:
            raise ValueError("digitize: no mesh; give at least one")
        return {name: mesh if isinstance(mesh, Mesh) else Mesh(mesh[0], mesh[1], unit) for name, mesh in source.items()}
    if isinstance(source, tuple) and len(source) == 2:
        return Mesh(source[0], source[1], unit)
    raise TypeError("digitize: give a file, a Mesh, a dict of meshes, or (vertices, triangles)")


def digitize_report(
    source: Union[Mesh, Parts, Tuple[Arrays, Arrays]],
    voxel: Optional[float] = None,
    *,
    unit: Unit = 1.0,
    threads: int = 0,
    max_bytes: int = MOST_BYTES,
    backend: str = "cpu",
    progress: Progress = None,
) -> Tuple[Cloud, DigitizeReport]:
    """As digitize(), with a report on how well the mesh bounded a volume. Not for files."""
    meshes = _meshes(source, unit)
    if voxel is None:
        first = meshes if isinstance(meshes, Mesh) else max(meshes.values(), key=_core.Mesh.suggested_voxel)
        voxel = first.suggested_voxel()
    return _core.digitize_mesh(meshes, voxel, threads, max_bytes, backend, progress)


def digitize(
    source: Source,
    voxel: Optional[float] = None,
    *,
    unit: Unit = 1.0,
    shell: Optional[float] = None,
    thresholds: Optional[Mapping[str, float]] = None,
    threads: int = 0,
    max_bytes: int = MOST_BYTES,
    backend: str = "cpu",
    progress: Progress = None,
) -> Cloud:
    """A body as voxels: a Cloud.

    source: a file (mesh, points, CT volume, .cloud, or a primitive as "sphere:0.01"), a Mesh, a
        tuple (vertices (n, 3), triangles (m, 3)), or a dict of such by material.
    voxel: edge of a voxel [m]; none: Mesh.suggested_voxel().
    unit: of files and arrays, meters or "mm", "cm", "in", "m".
    shell: thickness given to a file's sheet [m]; none: three voxels.
    thresholds: of a file's CT volume, the value from which on there is material, by its name.
    threads: 0 for all cores. max_bytes: limit of memory. backend: "cpu" or "opencl".
    progress: a callback for 0..1; True: a line of text on stderr; False: nothing; None: the line
        where stderr is a terminal or a notebook's and the work takes over a second.

    Ctrl-C ends it. Raises ValueError where the mesh bounds no volume, a setting is not valid, or
    the voxels need more than max_bytes (the message names a size that fits).
    """
    if isinstance(source, (str, os.PathLike)):
        return _core.digitize_file(
            source, voxel, unit, shell, dict(thresholds or {}), threads, max_bytes, backend, progress
        )
    if shell is not None or thresholds:
        raise ValueError("shell and thresholds: are of files; leave them out")
    return digitize_report(
        source, voxel, unit=unit, threads=threads, max_bytes=max_bytes, backend=backend, progress=progress
    )[0]


def contact(
    a: Union[ContactBody, SurfaceField, Solid],
    b: Union[ContactBody, SurfaceField, Solid],
    pose_b: PoseLike = None,
    *,
    law: Law = KelvinVoigt(1e4),
    margin: float = 0.0,
    samples: int = 300,
) -> Contact:
    """The Contact of two bodies: a at the origin and b at `pose_b`, or each a ContactBody.

    For the settings see ContactFinder.find(); keep a ContactFinder for a pair that moves.
    """
    if pose_b is not None:
        if isinstance(b, ContactBody):
            raise ValueError("pose_b: the ContactBody b has a pose; leave one of the two out")
        b = ContactBody(b, pose_b)
    return _core.ContactFinder().find(a, b, law=law, margin=margin, samples=samples)
