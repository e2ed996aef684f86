"""The native half of cullet. Use it through `pycullet` itself, where `Scene` is made of meshes and files."""

import os
from collections.abc import Sequence
from typing import Any, Literal, overload

import numpy as np
import numpy.typing as npt

__version__: str
STAGES: list[str]
"""Names of the stages of culling, in the order in which they run. Number 1 is the first."""
BUILTIN_SCENES: list[str]
"""Names of the scenes that are made by rule; `Scene.builtin` makes them."""

_Settings = Culler | Literal["exact", "balanced", "fast"]
_Point = Sequence[float] | npt.NDArray[np.floating[Any]]
_Points = npt.NDArray[np.floating[Any]] | Sequence[Sequence[float]]
_Ids = int | Sequence[int] | npt.NDArray[np.integer[Any]]

class FileError(ValueError):
    """A file is of no known kind, or broken: the message names the item, its value and the limit."""

class StaleError(RuntimeError):
    """A result is of a scene as it was before it changed."""

class Camera:
    """One camera: where it stands, what it projects, how many pixels, and which layers it sees. It never changes."""

    @staticmethod
    def look_at(
        eye: _Point,
        target: _Point,
        *,
        size: tuple[int, int] | None = None,
        fov_y: float = 60.0,
        near: float = 0.1,
        far: float = ...,
        up: _Point | None = None,
        layers: int = 0xFFFFFFFF,
    ) -> Camera:
        """A perspective camera.

        ``size`` is width and height in pixels, 1280 × 720 unless given; ``fov_y`` the full vertical angle in degrees,
        above 0 and below 180; ``near`` above 0; ``far`` beyond it, and infinite unless given; ``up`` is +Y unless
        given, or +Z where the camera looks along Y. Instances that share no bit with ``layers`` are not seen.

        Raises `ValueError` for numbers that are out of range or not finite, and where eye and target are one point.
        """

    @staticmethod
    def orthographic(
        eye: _Point,
        target: _Point,
        *,
        height: float,
        near: float,
        far: float,
        size: tuple[int, int] | None = None,
        up: _Point | None = None,
        layers: int = 0xFFFFFFFF,
    ) -> Camera:
        """A camera with parallel lines of sight, ``height`` units of the world from the lower edge to the upper one."""

    @staticmethod
    def from_matrix(
        clip_from_world: npt.NDArray[np.floating[Any]],
        *,
        size: tuple[int, int],
        depth: Literal["standard", "reversed"] = "standard",
        layers: int = 0xFFFFFFFF,
    ) -> Camera:
        """A camera of its view-projection matrix, (4, 4): projection @ view, clip depth from 0 to 1.

        ``depth`` is ``standard`` where 0 is near, ``reversed`` where 1 is. A matrix of OpenGL, whose depth goes from
        −1 to 1, is to be turned first: ``m[2] = (m[2] + m[3]) / 2``.
        """

    @property
    def eye(self) -> npt.NDArray[np.float64] | None:
        """(3,): where it stands; None for parallel lines of sight."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""

    @property
    def layers(self) -> int:
        """The layers that it sees, a bit each."""

    @property
    def depth(self) -> Literal["standard", "reversed"]:
        """Clip depth that is near: 0 in the standard, 1 where it is reversed, as `look_at` makes it."""

    @property
    def is_orthographic(self) -> bool:
        """Whether lines of sight are parallel."""

    @property
    def clip_from_world(self) -> npt.NDArray[np.float64]:
        """(4, 4): projection @ view."""

    def with_size(self, size: tuple[int, int]) -> Camera:
        """The same camera with other pixels; what it projects stays, so that another shape stretches the picture."""

class Cameras:
    """Many cameras, for `Scene.cull` and the like. It is a sequence: ``cameras[3]`` is a `Camera`, a slice `Cameras`."""

    @staticmethod
    def look_at(
        eyes: _Points,
        targets: _Points | _Point,
        *,
        size: tuple[int, int] | None = None,
        fov_y: float = 60.0,
        near: float = 0.1,
        far: float = ...,
        up: _Point | None = None,
        layers: int = 0xFFFFFFFF,
    ) -> Cameras:
        """Returns cameras like `Camera.look_at`, for ``eyes`` (n, 3) and ``targets`` (n, 3), or one target for all."""

    @staticmethod
    def from_matrices(
        clip_from_world: npt.NDArray[np.floating[Any]],
        *,
        size: tuple[int, int],
        depth: Literal["standard", "reversed"] = "standard",
        layers: int = 0xFFFFFFFF,
    ) -> Cameras:
        """Returns cameras like `Camera.from_matrix`, for matrices (n, 4, 4)."""

    @staticmethod
    def _of(camera: Camera | Cameras) -> Cameras: ...
    @staticmethod
    def along(
        scene: Scene,
        path: str = "orbit",
        count: int = 8,
        *,
        size: tuple[int, int] | None = None,
        fov_y: float | None = None,
        near: float | None = None,
        far: float | None = None,
        seed: int = 0,
    ) -> Cameras:
        """Cameras around a scene (``orbit``), through it (``walk``, ``fly``), or its file's own (``camera:NAME``).

        +Y is up. Near and far fit the scene. Raises `ValueError` where the scene is empty.
        """

    @property
    def eyes(self) -> npt.NDArray[np.float64]:
        """(n, 3): where they stand; NaN for parallel lines of sight."""

    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, at: int) -> Camera: ...
    @overload
    def __getitem__(self, at: slice) -> Cameras: ...

class Culler:
    """Settings of culling. They never change; the name of a preset stands for its settings wherever one is taken."""

    def __init__(
        self,
        preset: Literal["exact", "balanced", "fast"] = "balanced",
        *,
        output: Literal["instances", "clusters", "triangles"] = "clusters",
        reasons: bool = False,
        without: Sequence[str] = (),
        min_pixels: float | None = None,
    ) -> None:
        """``exact`` finds as much as can be proved, ``balanced`` what pays in most frames, ``fast`` what is found
        soonest; none drops anything visible.

        ``output`` is how deep the answer goes, ``reasons`` whether `Result.reasons` is kept, ``without`` the stages
        that are left out, of `pycullet.STAGES`. With ``min_pixels``, what is narrower and lower than that on the screen
        is dropped too, which is the one setting that may lose something visible.
        """

    @property
    def preset(self) -> Literal["exact", "balanced", "fast"]:
        """The preset that it was made of."""

    @property
    def stages(self) -> list[str]:
        """The stages that run, in their order; in scenes without cells, ``pvs`` and ``portal`` do nothing."""

class Result:
    """Visible instances of one camera: everything it sees is among them. In a notebook it shows both
    pictures and the funnel."""

    @property
    def visible(self) -> npt.NDArray[np.uint32]:
        """(n,): ids of visible instances, ascending. The same array each time."""

    def mask(self, out: npt.NDArray[np.bool_] | None = None) -> npt.NDArray[np.bool_]:
        """(ids,): whether each id is visible; written into ``out`` where it is given."""

    @property
    def levels(self) -> npt.NDArray[np.uint32]:
        """(n,): the level of detail that is drawn of each instance in ``visible``, 0 for the mesh itself."""

    @property
    def partial(self) -> npt.NDArray[Any]:
        """Clusters of instances that are drawn in part: ``id``, ``level``, ``first_cluster``, ``cluster_count``.

        An id that is visible and not in here is drawn whole.
        """

    @property
    def triangles(self) -> npt.NDArray[Any]:
        """Every triangle that is left: ``id`` and ``triangle``, by its number in the mesh as it was given; of an
        instance that is drawn at a level above 0, in `Scene.level_mesh`.

        Raises `AttributeError` unless the culler's ``output`` is ``triangles``.
        """

    @property
    def reasons(self) -> npt.NDArray[Any]:
        """Number of the ``stage`` in `pycullet.STAGES` that dropped each id, from 1, and a ``detail``
        (for the frustum, which plane); 0 for a visible instance. Raises `AttributeError` unless the
        culler keeps ``reasons``."""

    @property
    def funnel(self) -> npt.NDArray[Any]:
        """A row for each stage that ran: ``stage``, ``unit``, and how many instances, clusters and triangles came in
        (``instances_in``, ...) and went on (``instances_out``, ...)."""

    @property
    def triangle_count(self) -> int:
        """How many triangles will be drawn."""

    @property
    def scene(self) -> Scene:
        """The scene that was culled."""

    @property
    def camera(self) -> Camera:
        """The camera that it was culled for."""

    def pictures(self, width: int = 480) -> tuple[bytes, bytes]:
        """PNG files of what the camera sees, and of the scene from outside by the kind of culling, ``width`` pixels
        wide (320 to 4096). Raises `StaleError` where the scene has changed since."""

    def _repr_html_(self) -> str: ...
    def __len__(self) -> int:
        """How many instances are visible."""

class Results:
    """Visible instances of many cameras. ``results[i]`` has the ids of camera i, ascending."""

    @property
    def ids(self) -> npt.NDArray[np.uint32]:
        """The ids of all cameras, one after the other."""

    @property
    def offsets(self) -> npt.NDArray[np.int64]:
        """(cameras + 1,): those of camera i are ``ids[offsets[i]:offsets[i + 1]]``."""

    @property
    def levels(self) -> npt.NDArray[np.uint32]:
        """The level of detail that is drawn of each of ``ids``, 0 for the mesh itself."""

    @property
    def counts(self) -> npt.NDArray[np.int64]:
        """(cameras,): how many instances each sees."""

    @property
    def triangle_counts(self) -> npt.NDArray[np.uint64]:
        """(cameras,): how many triangles will be drawn for each."""

    @property
    def funnel(self) -> npt.NDArray[Any]:
        """Funnels of all cameras like `Result.funnel`, with the number of the ``camera``."""

    def mask(self, out: npt.NDArray[np.bool_] | None = None) -> npt.NDArray[np.bool_]:
        """(cameras, ids): whether each camera sees each id; written into ``out`` where it is given."""

    def __len__(self) -> int: ...
    def __getitem__(self, at: int) -> npt.NDArray[np.uint32]: ...

class Pvs:
    """Visible sets of some cells, which are boxes that an eye may be in.

    Found by sampled lines, so not conservative: `missing` says how much is likely to be missing.
    """

    @property
    def cells(self) -> npt.NDArray[np.float64]:
        """(n, 2, 3): low and high corners."""

    @property
    def missing(self) -> npt.NDArray[np.float32]:
        """(n,): the share of looks from each cell that is estimated to end on something that its set lacks."""

    @property
    def rays(self) -> int:
        """Rays that were traced; 0 where it was opened from a file."""

    @property
    def matrix(self) -> npt.NDArray[np.bool_]:
        """(cells, ids): whether each cell sees each id."""

    def cell_of(self, points: _Points | _Point) -> npt.NDArray[np.int32]:
        """The cell of each point, −1 for one in none."""

    def visible(self, cells: _Ids) -> npt.NDArray[np.uint32]:
        """The ids that may be seen from a cell, or from any of some, ascending."""

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a file that `Scene.open_pvs` and the program ``cullet`` open."""

    def __len__(self) -> int: ...

