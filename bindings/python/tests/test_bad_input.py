"""A caller's mistakes are exceptions that say what to do, and leave nothing half done."""

from __future__ import annotations

import pathlib
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from conftest import QUAD, place

import pycullet

VERTICES, FACES = QUAD


@pytest.mark.parametrize(
    ("vertices", "faces", "error", "message"),
    [
        (VERTICES.astype(np.int32), FACES, TypeError, r"vertices must be of float32 or float64, not int32.*astype"),
        (VERTICES.astype(complex), FACES, TypeError, "not complex128"),
        (VERTICES.astype(">f8"), FACES, TypeError, ">f8"),
        (VERTICES.astype(object), FACES, TypeError, "not object"),
        ("vertices", FACES, TypeError, "NumPy array of float32 or float64, not str"),
        (None, FACES, TypeError, "not NoneType"),
        (VERTICES.T, FACES, ValueError, r"vertices has the shape \(3, 4\); it must be \(n, 3\)"),
        (VERTICES.ravel(), FACES, ValueError, r"shape \(12,\)"),
        (VERTICES, FACES.astype(np.float32), TypeError, "faces must be of integers, not float32"),
        (VERTICES, FACES.astype(bool), TypeError, "not bool; use numpy.flatnonzero"),
        (VERTICES, FACES[:, :2], ValueError, r"faces has the shape \(2, 2\)"),
        (VERTICES, FACES.astype(np.int64) - 1, ValueError, "faces has -1 at 0"),
        (VERTICES, FACES + 2, ValueError, "faces has 4 in row 0, column 2, but there are 4 vertices"),
        (VERTICES, FACES.astype(np.uint64) + 2**63, ValueError, "faces has 9223372036854775808 at 0"),
        (VERTICES, [[0, 1, 2**70]], ValueError, "faces has a number beyond int64"),
        (VERTICES * np.nan, FACES, ValueError, "vertices has NaN in row 0, column 0; all numbers must be finite"),
        (VERTICES + np.inf, FACES, ValueError, "vertices has inf"),
        ([[0, 0, 0], [1, 0]], FACES, TypeError, "rows of one length"),
    ],
)
def test_meshes_that_are_none_are_refused(vertices: Any, faces: Any, error: type[Exception], message: str) -> None:
    scene = pycullet.Scene()
    with pytest.raises(error, match=message):
        scene.add(vertices, faces)
    assert (scene.mesh_count, scene.instance_count) == (0, 0)


@pytest.mark.parametrize(
    ("transforms", "error", "message"),
    [
        (np.eye(3), ValueError, r"\(3, 3\); it must be \(4, 4\) or \(n, 4, 4\)"),
        (np.eye(4, dtype=int), TypeError, "not int64"),
        (place(1, 2, 3).T, ValueError, "last row of transform 0 .* transpose"),
        (place(np.nan, 0, 0), ValueError, "transform 0 has NaN"),
        (np.stack([place(0, 0, 0), place(np.inf, 0, 0)]), ValueError, "transform 1 has inf"),
    ],
)
def test_transforms_that_are_none_are_refused(transforms: Any, error: type[Exception], message: str) -> None:
    scene = pycullet.Scene()
    with pytest.raises(error, match=message):
        scene.add(VERTICES, FACES, transforms)
    assert scene.instance_count == 0
    scene.add(VERTICES, FACES)
    with pytest.raises(error, match=message):
        scene.set_transforms(np.zeros(len(transforms) if transforms.ndim == 3 else 1, int), transforms)


def test_whatever_lies_in_memory_as_it_likes_is_read(ahead: pycullet.Camera) -> None:
    far = VERTICES + np.array([0, 0, -5], np.float32)
    steps = np.repeat(far, 2, axis=0)[::2]
    fortran = np.asfortranarray(far)
    read_only = far.copy()
    read_only.flags.writeable = False
    packed = np.zeros(4, [("byte", "u1"), ("point", "f4", 3)])
    packed["point"] = far
    for vertices in (steps, fortran, read_only, packed["point"], far[::-1][::-1], far.tolist()):
        scene = pycullet.Scene.from_arrays(vertices, FACES[:, ::1].astype(np.int16))
        assert scene.cull(ahead).visible.tolist() == [0]
        assert np.array_equal(scene.mesh(0)[0], far) and np.array_equal(scene.mesh(0)[1], FACES)


