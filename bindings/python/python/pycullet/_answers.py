"""Answers that are more than an array."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _html, _native


@dataclass(frozen=True)
class Step:
    """What one stage found of an instance."""

    stage: str
    """Its name, one of `pycullet.STAGES`."""
    unit: str
    """What it tested: ``instances``, ``clusters`` or ``triangles``."""
    entered: int
    """How many came in."""
    left: int
    """How many went on."""
    finding: str
    """Its measurements, in words with numbers."""


@dataclass(frozen=True)
class Explanation:
    """Why an instance is drawn or not. Printing it shows every stage that it came to."""

    id: int
    name: str
    reason: str | None
    """The stage that dropped it; None where something of it is drawn."""
    steps: tuple[Step, ...]
    hidden_by: tuple[int, ...]
    """Where it is hidden: the ids of what hides it, the nearest first."""

    @property
    def is_visible(self) -> bool:
        """Whether something of it is drawn."""
        return self.reason is None

    def __str__(self) -> str:
        end = "is drawn" if self.is_visible else f"is culled by the {self.reason} stage"
        lines = [f"{self.name} (id {self.id}) {end}"]
        for s in self.steps:
            lines.append(f"  {s.stage:<10} {s.left} of {s.entered} {s.unit} left: {s.finding}")
        if self.hidden_by:
            lines.append("  hidden by " + ", ".join(map(str, self.hidden_by)))
        return "\n".join(lines)


@dataclass(frozen=True)
class Image:
    """A picture by the reference renderer, which culls nothing but what it is told to."""

    color: npt.NDArray[np.uint8]
    """(height, width, 3), sRGB, row by row from the top."""
    depth: npt.NDArray[np.float64]
    """(height, width): distance along the direction of sight, from the eye (of an orthographic camera, from its near
    plane); infinite where there is nothing."""
    ids: npt.NDArray[np.int32]
    """(height, width): the instance that owns the pixel, −1 where there is none."""
    triangles: npt.NDArray[np.int32]
    """(height, width): which triangle of its mesh, in the order that the mesh came with, −1 where there is none."""

    @property
    def visible(self) -> npt.NDArray[np.uint32]:
        """The ids that own a pixel, ascending: the truth that culling is held against."""
        return np.unique(self.ids[self.ids >= 0]).astype(np.uint32)

    def save(self, path: str) -> None:
        """Writes the colours as a PNG file."""
        with open(path, "wb") as file:
            file.write(_html.png(self.color))

    def _repr_png_(self) -> bytes:
        return _html.png(self.color)


@dataclass(frozen=True)
class Occluder:
    """Shapes within a mesh that hide what the mesh hides, in the space of the mesh."""

    mesh: int
    boxes: npt.NDArray[np.float32]
    """(n, 2, 3): low and high corners of boxes that are proved to lie within what the mesh seals off."""
    polygons: tuple[npt.NDArray[np.float32], ...]
    """(k, 3) each: corners of convex polygons in its surface."""
    triangles: npt.NDArray[np.float32]
    """(n, 3, 3): triangles of the mesh that stand for themselves."""
    efficiency: float
    """The share of the mesh's silhouette that they hide: 1 is all of it."""


@dataclass(frozen=True)
class Verification:
    """The proof that culling lost nothing: true where it did not."""

    figures: npt.NDArray[Any]
    """A row for each camera: triangles of ``all`` instances, ``kept`` by culling, truly ``visible``, and by the name of
    each stage those that it took."""
    false_culls: npt.NDArray[Any]
    """What is visible and was dropped, which is nothing unless the engine has a fault or a lossy stage is on:
    ``camera``, ``id``, ``triangle`` (−1 for an instance that is seen between pixels alone), pixel ``x`` and ``y``, and
    the number of the stage in `pycullet.STAGES`, from 1."""

    @property
    def ok(self) -> bool:
        """Whether nothing visible was lost."""
        return len(self.false_culls) == 0

    def __bool__(self) -> bool:
        return self.ok

    @property
    def all(self) -> int:
        """Triangles of all instances, over all cameras."""
        return int(self.figures["all"].sum())

    @property
    def kept(self) -> int:
        """Triangles that culling kept, over all cameras."""
        return int(self.figures["kept"].sum())

    @property
    def visible(self) -> int:
        """Triangles that are truly visible, over all cameras."""
        return int(self.figures["visible"].sum())

    @property
    def tightness(self) -> float:
        """Triangles kept over triangles visible: 1 is perfect, and NaN where nothing is visible."""
        return self.kept / self.visible if self.visible else float("nan")

    def __repr__(self) -> str:
        end = "nothing visible was lost" if self.ok else f"{len(self.false_culls)} visible triangles were lost"
        return (
            f"<pycullet.Verification of {len(self.figures)} cameras: {end}; "
            f"{self.all} triangles, {self.kept} kept, {self.visible} visible, tightness {self.tightness:.2f}>"
        )


def explanation(
    scene: _native.Scene, id: int, found: tuple[str | None, list[Any], list[int]]
) -> Explanation:
    reason, steps, hidden_by = found
    return Explanation(id, scene.name(id), reason, tuple(Step(*s) for s in steps), tuple(hidden_by))
