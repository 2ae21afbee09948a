# Types of the module that plugin/python compiles. Docstrings are the module's own: help(cloudcontact.Cloud).
# Members of values are Final: nothing sets them.
import os
from typing import Any, Callable, Final, Iterable, Iterator, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from ._progress import Progress
from ._typing import Law, PoseLike, Solid, Unit
from ._view import Replay

Doubles = npt.NDArray[np.float64]
Bytes = npt.NDArray[np.uint8]
Records = npt.NDArray[np.void]
File = Union[str, "os.PathLike[str]"]
Chosen = Union[None, int, Sequence[int], npt.NDArray[Any]]  # worlds: numbers or a mask

__version__: str
_knows_numpy_2: bool

class Pose:
    def __init__(self, position: PoseLike = None, orientation: Optional[npt.ArrayLike] = None) -> None: ...
    @staticmethod
    def from_rotation_vector(turn: npt.ArrayLike, position: Optional[npt.ArrayLike] = None) -> Pose: ...
    position: Final[Doubles]
    orientation: Final[Doubles]
    matrix: Final[Doubles]
    def to_world(self, local: npt.ArrayLike) -> Doubles: ...
    def to_local(self, world: npt.ArrayLike) -> Doubles: ...
    def inverse(self) -> Pose: ...
    def __matmul__(self, inner: Pose) -> Pose: ...

class MassProperties:
    volume: Final[float]
    mass: Final[float]
    center_of_mass: Final[Doubles]
    inertia: Final[Doubles]

class KelvinVoigt:
    def __init__(self, stiffness: float, damping: float = 0.0) -> None: ...
    stiffness: Final[float]
    damping: Final[float]

class Foundation:
    def __init__(self, stiffness: float, damping: float = 0.0) -> None: ...
    stiffness: Final[float]
    damping: Final[float]

class Rigid:
    def __init__(self) -> None: ...

class Maxwell:
    def __init__(self, stiffness: float, damping: float) -> None: ...
    stiffness: Final[float]
    damping: Final[float]

class StandardLinearSolid:
    def __init__(self, stiffness: float, branch_stiffness: float, branch_damping: float) -> None: ...
    stiffness: Final[float]
    branch_stiffness: Final[float]
    branch_damping: Final[float]

class Tissue:
    def __init__(
        self,
        name: str,
        stiffness: float,
        damping: float = 0.0,
        hardness: float = 0.0,
        density: float = 1000.0,
        elasticity: float = 0.0,
    ) -> None: ...
    name: Final[str]
    stiffness: Final[float]
    damping: Final[float]
    hardness: Final[float]
    density: Final[float]
    elasticity: Final[float]
    def __eq__(self, other: object) -> bool: ...

def dental_tissues(enamel: float = 20000.0) -> list[Tissue]: ...

class HalfSpace:
    def __init__(self, normal: npt.ArrayLike = ..., offset: float = 0.0) -> None: ...
    normal: Final[Doubles]
    offset: Final[float]

class Sphere:
    def __init__(self, radius: float) -> None: ...
    radius: Final[float]

class Box:
    def __init__(self, half_extents: npt.ArrayLike) -> None: ...
    half_extents: Final[Doubles]

class Ellipsoid:
    def __init__(self, semi_axes: npt.ArrayLike) -> None: ...
    semi_axes: Final[Doubles]

class Capsule:
    def __init__(self, radius: float, half_height: float) -> None: ...
    radius: Final[float]
    half_height: Final[float]

class Cylinder:
    def __init__(self, radius: float, half_height: float) -> None: ...
    radius: Final[float]
    half_height: Final[float]

class Cone:
    def __init__(self, radius: float, half_height: float) -> None: ...
    radius: Final[float]
    half_height: Final[float]

class PlacedSolid:
    def __init__(self, solid: Union[Solid, Cloud], place: PoseLike = None) -> None: ...
    def depth(self, points: npt.ArrayLike) -> Doubles: ...