class Scene:
    """Native part of `pycullet.Scene`."""

    def __init__(self) -> None: ...
    title: str
    @property
    def warnings(self) -> list[str]:
        """Defects of the file that did not stop it from loading."""

    @property
    def instance_count(self) -> int:
        """How many instances there are."""

    @property
    def id_count(self) -> int:
        """Ids given so far, those of removed instances included: the length of masks."""

    @property
    def mesh_count(self) -> int:
        """How many meshes they share."""

    @property
    def triangle_count(self) -> int:
        """Triangles of all instances."""

    @property
    def version(self) -> int:
        """Rises with every change."""

    @property
    def ids(self) -> npt.NDArray[np.uint32]:
        """The ids of all instances that are there."""

    @property
    def bounds(self) -> npt.NDArray[np.float64] | None:
        """(2, 3): low and high corner of everything; None for an empty scene."""

    def boxes(self, ids: _Ids | None = None) -> npt.NDArray[np.float64]:
        """(n, 2, 3): the boxes that culling tests, rounded outward to float32, of all instances or of ``ids``."""

    def transforms(self, ids: _Ids | None = None) -> npt.NDArray[np.float64]:
        """(n, 4, 4): where all instances are, or ``ids``."""

    def mesh_of(self, ids: _Ids | None = None) -> npt.NDArray[np.uint32]:
        """(n,): the number of the mesh of each."""

    def mesh(self, number: int) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.uint32]]:
        """Vertices (n, 3) and triangles (m, 3) of a mesh, in its own space."""

    def name(self, id: int) -> str:
        """The name of an instance: that of its node, or of its mesh with a number."""

    def add_instances(
        self, mesh: int, transforms: npt.NDArray[np.floating[Any]] | None = None, *, layers: int = 1
    ) -> npt.NDArray[np.uint32]:
        """Adds an instance of a mesh for each transform, (n, 4, 4) or (4, 4); returns their ids."""

    def set_transforms(self, ids: _Ids, transforms: npt.NDArray[np.floating[Any]]) -> None:
        """Moves instances: ``transforms`` is (n, 4, 4), one for each id. All are checked before any is moved."""

    def set_layers(self, ids: _Ids, layers: int) -> None:
        """Puts instances into layers, a bit each; in none, an instance is never seen."""

    def remove(self, ids: _Ids) -> None:
        """Removes instances. Their ids are not given again."""

    def commit(self) -> None:
        """Sorts instances by place and prepares new meshes: once after much was added or moved far, for speed. Without,
        answers are as right, and more is kept of meshes that are new."""

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes GLB, PLY, OBJ or STL, by the ending. Warns of what the file does not have."""

    @overload
    def cull(
        self, camera: Camera, culler: _Settings | None = None, *, lod: float | None = None, threads: int = 0
    ) -> Result: ...
    @overload
    def cull(
        self, camera: Cameras, culler: _Settings | None = None, *, lod: float | None = None, threads: int = 0
    ) -> Results:
        """Returns what a camera, or each of many, may see.

        Conservative: nothing visible is missing. Many cameras are spread over ``threads`` threads, 0 for as many as
        there are processors; the answers are the same. Other threads of Python go on meanwhile, and may cull the same
        scene; one that changes it then gets a `RuntimeError`.

        With ``lod``, an instance whose mesh has levels is drawn at the coarsest one whose error is at most that many
        pixels at the centre of the picture, as `Result.levels` says; at 0 and without, in full.
        """

    def bake_levels(self, *, threads: int = 0) -> npt.NDArray[Any]:
        """Bakes levels of detail of every mesh: the whole mesh again and again, each time with fewer triangles.

        Returns a row for each level: ``mesh``, ``level`` (0 is the mesh itself), ``triangles`` and ``error``, the
        largest distance between the level and the mesh that was measured, in units of the mesh. `cull` draws levels
        with ``lod``. They replace levels that a mesh had, and are held by meshes of their own, which count in
        `mesh_count`; a mesh that cannot be simplified has level 0 alone. The same on every run and machine. Costs
        seconds for meshes of a hundred thousand triangles, on ``threads`` threads, 0 for one a processor; Ctrl-C
        interrupts it, and then nothing has changed.
        """

    def level_mesh(
        self, mesh: int, number: int = 1
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.uint32], npt.NDArray[np.uint32]]:
        """Vertices (n, 3), triangles (m, 3) and the level of each triangle (m,), of all levels of a mesh.

        ``number`` is which of its levels, from 1, as ``level`` of `Result.partial`: a file may bring several kinds.
        `Result.triangles` numbers the triangles of an instance that is drawn at a level above 0 as they are here.
        Raises `IndexError` where the mesh has no such levels.
        """

    def bake_pvs(
        self,
        cells: int | tuple[int, int, int] = 64,
        *,
        region: _Points | None = None,
        rays: int = 10_000_000,
        missing: float = 2e-5,
        seed: int = 1,
        threads: int = 0,
    ) -> Pvs:
        """Finds what may be seen from each of some cells, by sampled lines; Ctrl-C ends it.

        ``cells`` are so many where geometry is near, or a grid of so many along each axis, in ``region``, (2, 3), or
        else the bounds of the scene. It ends after ``rays`` rays, or where the share of looks that is estimated to
        miss something is at most ``missing``. The same for any number of threads.
        """

    def open_pvs(self, path: str | os.PathLike[str]) -> Pvs:
        """Opens sets that were baked of this scene. Raises `FileError` where they are of another."""

    def set_pvs(self, pvs: Pvs | None) -> None:
        """Culls by these sets from now on while the eye is in one of their cells; None for no more."""

    def __len__(self) -> int: ...
    def _open(
        self, path: str | os.PathLike[str], *, up: str | None = None, two_sided: bool | None = None
    ) -> None: ...
    def _set_name(self, id: int, name: str) -> None: ...
    def _build(self, spec: str) -> None: ...
    def _add_mesh(
        self,
        vertices: npt.NDArray[np.floating[Any]],
        faces: npt.NDArray[np.integer[Any]],
        *,
        two_sided: bool | None = None,
        color: list[float] | None = None,
        name: str | None = None,
        opaque: bool = True,
    ) -> tuple[int, list[float]]: ...
    def _cut(
        self, planes: npt.ArrayLike, *, cap: bool = True, keep: str = "inside"
    ) -> tuple[
        npt.NDArray[np.float64], npt.NDArray[np.uint32], npt.NDArray[np.uint32], npt.NDArray[np.bool_]
    ]: ...
    def _explain(
        self, camera: Camera, id: int, culler: _Settings | None = None
    ) -> tuple[str | None, list[Any], list[int]]: ...
    def _verify(
        self,
        camera: Camera | Cameras,
        culler: _Settings | None = None,
        *,
        samples: int = 4,
        seed: int = 0,
        threads: int = 0,
    ) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]: ...
    def _render(
        self, camera: Camera, culler: _Settings | None = None
    ) -> tuple[
        npt.NDArray[np.uint8], npt.NDArray[np.float64], npt.NDArray[np.int32], npt.NDArray[np.int32]
    ]: ...
    def _occluders(
        self, *, apply: bool = True
    ) -> list[
        tuple[npt.NDArray[np.float32], list[npt.NDArray[np.float32]], npt.NDArray[np.float32], float]
    ]: ...

_Items = tuple[int, int]

def plan_text(scene: str, settings: str) -> str:
    """Plans a bake of a file or a built-in scene; the settings are JSON, as a plan has them."""

def content_hash(scene: str) -> int | None:
    """Hash of what a file contains; of a built-in scene None."""

class UnitFolder:
    """A folder of finished units, as ``cullet pvs --units`` has it."""

    def __init__(self, path: str | os.PathLike[str]) -> None: ...
    def units(self, key: int, round: int) -> list[_Items]:
        """Items of the units of a round that lie there, whole or not."""

    def read(self, key: int, round: int, items: _Items) -> bytes | None:
        """The bytes of a unit, or None."""

    def write(self, key: int, round: int, items: _Items, bytes: bytes) -> None:
        """Keeps a unit: all of it or nothing. Raises `OSError` where that fails."""

class Made:
    """Result of a job."""

    @property
    def sets(self) -> bytes:
        """The sets, as ``cullet pvs -o`` writes them."""

    @property
    def map(self) -> bytes | None:
        """The map with the sets in it, where a map was baked."""

    @property
    def cells(self) -> int:
        """How many cells there are."""

    @property
    def targets(self) -> int:
        """How many things each cell may see: cells, instances or clusters."""

    @property
    def visible_pairs(self) -> int:
        """Pairs of a cell and what it sees."""


class Job:
    """A planned bake that is held open while its units are run here and elsewhere."""

    def __init__(self, plan: str, scene: str, threads: int = 1) -> None: ...
    @property
    def product(self) -> Literal["cells", "view-cells"]:
        """Product of the bake: sets of a file's cells, or of view cells of a scene."""

    @property
    def key(self) -> int:
        """Key that names its units."""

    @property
    def round(self) -> int:
        """The round that is next."""

    @property
    def is_done(self) -> bool:
        """Whether all rounds are merged."""

    @property
    def shares(self) -> tuple[float, float]:
        """The share of the work that is over before the round that is next, and once that has ended."""

    def missing(self, have: Sequence[_Items], units: int) -> list[_Items]:
        """The units that the round lacks beside those that there are, of even cost, so many at the most."""

    def tiles(self, have: Sequence[_Items]) -> list[_Items]:
        """Returns the units that lie end to end, of those that there are."""

    def is_whole(self, items: _Items, bytes: bytes) -> bool:
        """Whether bytes are a whole unit of these items of the round that is next."""

    def run(self, items: _Items, threads: int = 1) -> bytes:
        """Runs a unit of the round that is next. Ctrl-C ends it."""

    def merge(self, units: Sequence[tuple[_Items, bytes]]) -> None:
        """Ends the round with its units, in any order. Raises `ValueError` where one is damaged; then nothing is changed."""

    def finish(self) -> Made:
        """Ends the job. Raises `ValueError` where rounds are left."""

def program(args: Sequence[str]) -> int:
    """Runs the program ``cullet`` on its name and arguments, and returns its exit code. A wrong command line ends the process."""