def test_masks_go_into_arrays_that_can_be_written(wall: pycullet.Scene, ahead: pycullet.Camera) -> None:
    result = wall.cull(ahead, "exact")
    out = np.ones(4, bool)
    assert result.mask(out) is out and out.tolist() == [True, True, False, False]
    read_only = np.ones(4, bool)
    read_only.flags.writeable = False
    with pytest.raises(ValueError, match="out is read-only"):
        result.mask(read_only)
    with pytest.raises(ValueError, match="not contiguous"):
        result.mask(np.ones(8, bool)[::2])
    with pytest.raises(ValueError, match=r"out has the shape \(5,\)"):
        result.mask(np.ones(5, bool))
    with pytest.raises(ValueError, match=r"out has the shape \(5,\); it must be \(4,\)"):
        result.mask(np.ones(5, bool))
    with pytest.raises(TypeError, match=r"array of bool of the shape \(4,\), not float64"):
        result.mask(np.ones(4))  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"array of bool of the shape \(4,\), not list"):
        result.mask([True] * 4)  # type: ignore[arg-type]
    many = wall.cull(pycullet.Cameras.look_at(np.zeros((2, 3)), (0, 0, -1)))
    with pytest.raises(ValueError, match=r"out has the shape \(4,\); it must be \(2, 4\)"):
        many.mask(np.ones(4, bool))
    assert read_only.all()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"size": (0, 100)}, r"size is \(0, 100\); it must be \(width, height\) in pixels, each from 1 to 65536"),
        ({"size": (100,)}, "width, height"),
        ({"size": (70_000, 1)}, "65536"),
        ({"fov_y": 0}, "fov_y is 0; it must be above 0 and below 180"),
        ({"fov_y": 180}, "below 180"),
        ({"fov_y": np.nan}, "fov_y"),
        ({"near": 0}, "near is 0; it must be above 0"),
        ({"near": 5, "far": 2}, "far is 2; it must be beyond near"),
        ({"up": (0, 0, 1)}, "span no plane"),
        ({"eye": (np.nan, 0, 0)}, "eye has NaN"),
        ({"eye": (0, 0, -1)}, "eye and target are both"),
        ({"eye": (0, 0)}, r"eye has the shape \(2,\); it must be \(3,\)"),
    ],
)
def test_cameras_that_see_nothing_are_refused(words: dict[str, Any], message: str) -> None:
    eye = words.pop("eye", (0, 0, 0))
    with pytest.raises(ValueError, match=message):
        pycullet.Camera.look_at(eye, (0, 0, -1), **words)


def test_matrices_that_show_nothing_are_refused() -> None:
    for matrix, message in ((np.zeros((4, 4)), "singular"), (np.full((4, 4), np.nan), "not finite")):
        with pytest.raises(ValueError, match=message):
            pycullet.Camera.from_matrix(matrix, size=(64, 64))
    with pytest.raises(ValueError, match=r"\(2, 4, 4\); it must be \(4, 4\)"):
        pycullet.Camera.from_matrix(np.stack([np.eye(4)] * 2), size=(64, 64))
    with pytest.raises(ValueError, match="camera 1: .*singular"):
        pycullet.Cameras.from_matrices(np.stack([np.eye(4), np.zeros((4, 4))]), size=(64, 64))
    with pytest.raises(ValueError, match='depth is "opengl"'):
        pycullet.Camera.from_matrix(np.eye(4), size=(64, 64), depth="opengl")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"targets has the shape \(2, 3\); it must be \(3, 3\)"):
        pycullet.Cameras.look_at(np.zeros((3, 3)), np.ones((2, 3)))