Area = Union[Solid, Cloud, PlacedSolid]

class Mesh:
    def __init__(self, vertices: npt.ArrayLike, triangles: npt.ArrayLike, unit: Unit = 1.0) -> None: ...
    vertices: Final[Doubles]
    triangles: Final[npt.NDArray[np.int32]]
    def scaled(self, factor: npt.ArrayLike) -> Mesh: ...
    def suggested_voxel(self) -> float: ...

class MeshReport:
    open_edges: Final[int]
    overused_edges: Final[int]
    degenerate_triangles: Final[int]
    volume: Final[float]
    area: Final[float]
    closed: Final[bool]

def load_mesh(file: File, unit: Unit = 1.0) -> Mesh: ...
def load_mesh_parts(file: File, unit: Unit = 1.0) -> dict[str, Mesh]: ...
def inspect(mesh: Mesh) -> MeshReport: ...
def mended(mesh: Mesh, tolerance: float = 0.0) -> Mesh: ...
def shell(mesh: Mesh, thickness: float) -> Mesh: ...
def is_sheet(mesh: Mesh) -> bool: ...

class Cloud:
    @staticmethod
    def from_array(
        coverage: npt.NDArray[Any],
        voxel: float,
        origin: npt.ArrayLike = ...,
        material: Optional[npt.ArrayLike] = None,
        materials: Sequence[str] = ...,
    ) -> Cloud: ...
    @staticmethod
    def load(file: File) -> Cloud: ...
    def save(self, file: File) -> None: ...
    voxel: Final[float]
    origin: Final[Doubles]
    shape: Final[Tuple[int, int, int]]
    materials: Final[list[str]]
    voxels: Final[int]
    bytes: Final[int]
    coverage: Final[Bytes]
    material: Final[Bytes]
    bricks: Final[Bytes]
    brick_table: Final[npt.NDArray[np.int32]]
    def mass_properties(self, density: Union[float, Sequence[float]] = 1000.0) -> MassProperties: ...
    def center(self, x: int, y: int, z: int) -> Doubles: ...
    def translated(self, shift: npt.ArrayLike) -> Cloud: ...
    def scaled(self, factor: float) -> Cloud: ...
    def resampled(self, voxel: float) -> Cloud: ...
    def cut(self, voxels: npt.ArrayLike, coverage: Optional[npt.ArrayLike] = None) -> Cloud: ...
    def pieces(self) -> list[Cloud]: ...
    def surface(self) -> Mesh: ...

class DigitizeReport:
    closed: Final[bool]
    bad_columns: Final[int]
    undecided_voxels: Final[int]

def digitize_mesh(
    source: Union[Mesh, dict[str, Mesh]],
    voxel: float,
    threads: int,
    max_bytes: int,
    backend: str,
    progress: Progress,
) -> Tuple[Cloud, DigitizeReport]: ...
def digitize_file(
    file: Union[str, "os.PathLike[str]"],
    voxel: Optional[float],
    unit: Unit,
    shell: Optional[float],
    thresholds: dict[str, float],
    threads: int,
    max_bytes: int,
    backend: str,
    progress: Progress,
) -> Cloud: ...

class CtVolume:
    def __init__(self, values: npt.ArrayLike, spacing: npt.ArrayLike, origin: npt.ArrayLike = ...) -> None: ...
    values: Final[npt.NDArray[np.float32]]
    spacing: Final[Doubles]
    origin: Final[Doubles]

def load_volume(file: File, unit: Unit = 1.0, voxel: float = 0.0) -> CtVolume: ...
def digitize_volume(
    volume: CtVolume,
    thresholds: Union[float, Mapping[str, float]],
    voxel: float = 0.0,
    max_bytes: int = 4294967296,
) -> Cloud: ...

