"""What tests share: a wall with one box before it and one behind, and the built-in city."""

from __future__ import annotations

import os
import pathlib

import numpy as np
import pytest

import pycullet

QUAD = (
    np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32),
    np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
)


def place(x: float, y: float, z: float, scale: float = 1.0) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    matrix = np.diag([scale, scale, scale, 1.0])
    matrix[:3, 3] = x, y, z
    return matrix


@pytest.fixture
def wall() -> pycullet.Scene:
    """Ids: 0 the wall, 1 before it, 2 behind it, 3 beside the picture."""
    scene = pycullet.Scene()
    scene.add(*QUAD, place(0, 0, -5, 50), name="wall")
    scene.add(*QUAD, np.stack([place(0, 0, -4), place(0, 0, -9), place(500, 0, -4)]), name="plate")
    scene.commit()
    return scene


@pytest.fixture
def ahead() -> pycullet.Camera:
    return pycullet.Camera.look_at((0, 0, 0), (0, 0, -1), size=(320, 200))


@pytest.fixture(scope="session")
def city() -> pycullet.Scene:
    return pycullet.Scene.builtin("city:cells=8,objects=300")


@pytest.fixture
def data(request: pytest.FixtureRequest) -> pathlib.Path:
    """A folder that a variable names; without it the test is skipped, or fails where data are required."""
    name: str = request.param
    folder = os.environ.get(name)
    if not folder:
        message = f"{name} names no folder"
        if os.environ.get("CULLET_REQUIRE_DATA") == "1":
            pytest.fail(message)
        pytest.skip(message)
    return pathlib.Path(folder)
