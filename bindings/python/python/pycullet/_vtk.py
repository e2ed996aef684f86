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

_Matrix = npt.NDArray[np.float64]


@dataclass
class Shape:
    """What an actor draws, in its own space."""

    state: tuple[Any, ...]
    """Equal while the data are the same and hide as much."""
    bounds: npt.NDArray[np.float64] | None = None
    """(2, 3): low and high corner; none where the state is as it was."""
    vertices: npt.NDArray[Any] | None = None
    """Where it hides what is behind it: its vertices (n, 3), and its triangles."""
    faces: npt.NDArray[np.int64] | None = None


@dataclass
class Tracked:
    """An actor of a renderer, and what was last known of it."""

    actor: Any
    shader: Any = None
    leaves: list[Any] = field(default_factory=list)
    """Blocks of a composite data set, whose changes the actor does not know."""
    key: tuple[int, ...] = ()
    """Changes with anything that this module reads."""
    is_shown: bool = False
    state: tuple[Any, ...] = ()
    changes: int = 0
    """How often the data changed."""
    id: int | None = None
    """Its instance in the scene; none where it is left alone."""
    local: _Matrix = field(default_factory=lambda: np.eye(4))
    """From the mesh in the scene to the actor's own space."""

    def now(self) -> tuple[int, ...]:
        """Returns the key as it is now. Costs some microseconds."""
        shader = 0 if self.shader is None else self.shader.GetMTime()
        if not self.leaves:
            return (self.actor.GetRedrawMTime(), shader)
        return (self.actor.GetRedrawMTime(), shader, *(leaf.GetMTime() for leaf in self.leaves))


def tracked(prop: Any) -> Tracked | None:
    """Returns an actor of a class that is known; of everything else nothing."""
    if prop.GetClassName() not in _ACTORS:
        return None
    return Tracked(prop)


def matrix_of(actor: Any) -> _Matrix | None:
    """Returns where an actor is; nothing where that is not affine or not finite."""
    matrix = np.array(actor.GetMatrix().GetData()).reshape(4, 4)
    is_plain = np.isfinite(matrix).all() and matrix[3].tolist() == [0, 0, 0, 1]
    return matrix if is_plain else None


def shape_of(item: Tracked, may_hide: bool) -> Shape | None:
    """Returns what an actor draws; nothing where its pixels may lie beyond its triangles. Reads all of its data, unless
    the state is as it was."""
    actor, mapper = item.actor, item.actor.GetMapper()
    item.shader, item.leaves = actor.GetShaderProperty(), []
    if mapper is None or not _is_plain(actor, item.shader):
        return None
    data = mapper.GetInputDataObject(0, 0)
    if data is None:
        return None
    hides = may_hide and _hides(actor, mapper)
    if mapper.GetClassName() in _MAPPERS:
        parts = [data]
    elif mapper.GetClassName() == _COMPOSITE:
        item.leaves = [data, *leaves(data)]
        parts = item.leaves[1:]
        if not all(part.IsA("vtkPolyData") for part in parts):
            return None
        looks = mapper.GetCompositeDataDisplayAttributes()
        if looks is not None:
            item.leaves.append(looks)
            hides = hides and not (looks.HasBlockVisibilities() or looks.HasBlockOpacities())
    else:
        return None
    state = (hides, *((part.__this__, part.GetMTime()) for part in parts))
    if state == item.state:
        return Shape(state)
    surfaces = [_surface(part) for part in parts]
    if not surfaces or any(surface is None for surface in surfaces):
        return None
    all_surfaces = [surface for surface in surfaces if surface is not None]
    points = [points for points, _ in all_surfaces if len(points)]
    if not points or not all(np.isfinite(p).all() for p in points):
        return None
    low = np.min([p.min(0) for p in points], axis=0)
    high = np.max([p.max(0) for p in points], axis=0)
    shape = Shape(state, np.array([low, high], np.float64))
    if hides and all(faces is not None for _, faces in all_surfaces):
        starts = np.cumsum([0, *(len(points) for points, _ in all_surfaces)])
        faces = [f + start for (_, f), start in zip(all_surfaces, starts) if f is not None]
        shape.vertices = np.concatenate([points for points, _ in all_surfaces])
        shape.faces = np.concatenate(faces)
    return shape


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


def leaves(data: Any) -> list[Any]:
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
    return corners[np.stack([first, first + nth + 1, first + nth + 2], axis=1)]
