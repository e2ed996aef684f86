"""The scene, and what it takes from other packages."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from . import _native
from ._answers import Explanation, Image, Occluder, Verification, explanation
from ._report import Report, report

if TYPE_CHECKING:
    import trimesh

Preset = Literal["exact", "balanced", "fast"]
Settings = _native.Culler | Preset


class Scene(_native.Scene):
    """Meshes shared by instances, and what is visible of them.

    Made by `open`, `from_trimesh`, `from_pyvista`, `from_arrays` or `builtin`; or empty, to be filled by `add`. All
    arrays are copied: whoever changes a mesh afterwards makes a new scene, or moves instances by `set_transforms`.
    `changed_sources` says whether that is due.
    """

    _sources: list[tuple[str, Any, int]]

    @classmethod
    def open(
        cls,
        path: str | os.PathLike[str],
        *,
        up: Literal["y", "z"] | None = None,
        two_sided: bool | None = None,
    ) -> Scene:
        """Opens a GLB, glTF, OBJ, PLY, STL or OFF file, an ``OCCSCN01``, or a map of Quake or Quake 3.

        What was baked into it comes along: levels, occluders, cells. ``up`` is the axis of the file that points up,
        where the format does not say; ``two_sided`` overrides the sides: in glTF those of each material (one-sided unless
        ``doubleSided`` says otherwise), in other formats the rule of `from_arrays`.

        Raises `FileNotFoundError`, `OSError` where it cannot be read, and `FileError` where it is broken or of no
        known kind; the message names the item, its value and the limit.
        """
        scene = cls()
        scene._open(path, up=up, two_sided=two_sided)
        return scene

    @classmethod
    def builtin(cls, spec: str = "city") -> Scene:
        """A scene made by rule, such as ``"city"`` or ``"forest:n=600"``; `pycullet.BUILTIN_SCENES` has the names."""
        scene = cls()
        scene._build(spec)
        return scene

    @classmethod
    def from_arrays(
        cls,
        vertices: npt.NDArray[np.floating[Any]],
        faces: npt.NDArray[np.integer[Any]],
        transforms: npt.NDArray[np.floating[Any]] | None = None,
        *,
        two_sided: bool | None = None,
    ) -> Scene:
        """One mesh, and an instance of it for each transform.

        ``vertices`` is (n, 3) of float32 or float64, ``faces`` (m, 3) of integers, ``transforms`` (k, 4, 4); without
        it there is one instance, where the vertices are. Triangles are counter-clockwise from their front. Without
        ``two_sided``, a closed mesh that is wound outward shows its outside alone, and any other both sides.

        Raises `TypeError` for a wrong dtype, `ValueError` for a wrong shape, a number that is not finite, or an index
        beyond the vertices.
        """
        scene = cls()
        scene.add(vertices, faces, transforms, two_sided=two_sided)
        scene.commit()
        return scene

    @classmethod
    def from_trimesh(cls, source: trimesh.Trimesh | trimesh.Scene, *, two_sided: bool | None = None) -> Scene:
        """A `trimesh.Trimesh`, or a `trimesh.Scene` with its instances in the order of its nodes.

        Without ``two_sided``, a mesh has the sides that ``doubleSided`` of its material says; where the material says
        nothing, or there is none, the rule of `from_arrays` holds.
        Geometry without triangles, as paths and points are, is left out. Raises `TypeError` for anything else.
        """
        import trimesh

        scene = cls()
        if isinstance(source, trimesh.Trimesh):
            scene._add_named(*scene._add_trimesh("mesh", source, two_sided), "mesh")
        elif isinstance(source, trimesh.Scene):
            numbers: dict[str, tuple[int, npt.NDArray[np.float64]]] = {}
            for node in source.graph.nodes_geometry:
                transform, name = source.graph[node]
                mesh = source.geometry[name]
                if not isinstance(mesh, trimesh.Trimesh):
                    continue
                if name not in numbers:
                    numbers[name] = scene._add_trimesh(name, mesh, two_sided)
                number, back = numbers[name]
                scene._add_named(number, np.asarray(transform, np.float64) @ back, str(node))
        else:
            raise TypeError(f"source must be a trimesh.Trimesh or trimesh.Scene, not {type(source).__name__}")
        scene.commit()
        return scene

    @classmethod
    def from_pyvista(cls, source: Any, *, two_sided: bool | None = None) -> Scene:
        """A `pyvista.PolyData` or other data set, whose surface is taken, a `pyvista.MultiBlock`, an instance for each
        of its blocks, or a `pyvista.Plotter`, an instance for each mesh that it shows.

        Raises `TypeError` for anything else.
        """
        import pyvista

        scene = cls()
        if isinstance(source, pyvista.Plotter):
            for name, actor in source.actors.items():
                mesh = getattr(getattr(actor, "mapper", None), "dataset", None)
                if isinstance(mesh, pyvista.DataSet) and actor.GetVisibility():
                    place = np.array(actor.GetMatrix().GetData()).reshape(4, 4)
                    scene._add_pyvista(name, mesh, place, two_sided)
        elif isinstance(source, pyvista.MultiBlock):
            flat = source.combine_blocks if hasattr(source, "combine_blocks") else source.flatten
            for number, block in enumerate(flat()):
                if block is not None:
                    scene._add_pyvista(f"block {number}", block, np.eye(4), two_sided)
        elif isinstance(source, pyvista.DataSet):
            scene._add_pyvista("mesh", source, np.eye(4), two_sided)
        else:
            raise TypeError(
                f"source must be a pyvista data set, MultiBlock or Plotter, not {type(source).__name__}"
            )
        scene.commit()
        return scene

    def add(
        self,
        vertices: npt.NDArray[np.floating[Any]],
        faces: npt.NDArray[np.integer[Any]],
        transforms: npt.NDArray[np.floating[Any]] | None = None,
        *,
        two_sided: bool | None = None,
        color: Sequence[float] | None = None,
        name: str | None = None,
        opaque: bool = True,
        layers: int = 1,
    ) -> npt.NDArray[np.uint32]:
        """Adds a mesh and instances of it, as `from_arrays` does; returns their ids.

        ``color`` is linear red, green, blue and alpha, for pictures; what is not ``opaque`` hides nothing. Call
        `commit` once after the last.
        """
        rgba = None if color is None else [float(v) for v in color]
        mesh, back = self._add_moved(vertices, faces, two_sided, rgba, name, opaque)
        # Only what was moved is multiplied: the transforms of the others stay as they are, wrong ones too.
        if not np.array_equal(back, np.eye(4)):
            transforms = back if transforms is None else np.asarray(transforms) @ back
        return self.add_instances(mesh, transforms, layers=layers)

    def _add_moved(
        self,
        vertices: npt.NDArray[np.floating[Any]],
        faces: npt.NDArray[np.integer[Any]],
        two_sided: bool | None,
        color: list[float] | None,
        name: str | None,
        opaque: bool,
    ) -> tuple[int, npt.NDArray[np.float64]]:
        """Adds a mesh, near its own origin; returns its number, and the transform back to where it was."""
        mesh, moved = self._add_mesh(vertices, faces, two_sided=two_sided, color=color, name=name, opaque=opaque)
        back = np.eye(4)
        back[:3, 3] = moved
        return mesh, back

    def _add_named(self, mesh: int, transform: npt.NDArray[np.float64], name: str) -> None:
        for id in self.add_instances(mesh, transform):
            self._set_name(int(id), name)

    def _add_trimesh(
        self, name: str, mesh: trimesh.Trimesh, two_sided: bool | None
    ) -> tuple[int, npt.NDArray[np.float64]]:
        color, opaque = _trimesh_color(mesh)
        if two_sided is None:
            said = getattr(getattr(mesh.visual, "material", None), "doubleSided", None)
            two_sided = said if isinstance(said, bool) else None
        self._note(name, mesh, hash(mesh))
        vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
        return self._add_moved(vertices, faces, two_sided, color, name, opaque)

    def _add_pyvista(
        self, name: str, mesh: Any, place: npt.NDArray[np.float64], two_sided: bool | None
    ) -> None:
        surface = mesh.extract_surface(algorithm="dataset_surface").triangulate()
        if surface.n_cells == 0:
            return
        vertices = np.asarray(surface.points)
        if vertices.dtype not in (np.float32, np.float64):
            vertices = vertices.astype(np.float64)
        faces = np.asarray(surface.regular_faces)
        mesh_number, back = self._add_moved(vertices, faces, two_sided, None, name, True)
        self._add_named(mesh_number, place @ back, name)
        self._note(name, mesh, mesh.GetMTime())

    def _note(self, name: str, source: Any, state: int) -> None:
        if not hasattr(self, "_sources"):
            self._sources = []
        self._sources.append((name, source, state))

    def changed_sources(self) -> list[str]:
        """Names of the trimesh and pyvista meshes that have changed since they were copied into this scene.

        The scene answers for what they were. Costs a hash of the arrays for trimesh, next to nothing for pyvista.
        """
        changed = []
        for name, source, state in getattr(self, "_sources", []):
            now = source.GetMTime() if hasattr(source, "GetMTime") else hash(source)
            if now != state:
                changed.append(name)
        return changed

    def explain(self, camera: _native.Camera, id: int, culler: Settings = "balanced") -> Explanation:
        """Why an instance is drawn or not: every stage it came to, with its numbers. Print it.

        Raises `IndexError` where there is no such instance. Costs about one cull.
        """
        return explanation(self, id, self._explain(camera, id, culler))

    def verify(
        self,
        camera: _native.Camera | _native.Cameras,
        culler: Settings = "balanced",
        *,
        samples: int = 4,
        seed: int = 0,
        threads: int = 0,
    ) -> Verification:
        """Draws each view with and without culling and compares them pixel for pixel; true where nothing was lost.

        Whole instances are also looked for at ``samples`` × ``samples`` places a pixel. Costs two pictures or more.
        """
        return Verification(*self._verify(camera, culler, samples=samples, seed=seed, threads=threads))

    def render(self, camera: _native.Camera, culler: Settings | None = None) -> Image:
        """A reference picture: colour, depth, ids and triangles, of all instances or of what a culler leaves.

        Drawn on the CPU in float64, one sample a pixel; the same on every machine. Blended parts are not drawn.
        """
        return Image(*self._render(camera, culler))

    def cut(
        self,
        planes: npt.ArrayLike,
        *,
        cap: bool = True,
        keep: Literal["inside", "outside"] = "inside",
    ) -> trimesh.Trimesh:
        """The scene cut open at planes, as one `trimesh.Trimesh` in world space.

        A plane is (x, y, z, d): n·x ≤ d is inside. Of several, (n, 4) with up to 32, inside is what is inside of all.
        Where a closed mesh is cut, ``cap`` closes it again. ``mesh.face_attributes`` has the ``id`` of the instance of
        each face, and whether it is a ``cap``.
        """
        import trimesh

        vertices, faces, ids, caps = self._cut(planes, cap=cap, keep=keep)
        attributes = {"id": ids, "cap": caps}
        return trimesh.Trimesh(vertices, faces, face_attributes=attributes, process=False)

    def occluders(self, *, apply: bool = True) -> list[Occluder]:
        """Bakes an occluder for each mesh: boxes inside it and polygons in its surface.

        With ``apply`` the scene hides by them from now on, in place of the meshes themselves: cheaper where meshes are
        fine, and less exact where they are not a good fit, as `Occluder.efficiency` says. Costs seconds for meshes of
        a million triangles.
        """
        made = self._occluders(apply=apply)
        return [Occluder(at, boxes, tuple(polygons), triangles, share) for at, (boxes, polygons, triangles, share) in enumerate(made)]

    def report(
        self,
        camera: _native.Camera | _native.Cameras | None = None,
        culler: Settings = "balanced",
        *,
        samples: int = 1,
        threads: int = 0,
    ) -> Report:
        """What is drawn for nothing, which stage finds it, and the proof that nothing visible was lost.

        ``camera`` is one or many; without it, eight around the scene. Raises `ValueError` where there is none.
        """
        if camera is None:
            camera = _native.Cameras.along(self, "orbit", 8, size=(640, 400))
        cameras = _native.Cameras._of(camera)
        if len(cameras) == 0:
            raise ValueError("there are no cameras to report on")
        return report(self, cameras, culler, samples, threads)

    def __repr__(self) -> str:
        name = f" {self.title}" if self.title else ""
        return (
            f"<pycullet.Scene{name}: {self.instance_count} instances of {self.mesh_count} meshes, "
            f"{self.triangle_count} triangles>"
        )


def _trimesh_color(mesh: Any) -> tuple[list[float] | None, bool]:
    """Linear main colour, and whether it hides what is behind it."""
    try:
        rgba = np.asarray(mesh.visual.main_color, np.float64)[:4] / 255
    except (AttributeError, ValueError, IndexError):
        material = getattr(getattr(mesh, "visual", None), "material", None)
        main = getattr(material, "main_color", None)
        if main is None:
            return None, True
        rgba = np.asarray(main, np.float64)[:4] / 255
    if rgba.shape != (4,) or not np.isfinite(rgba).all():
        return None, True
    material = getattr(mesh.visual, "material", None)
    mode = getattr(material, "alphaMode", None)
    opaque = mode not in ("BLEND", "MASK") if material is not None else bool(rgba[3] >= 1)
    return [*(rgba[:3] ** 2.2).tolist(), float(rgba[3])], opaque