def test_empty_scenes_answer_with_nothing(ahead: pycullet.Camera) -> None:
    empty = pycullet.Scene()
    result = empty.cull(ahead)
    assert result.visible.tolist() == [] and result.mask().shape == (0,) and len(result.funnel) > 0
    assert empty.bounds is None and empty.verify(ahead) and (empty.render(ahead).ids == -1).all()
    assert "0 of 0" in repr(result) and "<table" in result._repr_html_()
    assert len(empty.cull(pycullet.Cameras.look_at(np.zeros((0, 3)), (0, 0, -1)))) == 0
    with pytest.raises(ValueError, match="no instance"):
        empty.report()
    with pytest.raises(ValueError, match="nothing to see"):
        empty.bake_pvs()
    nothing = pycullet.Scene.from_arrays(np.zeros((0, 3)), np.zeros((0, 3), int))
    assert nothing.cull(ahead).triangle_count == 0


def test_things_that_are_no_camera_culler_or_id_are_named(wall: pycullet.Scene, ahead: pycullet.Camera) -> None:
    bad: Any = np.eye(4)
    with pytest.raises(TypeError, match="pycullet.Camera or pycullet.Cameras, not ndarray; make one"):
        wall.cull(bad)
    bad = 3
    with pytest.raises(TypeError, match="pycullet.Culler or the name of a preset, not int"):
        wall.cull(ahead, bad)
    bad = "best"
    with pytest.raises(ValueError, match='no preset "best"; there are "exact"'):
        wall.cull(ahead, bad)
    with pytest.raises(ValueError, match='no stage "frustrum"; there are layer, frustum'):
        pycullet.Culler(without=["frustrum"])
    with pytest.raises(ValueError, match="min_pixels is -1"):
        pycullet.Culler(min_pixels=-1)
    with pytest.raises(IndexError, match="ids is -1; it must be from 0"):
        wall.remove(-1)
    with pytest.raises(IndexError, match="ids has -1 at 1; it must be from 0"):
        wall.remove(np.array([0, -1]))
    with pytest.raises(TypeError, match="ids must be of integers, not float64"):
        wall.remove(np.array([1.0]))
    with pytest.raises(IndexError, match="no mesh 7; the scene has 2"):
        wall.add_instances(7)


@pytest.mark.parametrize("number", [-1, 4, 2**32, 2**64, -(10**40), 10**40])
def test_numbers_that_name_nothing_are_named(wall: pycullet.Scene, ahead: pycullet.Camera, number: int) -> None:
    cameras = pycullet.Cameras.look_at(np.zeros((3, 3)), (0, 0, -1))
    instance = rf"no instance {number}; ids of this scene are at least 0 and below 4"
    mesh = rf"no mesh {number}; the scene has 2"
    camera = rf"no camera {number}; there are 3"
    calls: list[tuple[str, Callable[[], object]]] = [
        (instance, lambda: wall.explain(ahead, number)),
        (instance, lambda: wall.name(number)),
        (mesh, lambda: wall.mesh(number)),
        (mesh, lambda: wall.add_instances(number)),
        (str(number), lambda: wall.remove(number)),
        (str(number), lambda: wall.set_layers(number, 1)),
        (str(number), lambda: wall.boxes(number)),
    ]
    if number != -1:
        calls += [(camera, lambda: cameras[number]), (camera, lambda: wall.cull(cameras)[number])]
    for message, call in calls:
        with pytest.raises(IndexError, match=message):
            call()
    assert wall.instance_count == 4