class SurfaceField:
    def __init__(
        self, cloud: Cloud, renewable: bool = False, threads: int = 0, progress: Progress = None
    ) -> None: ...
    @staticmethod
    def load(file: File) -> SurfaceField: ...
    def save(self, file: File) -> None: ...
    def renewed(self, after: Cloud, threads: int = 0, progress: Progress = None) -> SurfaceField: ...
    def scaled(self, factor: float) -> SurfaceField: ...
    def at(self, points: npt.ArrayLike) -> Tuple[Doubles, Doubles]: ...
    def samples(self) -> dict[str, npt.NDArray[np.float32]]: ...
    bounds: Final[Doubles]
    cloud: Final[Cloud]
    band_voxels: Final[int]
    sample_count: Final[int]
    bytes: Final[int]
    hash: Final[int]

class PaperBody:
    def __init__(
        self,
        cloud: Cloud,
        tissues: Sequence[Tissue] = ...,
        area: Optional[Area] = None,
        hardness: bool = True,
        ability: float = 1.0,
    ) -> None: ...

class ContactBody:
    def __init__(
        self,
        shape: Union[SurfaceField, Solid],
        pose: PoseLike = None,
        velocity: Optional[npt.ArrayLike] = None,
        angular_velocity: Optional[npt.ArrayLike] = None,
        tissues: Optional[Sequence[Tissue]] = None,
        spring: Optional[KelvinVoigt] = None,
        paper: Optional[PaperBody] = None,
    ) -> None: ...
    @property
    def pose(self) -> Pose: ...
    @pose.setter
    def pose(self, pose: PoseLike) -> None: ...
    @property
    def velocity(self) -> Doubles: ...
    @velocity.setter
    def velocity(self, velocity: npt.ArrayLike) -> None: ...
    @property
    def angular_velocity(self) -> Doubles: ...
    @angular_velocity.setter
    def angular_velocity(self, velocity: npt.ArrayLike) -> None: ...

class Contact:
    points: Final[Records]
    patches: Final[Records]
    force: Final[Doubles]
    torque: Final[Doubles]
    depth: Final[float]
    depth_error: Final[float]
    samples: Final[int]
    def __len__(self) -> int: ...
    def __bool__(self) -> bool: ...

class ContactFinder:
    def __init__(self) -> None: ...
    def find(
        self,
        a: Union[ContactBody, SurfaceField, Solid],
        b: Union[ContactBody, SurfaceField, Solid],
        *,
        law: Law = ...,
        margin: float = 0.0,
        samples: int = 300,
    ) -> Contact: ...

class BatchContacts:
    def __len__(self) -> int: ...
    forces: Final[Doubles]
    torques: Final[Doubles]
    depths: Final[Doubles]
    points: Final[Records]
    first_points: Final[npt.NDArray[np.int64]]
    patches: Final[Records]
    first_patches: Final[npt.NDArray[np.int64]]

class ContactBatch:
    def __init__(self, backend: str = "cpu", threads: int = 0) -> None: ...
    def find(
        self,
        pairs: Iterable[
            Tuple[Union[ContactBody, SurfaceField, Solid], Union[ContactBody, SurfaceField, Solid]]
        ],
        *,
        law: Law = ...,
        margin: float = 0.0,
        samples: int = 300,
    ) -> BatchContacts: ...
    def find_poses(
        self,
        a: Union[ContactBody, SurfaceField, Solid],
        b: Union[ContactBody, SurfaceField, Solid],
        poses_b: npt.ArrayLike,
        poses_a: Optional[npt.ArrayLike] = None,
        *,
        law: Law = ...,
        margin: float = 0.0,
        samples: int = 300,
    ) -> BatchContacts: ...
    backend: Final[str]
    device: Final[str]
    message: Final[str]
    @property
    def on_device(self) -> int: ...

def opencl_devices() -> list[str]: ...

