"""What is visible, why the rest is not, and the proof."""

from __future__ import annotations

import pickle
import threading
import time

import numpy as np
import pytest
from conftest import QUAD, place

import pycullet


def test_what_is_behind_and_beside_is_culled(wall: pycullet.Scene, ahead: pycullet.Camera) -> None:
    exact = pycullet.Culler("exact", reasons=True)
    result = wall.cull(ahead, exact)
    assert result.visible.tolist() == [0, 1] and result.visible.dtype == np.uint32
    assert result.mask().tolist() == [True, True, False, False]
    assert [pycullet.STAGES[r["stage"] - 1] for r in result.reasons[2:]] == ["occlusion", "frustum"]
    assert result.reasons["stage"][:2].tolist() == [0, 0]
    assert result.funnel[0]["instances_in"] == 4 and result.funnel[-1]["instances_out"] == 2
    assert len(result) == 2 and result.triangle_count == 4
    everything = wall.cull(ahead, pycullet.Culler(without=["frustum", "occlusion"]))
    assert everything.visible.tolist() == [0, 1, 2, 3]


def test_an_explanation_says_the_stage_and_who_hides_it(wall: pycullet.Scene, ahead: pycullet.Camera) -> None:
    behind = wall.explain(ahead, 2, "exact")
    assert behind.reason == "occlusion" and behind.hidden_by[-1] == 0
    assert not behind.is_visible and "hidden by" in str(behind) and "plate" in str(behind)
    assert wall.explain(ahead, 3).reason == "frustum"
    assert wall.explain(ahead, 1).is_visible
    with pytest.raises(IndexError, match="no instance 9.*below 4"):
        wall.explain(ahead, 9)


def test_many_cameras_answer_as_one_at_a_time_on_any_number_of_threads(city: pycullet.Scene) -> None:
    cameras = pycullet.Cameras.along(city, "walk", 40, size=(320, 200))
    results = city.cull(cameras, "exact", threads=1)
    assert len(results) == 40 and results.offsets[-1] == len(results.ids)
    for at, camera in enumerate(cameras[i] for i in range(40)):
        one = city.cull(camera, "exact")
        assert np.array_equal(results[at], one.visible)
        own = results.funnel[results.funnel["camera"] == at]
        assert all(np.array_equal(own[name], one.funnel[name]) for name in one.funnel.dtype.names or ())
    for threads in (0, 2, 5):
        again = city.cull(cameras, "exact", threads=threads)
        assert np.array_equal(again.ids, results.ids) and np.array_equal(again.funnel, results.funnel)
    mask = results.mask()
    assert mask.shape == (40, city.id_count) and np.array_equal(mask.sum(1), results.counts)
    assert np.array_equal(np.flatnonzero(mask[-1]), results[-1])
    assert len(cameras[3:9]) == 6 and cameras[3:9][0] == cameras[3]
    with pytest.raises(IndexError, match="no camera 40"):
        results[40]


def test_nothing_that_owns_a_pixel_is_dropped(city: pycullet.Scene) -> None:
    cameras = pycullet.Cameras.along(city, "walk", 3, size=(160, 100))
    proof = city.verify(cameras, "exact")
    assert proof and proof.ok and proof.visible <= proof.kept < proof.all
    assert proof.tightness >= 1 and "nothing visible was lost" in repr(proof)
    for at in range(3):
        truth, kept = city.render(cameras[at]), city.cull(cameras[at], "exact").visible
        assert 3 < len(truth.visible) <= len(kept) and np.isin(truth.visible, kept).all()
        assert np.array_equal(city.render(cameras[at], "exact").ids, truth.ids)


def test_a_lossy_stage_is_found_out(wall: pycullet.Scene, ahead: pycullet.Camera) -> None:
    proof = wall.verify(ahead, pycullet.Culler(min_pixels=1e4))
    assert not proof and {0, 1} == set(proof.false_culls["id"].tolist())
    assert "were lost" in repr(proof)


def test_pictures_have_colours_distances_and_ids(wall: pycullet.Scene, ahead: pycullet.Camera) -> None:
    image = wall.render(ahead)
    assert image.color.shape == (200, 320, 3) and image.color.dtype == np.uint8
    assert image.ids[100, 160] == 1 and image.ids[2, 2] == 0
    # Both plates stand square to the view, so that all of each is as far away.
    assert np.allclose(image.depth[image.ids == 1], 4) and np.allclose(image.depth[image.ids == 0], 5)
    side = pycullet.Camera.orthographic((0, 0, 0), (0, 0, -1), height=400, near=1, far=9, size=(64, 64))
    flat = wall.render(side)
    assert np.allclose(flat.depth[flat.ids == 0], 4) and np.isinf(flat.depth[flat.ids == -1]).all()
    assert (flat.triangles[flat.ids == -1] == -1).all() and (flat.ids == -1).any()


