"""Culling for `pyvista.Plotter`: what cannot be seen is not drawn, and the picture stays the same.

>>> import pycullet.pyvista                              # doctest: +SKIP
>>> hook = pycullet.pyvista.attach(plotter)              # doctest: +SKIP
>>> plotter.show()                                       # doctest: +SKIP

Before each render of a renderer, actors that the camera cannot see are hidden, and shown again after it. Volumes, text,
2D actors, and actors that are drawn in a way that is not known are left alone.
"""

from __future__ import annotations

import warnings
import weakref
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _native, _vtk
from ._scene import Scene, Settings

__all__ = ["Hook", "Render", "attach", "detach"]

# Data that change more often hide nothing from then on: they would be copied in every render.
_CHANGES = 3
# A cube from -1 to 1, which stands for the bounds of what hides nothing.
_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32)
_SIDES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)


@dataclass(frozen=True)
class Render:
    """What the last render of a renderer did with its actors."""

    shown: int
    """Actors that are visible by the user's own setting, and can be culled; of a composite actor its blocks."""
    culled: int
    """How many of them were not drawn."""
    left_alone: int
    """Props that were not tested."""


class _Renderer:
    """What is known of one renderer."""

    def __init__(self, culler: Settings) -> None:
        self.culler = culler
        self.last = Render(0, 0, 0)
        self.props_state: tuple[int, ...] = ()
        self.others = 0
        self.tracked: list[_vtk.Tracked] = []
        # When anything of them changed: the calls that say it, and what they said after the last render.
        self.calls: list[Any] = []
        self.times: list[int] = []
        # With each the blocks that are hidden, of an actor that is not hidden as a whole, and its time meanwhile.
        self.hidden: list[tuple[_vtk.Tracked, list[Any], int]] = []
        self.clear()

    def clear(self) -> None:
        """Forgets the scene, so that all actors are read again."""
        self.scene, self.times = Scene(), []
        self.cube = self.scene._add_moved(_CORNERS, _SIDES, True, None, None, False)[0]
        # Of data that actors share, the mesh and where it was moved from.
        self.meshes: dict[tuple[Any, ...], tuple[int, _vtk.Matrix]] = {}
        self.is_new = False
        for item in self.tracked:
            item.time, item.parts = -1, []

    def start(self, renderer: Any) -> None:
        """Hides what is not seen. Whatever is in doubt is shown."""
        self.end()
        self.last = Render(0, 0, 0)
        view = _view(renderer)
        if view is None:
            return
        self._track(renderer.GetViewProps())
        # All at once first: in most renders nothing, or little, has changed.
        if not self.times or [call() for call in self.calls] != self.times:
            self._read()
        seen = self.scene.cull(view, self.culler).mask().tolist()
        shown = culled = 0
        for item in self.tracked:
            parts = item.parts
            if not item.is_shown or not parts:
                continue
            shown += len(parts)
            unseen = [part.data for part in parts if not seen[part.id]]
            if not unseen:
                continue
            if len(unseen) == len(parts):
                item.actor.SetVisibility(False)
                self.hidden.append((item, [], item.actor.GetMTime()))
            elif item.looks is not None:
                for data in unseen:
                    item.looks.SetBlockVisibility(data, False)
                item.note()
                self.hidden.append((item, unseen, item.time))
            else:
                continue
            culled += len(unseen)
        alone = self.others + sum(item.is_shown and not item.parts for item in self.tracked)
        self.last = Render(shown, culled, alone)

    def end(self) -> None:
        """Shows again what was hidden."""
        hidden, self.hidden = self.hidden, []
        for item, blocks, time in hidden:
            # What changed while it was hidden is read in the next render.
            if blocks:
                is_same = not item.has_changed()
                for data in blocks:
                    item.looks.RemoveBlockVisibility(data)
                item.note()
            else:
                is_same = item.actor.GetMTime() == time
                item.actor.SetVisibility(True)
                item.time = item.actor.GetMTime()
            if not is_same:
                item.time = -1
            if self.times:
                own = item.times()
                self.times[item.at : item.at + len(own)] = own

    def _read(self) -> None:
        """Reads the actors that have changed."""
        for item in self.tracked:
            if item.has_changed():
                self._update(item)
        if len(self.meshes) > 64 + 2 * len(self.scene):
            # Most meshes are of data that have changed since.
            self.clear()
            for item in self.tracked:
                self._update(item)
        if self.is_new:
            # Only what was prepared hides what is behind it.
            self.scene.commit()
            self.is_new = False
        self.calls, self.times = [], []
        for item in self.tracked:
            item.at = len(self.calls)
            self.calls += item.calls()
            self.times += item.times()

    def _track(self, props: Any) -> None:
        """Takes up actors that were added, and gives up those that were removed."""
        state = (props.GetMTime(), props.GetNumberOfItems())
        if state == self.props_state:
            return
        # By identity: data and actors of pyvista compare what is in them.
        known = {id(item.actor): item for item in self.tracked}
        self.tracked, self.others, self.times = [], 0, []
        for prop in props:
            item = known.pop(id(prop), None) or _vtk.tracked(prop)
            if item is None:
                self.others += 1
            else:
                self.tracked.append(item)
        for item in known.values():
            self._drop(item)
        self.props_state = state

    def _update(self, item: _vtk.Tracked) -> None:
        """Reads an actor that has changed."""
        was_shown, item.is_shown = item.is_shown, bool(item.actor.GetVisibility())
        if not item.is_shown and not item.parts:
            # Its data are read once it is shown.
            item.note()
            return
        try:
            if not self._place(item, was_shown):
                self._drop(item)
        except (TypeError, ValueError):
            # Numbers that the engine refuses: VTK may draw something of them.
            self._drop(item)
        item.note()

    def _place(self, item: _vtk.Tracked, was_shown: bool) -> bool:
        """Puts an actor into the scene as it is now; false where it is to be left alone."""
        matrix, data = _vtk.matrix_of(item.actor), item.read(item.changes < _CHANGES)
        if matrix is None or data is None:
            return False
        if [id(part.data) for part in item.parts] != [id(own) for own in data]:
            item.changes += bool(item.parts)
            self._drop(item)
            item.parts = [_vtk.Part(own) for own in data]
        is_moved = item.matrix is None or not np.array_equal(matrix, item.matrix)
        item.matrix = matrix
        moved, changed = [], False
        for part in item.parts:
            state = item.state_of(part.data)
            if part.id >= 0 and part.state == state:
                if is_moved:
                    moved.append(part)
                continue
            shape = _vtk.shape_of(part.data, item.hides)
            if shape is None:
                return False
            changed = changed or part.state[1:] not in ((), state[1:])
            self._remove(part)
            mesh, part.local = self._mesh(state, shape)
            layers = int(item.is_shown)
            (number,) = self.scene.add_instances(mesh, matrix @ part.local, layers=layers)
            part.id, part.state = int(number), state
            self.is_new = True
        item.changes += changed
        ids = [part.id for part in item.parts]
        if moved:
            self.scene.set_transforms([p.id for p in moved], np.stack([matrix @ p.local for p in moved]))
        if ids and item.is_shown != was_shown:
            self.scene.set_layers(ids, int(item.is_shown))
        return True

    def _mesh(self, state: tuple[Any, ...], shape: _vtk.Shape) -> tuple[int, _vtk.Matrix]:
        if shape.vertices is None or shape.faces is None:
            low, high = shape.bounds
            half = (high - low) / 2
            # What is flat has no volume, and rounding is to be within.
            size = half + 1e-6 * max(float(half.max()), float(np.abs(shape.bounds).max()), 1e-30)
            local = np.diag([*size, 1.0])
            local[:3, 3] = (low + high) / 2
            return self.cube, local
        found = self.meshes.get(state)
        if found is None:
            found = self.scene._add_moved(shape.vertices, shape.faces, True, None, None, True)
            self.meshes[state] = found
        return found

    def _remove(self, part: _vtk.Part) -> None:
        if part.id >= 0:
            self.scene.remove([part.id])
        part.id = -1

    def _drop(self, item: _vtk.Tracked) -> None:
        for part in item.parts:
            self._remove(part)
        item.parts, item.matrix = [], None


