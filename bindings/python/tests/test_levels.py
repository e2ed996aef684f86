"""Levels of detail: baked, chosen and told."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import QUAD, place

import pycullet

trimesh = pytest.importorskip("trimesh")


@pytest.fixture(scope="module")
def balls() -> pycullet.Scene:
    """Id 0 is near, 1 farther, 2 far, of one mesh; 3 is a plate that cannot be simplified."""
    ball = trimesh.creation.icosphere(subdivisions=4)
    scene = pycullet.Scene.from_arrays(
        ball.vertices, ball.faces, np.stack([place(-1.5, 0, -3), place(0, 0, -40), place(30, 0, -400)])
    )
    scene.add(*QUAD, place(0, 3, -9))
    scene.commit()
    return scene


def test_levels_have_fewer_triangles_and_greater_errors_which_hold(balls: pycullet.Scene) -> None:
    rows = balls.bake_levels()
    ball = rows[rows["mesh"] == 0]
    assert len(ball) > 4 and ball["level"].tolist() == list(range(len(ball)))
    assert ball["triangles"][0] == 5120 and (np.diff(ball["triangles"].astype(int)) < 0).all()
    assert ball["error"][0] == 0 and (np.diff(ball["error"]) >= 0).all() and ball["error"][-3] > 0
    vertices, faces, level = balls.level_mesh(0)
    assert np.bincount(level).tolist() == ball["triangles"].tolist()
    # Middles of triangles lie within the error below the sphere: their vertices are on it.
    for row in ball[1:-2]:
        middles = vertices[faces[level == row["level"]]].mean(1)
        assert (1 - np.linalg.norm(middles, axis=1)).max() <= row["error"] * 1.1 + 0.002
    again = balls.bake_levels(threads=1)
    assert np.array_equal(again, rows)
    with pytest.raises(IndexError, match="mesh 0 has no levels 2; it has 1"):
        balls.level_mesh(0, 2)
    for number in (0, -1, 10**50):
        with pytest.raises(IndexError, match="has no levels"):
            balls.level_mesh(0, number)


def test_the_coarsest_level_within_the_pixels_is_drawn(balls: pycullet.Scene) -> None:
    rows = balls.bake_levels()
    ball = rows[rows["mesh"] == 0]
    camera = pycullet.Camera.look_at((0, 0, 0), (0, 0, -1), size=(640, 400))
    full = balls.cull(camera)
    assert full.levels.tolist() == [0] * len(full) and full.visible.tolist() == [0, 1, 2, 3]
    result = balls.cull(camera, pycullet.Culler(without=["backface", "frustum", "occlusion"], output="triangles"), lod=1)
    assert result.levels.dtype == np.uint32 and result.visible.tolist() == [0, 1, 2, 3]
    near, middle, far, plate = result.levels.tolist()
    assert near < middle < far and plate == 0 and result.triangle_count < full.triangle_count
    pixels = 200 / np.tan(np.radians(30))
    for level, distance in ((near, np.hypot(1.5, 3)), (middle, 40.0), (far, np.hypot(30, 400))):
        # Errors count from the nearest point of the ball.
        allowed = (distance - 1) / pixels
        assert ball["error"][level] <= allowed * 1.01
        assert level + 1 == len(ball) or ball["error"][level + 1] > allowed * 0.8
    # Its triangles are those of the level.
    _, _, of_level = balls.level_mesh(0)
    for id, level in zip(result.visible, result.levels):
        own = result.triangles["triangle"][result.triangles["id"] == id]
        if level:
            assert set(of_level[own].tolist()) == {level} and len(own) == ball["triangles"][level]
    assert balls.cull(camera, lod=0).levels.tolist() == [0, 0, 0, 0]
    assert balls.cull(camera, lod=1e6).levels[0] == len(ball) - 1


def test_many_cameras_tell_levels_too(balls: pycullet.Scene) -> None:
    balls.bake_levels()
    cameras = pycullet.Cameras.look_at([[0, 0, 0], [0, 0, 60], [0, 0, 500]], (0, 0, -40), size=(320, 200))
    results = balls.cull(cameras, lod=2)
    assert len(results.levels) == len(results.ids)
    for at in range(3):
        own = results.levels[results.offsets[at] : results.offsets[at + 1]]
        assert np.array_equal(own, balls.cull(cameras[at], lod=2).levels)
    assert (balls.cull(cameras).levels == 0).all()


def test_wrong_pixels_are_refused(balls: pycullet.Scene) -> None:
    camera = pycullet.Camera.look_at((0, 0, 0), (0, 0, -1))
    for pixels in (-1, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="lod is .*; it must be a number of pixels from 0"):
            balls.cull(camera, lod=pixels)
    with pytest.raises(ValueError, match="threads"):
        balls.bake_levels(threads=-1)
