"""What is to be done."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from .. import _native


@dataclass(frozen=True)
class Plan:
    """A bake that is to be done, as a text that any machine understands, and the scene on this one."""

    text: str
    """JSON on one line."""
    scene: str
    """A file here, or the name of a built-in scene."""

    @property
    def key(self) -> int:
        """What its units are named by."""
        return int(json.loads(self.text)["key"])

    @property
    def content(self) -> int | None:
        """Hash of the file's content; None for a built-in scene."""
        content = json.loads(self.text)["content"]
        return None if content is None else int(content)


def plan(
    scene: str | os.PathLike[str],
    *,
    seed: int = 1,
    fast: bool = False,
    tolerance: float = 1e-6,
    view_cells: int | None = None,
    regions: Sequence[tuple[Sequence[float], Sequence[float]]] = (),
    heights: tuple[float, float] | None = None,
    grid: tuple[int, int, int] | None = None,
    clusters: bool = False,
    rays: int | None = None,
    missing: float | None = None,
    keep_angle: float | None = None,
    join: float | None = None,
) -> Plan:
    """Plans the potentially visible sets of a file, or of a built-in scene.

    A portal graph (.prt), a map (.bsp) and a scene with cells of its own get sets of those cells; any other scene, and where
    ``view_cells``, ``grid``, ``regions`` or ``heights`` are given, sets of view cells. The settings are those of ``cullet pvs``.
    Loads the scene once. Raises `FileNotFoundError`, `pycullet.FileError` and `ValueError`, as `pycullet.Scene.load`.
    """
    settings = {
        "seed": seed,
        "fast": fast,
        "tolerance": tolerance,
        "scene": {
            "view_cells": view_cells,
            "regions": [[list(low), list(high)] for low, high in regions],
            "heights": heights,
            "grid": grid,
            "clusters": clusters,
            "rays": rays,
            "missing": missing,
            "keep_angle": keep_angle,
            "join": join,
        },
    }
    name = os.fspath(scene)
    # Workers stand in folders of their own.
    place = str(Path(name).resolve()) if os.path.exists(name) else name
    return Plan(_native.plan_text(place, json.dumps(settings)), place)