class Hook:
    """Culling of a plotter's renderers, as `attach` made it. It ends with `detach`, and with the plotter."""

    def __init__(self, renderers: list[Any], window: Any, culler: Settings) -> None:
        self._culled = [_Renderer(culler) for _ in renderers]
        self._observers: list[tuple[weakref.ref[Any], int]] = []
        self._failed = self._ended = False
        # Within what observers of the user's do, whatever they change.
        for renderer, own in zip(renderers, self._culled):
            self._observe(renderer, "StartEvent", lambda caller, _, own=own: self._start(own, caller), -1)
            self._observe(renderer, "EndEvent", lambda *_, own=own: own.end(), 1)
        if window is not None:
            # A render that is aborted may not end.
            self._observe(window, "EndEvent", lambda *_: self._restore())

    @property
    def renders(self) -> tuple[Render, ...]:
        """What the last render of each renderer did."""
        return tuple(own.last for own in self._culled)

    def detach(self) -> None:
        """Ends culling. Everything is drawn again; calling it again has no effect."""
        self._restore()
        # An observer stays where its source is known to VTK alone.
        self._ended = True
        for source, tag in self._observers:
            if (observed := source()) is not None:
                observed.RemoveObserver(tag)
        self._observers = []

    def __enter__(self) -> Hook:
        return self

    def __exit__(self, *_: object) -> None:
        self.detach()

    def _observe(self, source: Any, event: str, call: Any, priority: float = 0) -> None:
        self._observers.append((weakref.ref(source), source.AddObserver(event, call, priority)))

    def _restore(self) -> None:
        for own in self._culled:
            own.end()

    def _start(self, own: _Renderer, renderer: Any) -> None:
        if self._ended:
            return
        try:
            own.start(renderer)
        except Exception as fault:  # An error within a render would be lost: all is drawn, and the next one tries again.
            own.end()
            own.clear()
            own.last = Render(0, 0, 0)
            if not self._failed:
                self._failed = True
                warnings.warn(f"pycullet.pyvista culls nothing: {fault!r}", RuntimeWarning, stacklevel=1)


