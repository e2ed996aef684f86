"""Actors of VTK, as far as they can be culled: anything unknown is left alone."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

# Classes whose pixels lie where their triangles do. Followers, levels of detail and assemblies place theirs otherwise.
_ACTORS = frozenset({"vtkActor", "vtkOpenGLActor"})
_MAPPERS = frozenset({"vtkDataSetMapper", "vtkOpenGLPolyDataMapper", "vtkPolyDataMapper"})
_COMPOSITE = "vtkCompositePolyDataMapper"
# Data sets whose faces are flat, so that any split into triangles is the one that is drawn.
_FLAT = frozenset({"vtkImageData", "vtkRectilinearGrid", "vtkUniformGrid"})
_SURFACE = 2
# What gives data away as they are.
_STILL = frozenset({"vtkTrivialProducer"})

Matrix = npt.NDArray[np.float64]


@dataclass
class Shape:
    """What a data set draws, in its own space."""

    bounds: npt.NDArray[np.float64]
    """(2, 3): low and high corner."""
    vertices: npt.NDArray[Any] | None = None
    """Where it hides what is behind it: its vertices (n, 3), and its triangles."""
    faces: npt.NDArray[np.int64] | None = None


@dataclass
class Part:
    """What is culled on its own: the data of an actor, or a block of them."""

    data: Any
    state: tuple[Any, ...] = ()
    """Equal while the data are the same and hide as much."""
    id: int = -1
    """Its instance in the scene; below 0 while it has none."""
    local: Matrix = field(default_factory=lambda: np.eye(4))
    """From the mesh in the scene to the actor's own space."""


@dataclass
class Tracked:
    """An actor of a renderer, and what was last known of it."""

    actor: Any
    time: int = -1
    """When the actor, its looks or its place changed; -1 where it is to be read."""
    is_shown: bool = False
    matrix: Matrix | None = None
    parts: list[Part] = field(default_factory=list)
    """Nothing where it is left alone."""
    changes: int = 0
    """How often the data changed."""
    hides: bool = False
    looks: Any = None
    """By which blocks are hidden; nothing where that is the user's."""
    at: int = 0
    """Where its calls begin in the list of all."""
    _times: list[Any] = field(default_factory=list)
    """The calls that say when something changed that the actor does not know: its shader, mapper, data, and blocks."""
    _seen: list[int] = field(default_factory=list)
    """What they said."""
    _is_live: bool = False
    """Whether the data are made by a pipeline, which is to be run before they are asked."""

    def calls(self) -> list[Any]:
        """Returns the calls that say together when anything of it changed."""
        return [self.actor.GetRedrawMTime if self._is_live else self.actor.GetMTime, *self._times]

    def has_changed(self) -> bool:
        """Whether anything has changed since `note`."""
        if self._is_live:
            self.actor.GetRedrawMTime()
        return self.actor.GetMTime() != self.time or [time() for time in self._times] != self._seen

    def times(self) -> list[int]:
        """Returns what `calls` say where nothing has changed since `note`."""
        return [-1 if self._is_live else self.time, *self._seen]

    def note(self) -> None:
        """Takes everything as it is now for what is known."""
        self.time, self._seen = self.actor.GetMTime(), [time() for time in self._times]

    def read(self, may_hide: bool) -> list[Any] | None:
        """Returns the data of each part; nothing where pixels may lie beyond the triangles of the data."""
        actor, mapper, shader = self.actor, self.actor.GetMapper(), self.actor.GetShaderProperty()
        self.looks, self.hides, self._is_live = None, False, False
        self._times = [shader.GetMTime]
        if mapper is None:
            return None
        self._times.append(mapper.GetMTime)
        if not _is_plain(actor, shader) or mapper.GetNumberOfInputPorts() == 0:
            return None
        source = mapper.GetInputAlgorithm(0, 0) if mapper.GetNumberOfInputConnections(0) else None
        if source is not None and source.GetClassName() not in _STILL:
            self._is_live = True
            source.Update()
        data = mapper.GetInputDataObject(0, 0)
        if data is None:
            return None
        self._times.append(data.GetMTime)
        self.hides = may_hide and _hides(actor, mapper)
        if mapper.GetClassName() in _MAPPERS:
            return [data]
        if mapper.GetClassName() != _COMPOSITE:
            return None
        blocks, looks = _leaves(data), mapper.GetCompositeDataDisplayAttributes()
        self._times += [block.GetMTime for block in blocks]
        if looks is not None:
            self._times.append(looks.GetMTime)
            self.looks = None if looks.HasBlockVisibilities() else looks
            self.hides = self.hides and self.looks is not None and not looks.HasBlockOpacities()
        if not all(block.IsA("vtkPolyData") for block in blocks):
            return None
        return [block for block in blocks if block.GetNumberOfPoints()]

    def state_of(self, data: Any) -> tuple[Any, ...]:
        """Returns the state of a part that has these data."""
        return (self.hides, data.__this__, data.GetMTime())