class BaseVectorField:
    def __init__(
        self,
        cloud: Cloud,
        tissues: Sequence[Tissue],
        window: Optional[Area] = None,
        representative: Optional[npt.ArrayLike] = None,
        smooth: bool = True,
    ) -> None: ...
    voxel: Final[float]
    origin: Final[Doubles]
    shape: Final[Tuple[int, int, int]]
    tissues: Final[list[Tissue]]
    def at(self, voxels: npt.ArrayLike) -> Tuple[Doubles, Doubles]: ...
    def coverage(self, voxels: npt.ArrayLike) -> Bytes: ...
    def cloud(self) -> Cloud: ...
    def mass_properties(self) -> MassProperties: ...
    @property
    def hash(self) -> int: ...
    @property
    def bytes(self) -> int: ...
    def cut(self, voxels: npt.ArrayLike, coverage: Optional[npt.ArrayLike] = None) -> int: ...
    def cut_area(self, area: Area, pose: PoseLike = None) -> int: ...
    def reserve(self) -> None: ...

class Detection:
    def __init__(
        self,
        area: Area,
        membership: str = "shared",
        hardness: bool = True,
        ability: float = 1.0,
        parts: Optional[Sequence[Tuple[Area, float]]] = None,
        depth: str = "tip",
    ) -> None: ...

class Collision:
    voxels: Final[Records]
    count: Final[float]
    mean: Final[Doubles]
    normal: Final[Doubles]
    stiffness: Final[float]
    damping: Final[float]
    center: Final[Doubles]
    depth: Final[float]
    volume: Final[float]
    def __bool__(self) -> bool: ...

class CollisionFinder:
    def __init__(self, threads: int = 1) -> None: ...
    def find(
        self,
        workpiece: BaseVectorField,
        tool: Detection,
        tool_pose: PoseLike,
        workpiece_pose: PoseLike = None,
    ) -> Collision: ...

class Cutter:
    def __init__(
        self,
        hardness: float = 17e9,
        efficiency: float = 0.1,
        edge_speed: float = 0.0,
        most_voxels: int = 500,
        keeps_outside: bool = False,
    ) -> None: ...
    hardness: Final[float]
    efficiency: Final[float]
    edge_speed: Final[float]

class CuttingProcess:
    def __init__(self, cutter: Cutter) -> None: ...
    def step(
        self, workpiece: BaseVectorField, collision: Collision, force: float, speed: float, seconds: float
    ) -> Tuple[int, float]: ...

class HapticOutput:
    force: Final[Doubles]
    torque: Final[Doubles]
    tool: Final[Pose]
    depth: Final[float]
    stiffness: Final[float]
    cut_voxels: Final[int]
    cut_volume: Final[float]
    energy: Final[float]
    least_energy: Final[float]
    withheld: Final[float]

class HapticLoop:
    def __init__(
        self,
        workpiece: BaseVectorField,
        tool: Detection,
        workpiece_pose: PoseLike = None,
        *,
        step: float = 0.001,
        hand_stiffness: float = 1000.0,
        hand_damping: float = 1.0,
        release: float = 0.02,
        most_force: float = 20.0,
        law: Optional[Law] = None,
        per_tissue: bool = False,
        cutter: Optional[Cutter] = None,
    ) -> None: ...
    def tick(self, hand: PoseLike, velocity: Optional[npt.ArrayLike] = None) -> HapticOutput: ...
    def run(
        self, hand: npt.ArrayLike, velocity: Optional[npt.ArrayLike] = None, progress: Progress = None
    ) -> dict[str, Doubles]: ...