_hooks: weakref.WeakKeyDictionary[Any, Hook] = weakref.WeakKeyDictionary()


def attach(plotter: Any, culler: Settings = "exact") -> Hook:
    """Culls what a plotter draws, from now on: a `pyvista.Plotter`, or a `vtkRenderWindow` or `vtkRenderer` of VTK.

    Actors that the camera cannot see are hidden while a renderer draws, and shown again after it; the picture is the
    same. Actors may be added, removed, moved and changed in any way between renders. Each opaque surface hides what is
    behind it. Culled but not hiding are translucent, textured and clipped actors, those with face culling or
    coincident-topology offsets, and data that change often. Left alone are volumes, text, 2D actors, assemblies,
    followers, actors with shaders, edges, lines or points, and mappers that are not known. A renderer with a render
    pass, shadows, ambient occlusion or stereo is left alone altogether.

    The default finds as much as can be proved, since an actor costs VTK far more to draw than to test; a ``min_pixels``
    of the culler may change the picture.

    Data are copied when they are first seen and when they change. Every render asks each actor whether it has changed,
    some microseconds each. Hiding and showing an actor raises its modification time and calls its observers.

    Attaching again replaces the earlier hook. Raises `TypeError` for anything else than a plotter.
    """
    renderers, window = _parts(plotter)
    detach(plotter)
    hook = Hook(renderers, window, culler)
    _hooks[plotter] = hook
    return hook


def detach(plotter: Any) -> None:
    """Ends culling of a plotter; without effect where there is none."""
    hook = _hooks.pop(plotter, None)
    if hook is not None:
        hook.detach()


def _parts(plotter: Any) -> tuple[list[Any], Any]:
    """The renderers and the window of a plotter."""
    if hasattr(plotter, "renderers") and hasattr(plotter, "render_window"):
        return list(plotter.renderers), plotter.render_window
    is_a = getattr(plotter, "IsA", lambda _: False)
    if is_a("vtkRenderWindow"):
        return list(plotter.GetRenderers()), plotter
    if is_a("vtkRenderer"):
        return [plotter], plotter.GetRenderWindow()
    raise TypeError(
        f"plotter must be a pyvista.Plotter, a vtkRenderWindow or a vtkRenderer, not {type(plotter).__name__}"
    )


def _view(renderer: Any) -> _native.Camera | None:
    """Returns what a renderer sees; nothing where it draws in more ways than through one camera."""
    window, (width, height) = renderer.GetRenderWindow(), renderer.GetSize()
    special = ("GetUseShadows", "GetUseSSAO", "GetUseHiddenLineRemoval", "GetSelector")
    if (
        window is None
        or window.GetStereoRender()
        or renderer.GetPass() is not None
        or any(getattr(renderer, name, bool)() for name in special)
        or not renderer.IsActiveCameraCreated()
        or width < 1
        or height < 1
    ):
        return None
    camera = renderer.GetActiveCamera()
    sight = camera.GetModelViewTransformMatrix()
    lens = camera.GetProjectionTransformMatrix(renderer.GetTiledAspectRatio(), -1, 1)
    matrix = _array(lens) @ _array(sight)
    # Depth of OpenGL goes from -1 to 1.
    matrix[2] = (matrix[2] + matrix[3]) / 2
    try:
        return _native.Camera.from_matrix(matrix, size=(width, height))
    except ValueError:
        return None


def _array(matrix: Any) -> _vtk.Matrix:
    return np.array(matrix.GetData()).reshape(4, 4)