@pytest.mark.parametrize("number", [-1, 2**64, -(10**40), 10**40])
def test_whole_numbers_that_are_out_of_range_are_named(
    wall: pycullet.Scene, ahead: pycullet.Camera, number: int
) -> None:
    eye, target, eyes = (0, 0, 0), (0, 0, -1), np.zeros((2, 3))
    words: dict[str, Any] = {"height": 1, "near": 0.1, "far": 9}
    calls: list[tuple[str, Callable[[], object]]] = [
        ("layers", lambda: pycullet.Camera.look_at(eye, target, layers=number)),
        ("layers", lambda: pycullet.Camera.orthographic(eye, target, layers=number, **words)),
        ("layers", lambda: pycullet.Camera.from_matrix(np.eye(4), size=(64, 64), layers=number)),
        ("layers", lambda: pycullet.Cameras.look_at(eyes, target, layers=number)),
        ("layers", lambda: pycullet.Cameras.from_matrices(np.eye(4), size=(64, 64), layers=number)),
        ("layers", lambda: wall.add(VERTICES, FACES, layers=number)),
        ("layers", lambda: wall.add_instances(0, layers=number)),
        ("layers", lambda: wall.set_layers(0, number)),
        ("count", lambda: pycullet.Cameras.along(wall, "walk", number)),
        ("seed", lambda: pycullet.Cameras.along(wall, "walk", 1, seed=number)),
        ("threads", lambda: wall.cull(ahead, threads=number)),
        ("samples", lambda: wall.verify(ahead, samples=number)),
        ("seed", lambda: wall.verify(ahead, seed=number)),
        ("threads", lambda: wall.verify(ahead, threads=number)),
        ("samples", lambda: wall.report(ahead, samples=number)),
        ("rays", lambda: wall.bake_pvs(rays=number)),
        ("seed", lambda: wall.bake_pvs(seed=number)),
        ("threads", lambda: wall.bake_pvs(threads=number)),
        ("cells", lambda: wall.bake_pvs(number)),
        ("width", lambda: wall.cull(ahead).pictures(number)),
    ]
    for name, call in calls:
        with pytest.raises(ValueError, match=rf"{name} is {number}; it must be (from|a number)"):
            call()


def test_numbers_of_another_type_are_named(wall: pycullet.Scene, ahead: pycullet.Camera) -> None:
    bad: Any = 1.0
    with pytest.raises(TypeError, match="id must be an integer, not float"):
        wall.explain(ahead, bad)
    with pytest.raises(TypeError, match="mesh must be an integer, not float"):
        wall.mesh(bad)
    with pytest.raises(TypeError, match="layers"):
        wall.set_layers(0, bad)
    with pytest.raises(TypeError, match="pycullet.Camera or pycullet.Cameras, not float"):
        wall.report(bad)
    bad = np.uint8(1)
    assert wall.name(bad) == wall.name(1)


def test_what_is_done_to_an_array_afterwards_changes_nothing(ahead: pycullet.Camera) -> None:
    vertices = VERTICES + np.array([0, 0, -5], np.float32)
    scene = pycullet.Scene.from_arrays(vertices, FACES)
    vertices[:] = np.nan
    assert scene.cull(ahead).visible.tolist() == [0]
    result = scene.cull(ahead)
    result.visible[:] = 77
    assert result.mask().tolist() == [False] and scene.cull(ahead).visible.tolist() == [0]


def test_results_know_that_their_scene_has_changed(wall: pycullet.Scene, ahead: pycullet.Camera) -> None:
    result = wall.cull(ahead)
    assert result._repr_html_().count("<img") == 2
    wall.remove(0)
    with pytest.raises(pycullet.StaleError, match="cull again"):
        result.pictures()
    assert "cull again" in result._repr_html_() and result.visible.tolist()[:2] == [0, 1]


def test_files_that_are_none_are_named(tmp_path: pathlib.Path) -> None:
    with pytest.raises(FileNotFoundError, match="there is no file .*nothing.glb"):
        pycullet.Scene.open(tmp_path / "nothing.glb")
    junk = tmp_path / "junk.glb"
    junk.write_bytes(b"junk")
    with pytest.raises(pycullet.FileError, match="junk.glb"):
        pycullet.Scene.open(junk)
    with pytest.raises(OSError, match="written"):
        pycullet.Scene.builtin("solids").save(tmp_path / "no" / "a.glb")
    with pytest.raises(ValueError, match="city"):
        pycullet.Scene.builtin("citty")
    with pytest.raises(ValueError, match='up is "x"'):
        pycullet.Scene.open(junk, up="x")  # type: ignore[arg-type]