def tracked(prop: Any) -> Tracked | None:
    """Returns an actor of a class that is known; of everything else nothing."""
    return Tracked(prop) if prop.GetClassName() in _ACTORS else None


def matrix_of(actor: Any) -> Matrix | None:
    """Returns where an actor is; nothing where that is not affine or not finite."""
    matrix = np.array(actor.GetMatrix().GetData()).reshape(4, 4)
    is_plain = np.isfinite(matrix).all() and matrix[3].tolist() == [0, 0, 0, 1]
    return matrix if is_plain else None


def shape_of(data: Any, hides: bool) -> Shape | None:
    """Returns what a data set draws; nothing where it draws points or lines. Reads all of its data."""
    surface = _surface(data)
    if surface is None:
        return None
    points, faces = surface
    if not len(points) or not np.isfinite(points).all():
        return None
    bounds = np.array([points.min(0), points.max(0)], np.float64)
    return Shape(bounds, points, faces) if hides and faces is not None else Shape(bounds)


def _is_plain(actor: Any, shader: Any) -> bool:
    """Whether an actor is drawn as surfaces alone, by VTK's own shaders. Edges and points are wider than they are."""
    look = actor.GetProperty()
    codes = ("Vertex", "Fragment", "Geometry", "TessControl", "TessEval")
    keys = actor.GetPropertyKeys()
    return (
        look.GetRepresentation() == _SURFACE
        and not look.GetEdgeVisibility()
        and not look.GetVertexVisibility()
        and shader.GetNumberOfShaderReplacements() == 0
        and not any(getattr(shader, f"Has{code}ShaderCode", bool)() for code in codes)
        and (keys is None or keys.GetNumberOfKeys() == 0)
        and getattr(actor, "GetCoordinateSystem", int)() == 0
    )


def _hides(actor: Any, mapper: Any) -> bool:
    """Whether every pixel of an actor's triangles is drawn, at their own depth. Textures may have holes."""
    look, planes = actor.GetProperty(), mapper.GetClippingPlanes()
    return (
        not actor.HasTranslucentPolygonalGeometry()
        and not look.GetBackfaceCulling()
        and not look.GetFrontfaceCulling()
        and actor.GetBackfaceProperty() is None
        and actor.GetTexture() is None
        and look.GetNumberOfTextures() == 0
        and (planes is None or planes.GetNumberOfItems() == 0)
        and mapper.GetResolveCoincidentTopology() == 0
    )


def _leaves(data: Any) -> list[Any]:
    """Returns the data sets of a composite one, in their order."""
    walk = data.NewIterator()
    walk.InitTraversal()
    found = []
    while not walk.IsDoneWithTraversal():
        found.append(walk.GetCurrentDataObject())
        walk.GoToNextItem()
    return found


def _surface(data: Any) -> tuple[npt.NDArray[Any], npt.NDArray[np.int64] | None] | None:
    """Returns points and triangles of a data set; no triangles where those that are drawn are not known, and nothing
    where points or lines are drawn too."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    if not data.IsA("vtkDataSet"):
        return None
    is_known = data.GetPointGhostArray() is None and data.GetCellGhostArray() is None
    if not data.IsA("vtkPolyData"):
        from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

        outside = vtkDataSetSurfaceFilter()
        outside.SetInputData(data)
        outside.Update()
        is_flat = data.GetClassName() in _FLAT
        data = outside.GetOutput()
        is_known = is_known and (is_flat or data.GetPolys().GetMaxCellSize() <= 3)
    if data.GetNumberOfVerts() or data.GetNumberOfLines():
        return None
    if data.GetNumberOfPoints() == 0:
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64)
    points = vtk_to_numpy(data.GetPoints().GetData())
    if points.dtype not in (np.float32, np.float64):
        points = points.astype(np.float64)
    if not is_known or data.GetNumberOfStrips():
        return points, None
    cells = data.GetPolys()
    offsets = vtk_to_numpy(cells.GetOffsetsArray()).astype(np.int64)
    corners = vtk_to_numpy(cells.GetConnectivityArray()).astype(np.int64)
    return points, _fans(offsets, corners)


def _fans(offsets: npt.NDArray[np.int64], corners: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Returns the triangles that polygons are drawn as: fans around their first corners."""
    counts = np.maximum(np.diff(offsets) - 2, 0)
    first = np.repeat(offsets[:-1], counts)
    nth = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    fans: npt.NDArray[np.int64] = corners[np.stack([first, first + nth + 1, first + nth + 2], axis=1)]
    return fans