def test_triangles_are_those_of_the_mesh_as_it_came(ahead: pycullet.Camera) -> None:
    # Two triangles in sight, the second of which faces away.
    vertices = np.array([[-1, -1, -5], [1, -1, -5], [0, 1, -5]], np.float32)
    faces = np.array([[0, 1, 2], [0, 2, 1]])
    scene = pycullet.Scene.from_arrays(vertices, faces, two_sided=False)
    result = scene.cull(ahead, pycullet.Culler(output="triangles"))
    assert result.triangles.tolist() == [(0, 0)]
    with pytest.raises(AttributeError, match='output="triangles"'):
        scene.cull(ahead).triangles
    with pytest.raises(AttributeError, match="reasons=True"):
        scene.cull(ahead).reasons


def test_partial_instances_have_their_clusters(city: pycullet.Scene) -> None:
    camera = pycullet.Cameras.along(city, "walk", 8, size=(320, 200))[2]
    result = city.cull(camera)
    assert np.isin(result.partial["id"], result.visible).all()
    assert set(result.partial.dtype.names or ()) == {"id", "level", "first_cluster", "cluster_count"}


def test_instances_move_leave_and_come(wall: pycullet.Scene, ahead: pycullet.Camera) -> None:
    wall.set_transforms([2, 3], np.stack([place(1, 1, -3), place(-1, 1, -3)]))
    assert wall.cull(ahead).visible.tolist() == [0, 1, 2, 3]
    wall.remove(1)
    assert wall.cull(ahead).visible.tolist() == [0, 2, 3] and len(wall) == 3
    new = wall.add(*QUAD, place(0, 0, -2))
    # The id of the one that left is not given again.
    assert new.tolist() == [4] and wall.cull(ahead).visible.tolist() == [0, 2, 3, 4]
    wall.set_layers(4, 2)
    only = pycullet.Camera.look_at((0, 0, 0), (0, 0, -1), layers=1)
    assert wall.cull(only).visible.tolist() == [0, 2, 3]
    wall.commit()
    assert wall.cull(only).visible.tolist() == [0, 2, 3]
    with pytest.raises(IndexError, match="instance 1 was removed"):
        wall.remove([2, 1])
    # Nothing of a call that is refused was done.
    assert wall.ids.tolist() == [0, 2, 3, 4]
    assert np.array_equal(wall.transforms([4])[0], place(0, 0, -2))


def test_cameras_can_be_pickled_and_compared(ahead: pycullet.Camera) -> None:
    again = pickle.loads(pickle.dumps(ahead))
    assert again == ahead and again.size == (320, 200)
    assert np.array_equal(again.clip_from_world, ahead.clip_from_world)
    assert ahead.eye is not None and np.allclose(ahead.eye, 0)


def test_a_matrix_is_the_same_camera(wall: pycullet.Scene) -> None:
    # A symmetric projection, standard depth, at the origin: near 1, far 100, 90 degrees, twice as wide as high.
    matrix = np.array([[0.5, 0, 0, 0], [0, 1, 0, 0], [0, 0, -100 / 99, -100 / 99], [0, 0, -1, 0]])
    camera = pycullet.Camera.from_matrix(matrix, size=(202, 101))
    same = pycullet.Camera.look_at((0, 0, 0), (0, 0, -1), size=(202, 101), fov_y=90, near=1, far=100)
    assert np.array_equal(wall.render(camera).ids, wall.render(same).ids)


def test_other_threads_go_on_while_one_culls(city: pycullet.Scene) -> None:
    cameras = pycullet.Cameras.along(city, "walk", 400, size=(320, 200))
    done = threading.Event()

    def cull() -> None:
        for _ in range(5):
            city.cull(cameras, threads=1)
        done.set()

    worker = threading.Thread(target=cull)
    steps, longest, last = 0, 0.0, time.perf_counter()
    worker.start()
    while not done.is_set():
        now = time.perf_counter()
        steps, longest, last = steps + 1, max(longest, now - last), now
        time.sleep(0)
    took = time.perf_counter() - last
    worker.join()
    assert steps > 50 and took < 1


def test_a_scene_that_is_being_culled_cannot_be_changed(city: pycullet.Scene) -> None:
    cameras = pycullet.Cameras.along(city, "walk", 2000, size=(320, 200))
    worker = threading.Thread(target=lambda: city.cull(cameras, threads=1))
    refused = False
    worker.start()
    while worker.is_alive():
        try:
            city.commit()
        except RuntimeError:
            refused = True
    worker.join()
    assert refused
