"""Structured arrays of the native half, and what pickling calls."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native

_COUNTS = ["instances_in", "clusters_in", "triangles_in", "instances_out", "clusters_out", "triangles_out"]
_ROW: dict[str, tuple[str, int]] = {
    "stage": ("U10", 48),
    "unit": ("U10", 88),
    **{name: ("u8", 8 * at) for at, name in enumerate(_COUNTS)},
}


def _of(fields: dict[str, tuple[str, int]], size: int) -> np.dtype[Any]:
    return np.dtype(
        {
            "names": list(fields),
            "formats": [kind for kind, _ in fields.values()],
            "offsets": [offset for _, offset in fields.values()],
            "itemsize": size,
        }
    )


FUNNEL = _of(_ROW, 136)
FUNNELS = _of({"camera": ("u4", 128), **_ROW}, 136)
PARTIAL = np.dtype([("id", "u4"), ("level", "u4"), ("first_cluster", "u4"), ("cluster_count", "u4")])
TRIANGLES = np.dtype([("id", "u4"), ("triangle", "u4")])
LEVELS = np.dtype([("mesh", "u4"), ("level", "u4"), ("triangles", "u4"), ("error", "f4")])
REASONS = np.dtype([("stage", "u1"), ("detail", "u1")])
FIGURES = np.dtype([("all", "u8"), ("kept", "u8"), ("visible", "u8"), *((s, "u8") for s in _native.STAGES)])
FALSE_CULLS = np.dtype(
    [("camera", "u4"), ("id", "u4"), ("triangle", "i4"), ("x", "u4"), ("y", "u4"), ("stage", "u4")]
)


def rebuild_camera(
    matrix: npt.NDArray[np.float64], size: tuple[int, int], depth: Any, layers: int
) -> _native.Camera:
    """A camera of its matrix: what pickling calls."""
    return _native.Camera.from_matrix(matrix, size=size, depth=depth, layers=layers)