class Scene:
    name: str
    step: float
    def __init__(self, name: str = "scene", gravity: npt.ArrayLike = ..., step: float = 0.001) -> None: ...
    @staticmethod
    def load(file: File) -> Scene: ...
    @property
    def gravity(self) -> Doubles: ...
    @gravity.setter
    def gravity(self, gravity: npt.ArrayLike) -> None: ...
    @property
    def bodies(self) -> list[str]: ...
    @property
    def joints(self) -> list[str]: ...
    def add(
        self,
        name: str,
        shape: Union[File, Mesh, Cloud, Box, Sphere, Cylinder, Capsule, Cone, HalfSpace],
        pose: PoseLike = None,
        *,
        mass: Optional[float] = None,
        static: bool = False,
        friction: Optional[float] = None,
        stiffness: Optional[float] = None,
        damping: Optional[float] = None,
        restitution: Optional[float] = None,
        velocity: Optional[npt.ArrayLike] = None,
        angular_velocity: Optional[npt.ArrayLike] = None,
        unit: Unit = 1.0,
        tissue: Union[None, str, Mapping[str, str]] = None,
        cuttable: bool = False,
        cutter: Optional[Cutter] = None,
        ability: float = 1.0,
        drive: Optional[Tuple[npt.ArrayLike, npt.ArrayLike]] = None,
        window: Optional[Solid] = None,
        representative: Optional[npt.ArrayLike] = None,
        area: Optional[Solid] = None,
        tolerance: Optional[float] = None,
        soft: Optional[float] = None,
        held: str = "",
    ) -> None: ...
    def join(
        self,
        kind: str,
        child: str,
        parent: Optional[str] = None,
        position: Optional[npt.ArrayLike] = None,
        axis: Optional[npt.ArrayLike] = None,
        *,
        name: Optional[str] = None,
        lower: Optional[float] = None,
        upper: Optional[float] = None,
        spring: float = 0.0,
        damping: float = 0.0,
        rest: float = 0.0,
        friction: float = 0.0,
        effort: float = ...,
        pitch: float = 0.0,
        second: Union[None, npt.ArrayLike, Mapping[str, object]] = None,
    ) -> None: ...

class WorldBody:
    name: Final[str]
    index: Final[int]
    @property
    def pose(self) -> Pose: ...
    @pose.setter
    def pose(self, value: PoseLike) -> None: ...
    @property
    def position(self) -> Doubles: ...
    @property
    def orientation(self) -> Doubles: ...
    @property
    def velocity(self) -> Doubles: ...
    @velocity.setter
    def velocity(self, value: npt.ArrayLike) -> None: ...
    @property
    def angular_velocity(self) -> Doubles: ...
    @angular_velocity.setter
    def angular_velocity(self, value: npt.ArrayLike) -> None: ...
    @property
    def applied_force(self) -> Doubles: ...
    @applied_force.setter
    def applied_force(self, value: npt.ArrayLike) -> None: ...
    @property
    def applied_torque(self) -> Doubles: ...
    @applied_torque.setter
    def applied_torque(self, value: npt.ArrayLike) -> None: ...
    mass: float
    friction: Optional[float]
    restitution: Optional[float]
    stiffness: Optional[float]
    damping: Optional[float]
    drive: Optional[Tuple[Doubles, Doubles]]
    @property
    def asleep(self) -> bool: ...
    @property
    def cuttable(self) -> bool: ...
    @property
    def matter(self) -> Cloud: ...
    @property
    def cut_volume(self) -> float: ...
    def cut(self, voxels: npt.ArrayLike, coverage: Optional[npt.ArrayLike] = None) -> None: ...

class Motor:
    position: Final[float]
    velocity: Final[float]
    stiffness: Final[float]
    damping: Final[float]
    force: Final[float]
    most: Final[float]
    def __init__(
        self,
        *,
        position: float = 0.0,
        velocity: float = 0.0,
        stiffness: float = 0.0,
        damping: float = 0.0,
        force: float = 0.0,
        most: float = ...,
    ) -> None: ...

class WorldJoint:
    name: Final[str]
    kind: Final[str]
    axis: Final[int]
    lower: Final[Optional[float]]
    upper: Final[Optional[float]]
    effort: Final[float]
    @property
    def position(self) -> float: ...
    @property
    def velocity(self) -> float: ...
    @property
    def direction(self) -> Doubles: ...
    @property
    def origin(self) -> Doubles: ...
    @property
    def force(self) -> Doubles: ...
    @property
    def torque(self) -> Doubles: ...
    @property
    def motor(self) -> Motor: ...
    @motor.setter
    def motor(self, value: Optional[Motor]) -> None: ...

class WorldState:
    time: Final[float]
    nbytes: Final[int]

class World:
    def __init__(
        self,
        scene: Union[Scene, File],
        voxel: Optional[float] = None,
        progress: Progress = None,
        *,
        method: str = "cloud",
        backend: str = "cpu",
        threads: int = 0,
        unit: Unit = 1.0,
        shell: Optional[float] = None,
        law: Optional[Law] = None,
        friction: Optional[float] = None,
        tissues: Union[None, str, Sequence[Tissue]] = None,
        samples: Optional[int] = None,
        reuse: Optional[float] = None,
        tolerance: float = 0.0,
        iterations: Optional[int] = None,
        sleep: bool = False,
        cache: bool = True,
    ) -> None: ...
    def __len__(self) -> int: ...
    def __getitem__(self, name: str) -> WorldBody: ...
    def __contains__(self, name: str) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    names: Final[list[str]]
    joints: Final[list[str]]
    def joint(self, name: str, axis: int = 0) -> WorldJoint: ...
    @property
    def time(self) -> float: ...
    voxel: Final[float]
    @property
    def positions(self) -> Doubles: ...
    @property
    def orientations(self) -> Doubles: ...
    @property
    def velocities(self) -> Doubles: ...
    @property
    def angular_velocities(self) -> Doubles: ...
    @property
    def energy(self) -> dict[str, float]: ...
    @property
    def hash(self) -> int: ...
    @property
    def advice(self) -> list[str]: ...
    def step(self, seconds: Optional[float] = None) -> None: ...
    def run(
        self,
        seconds: float,
        step: Optional[float] = None,
        substeps: int = 1,
        *,
        replay: Optional[File] = None,
        observe: Optional[Callable[[World], object]] = None,
        progress: Progress = None,
    ) -> Optional[Replay]: ...
    def view(
        self,
        seconds: Optional[float] = None,
        step: Optional[float] = None,
        substeps: int = 1,
        *,
        port: int = 0,
        speed: float = 1.0,
        observe: Optional[Callable[[World], object]] = None,
        announce: Optional[Callable[[str], object]] = None,
    ) -> None: ...
    def stop(self) -> None: ...
    def save(self) -> WorldState: ...
    def restore(self, state: WorldState) -> None: ...
    def copy(self) -> World: ...
    def __copy__(self) -> World: ...
    def __deepcopy__(self, memo: dict[int, object]) -> World: ...
    def contacts(self) -> Records: ...
    def find_contacts(self) -> None: ...
    def penetration(self) -> float: ...

class Worlds:
    def __init__(
        self,
        scene: Union[Scene, File],
        count: int,
        voxel: Optional[float] = None,
        progress: Progress = None,
        *,
        method: str = "cloud",
        backend: str = "cpu",
        threads: int = 0,
        unit: Unit = 1.0,
        shell: Optional[float] = None,
        law: Optional[Law] = None,
        friction: Optional[float] = None,
        tissues: Union[None, str, Sequence[Tissue]] = None,
        samples: Optional[int] = None,
        reuse: Optional[float] = None,
        tolerance: float = 0.0,
        iterations: Optional[int] = None,
        sleep: bool = False,
        cache: bool = True,
    ) -> None: ...
    def __len__(self) -> int: ...
    def __getitem__(self, number: int) -> World: ...
    names: Final[list[str]]
    positions: Final[Doubles]
    orientations: Final[Doubles]
    velocities: Final[Doubles]
    angular_velocities: Final[Doubles]
    forces: Final[Doubles]
    torques: Final[Doubles]
    times: Final[Doubles]
    def index(self, name: str) -> int: ...
    def step(self, seconds: Optional[float] = None, substeps: int = 1) -> None: ...
    def reset(self, worlds: Chosen = None) -> None: ...
    def save(self, worlds: Chosen = None) -> list[WorldState]: ...
    def restore(self, states: Sequence[WorldState], worlds: Chosen = None) -> None: ...
    def read(self) -> None: ...
    def contact_wrenches(self) -> Doubles: ...
