"""Plotters of pyvista: the picture with culling is the one without, whatever is done to actors."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import pycullet

pyvista = pytest.importorskip("pyvista")
hooks = pytest.importorskip("pycullet.pyvista")


@pytest.fixture
def plotter() -> Iterator[Any]:
    made = pyvista.Plotter(off_screen=True, window_size=(240, 160))
    yield made
    made.close()


def shot(plotter: Any) -> Any:
    # A screenshot alone is of what was drawn last.
    plotter.render_window.Render()
    return np.array(plotter.screenshot(return_img=True))


def same(plotter: Any, culler: Any = "exact") -> Any:
    """Compares the pictures with and without culling; returns what each renderer did."""
    hook = hooks.attach(plotter, culler)
    culled = shot(plotter)
    renders = hook.renders
    hooks.detach(plotter)
    plain = shot(plotter)
    assert np.array_equal(culled, plain), f"{(culled != plain).any(-1).sum()} pixels differ"
    return renders


def streets(plotter: Any, side: int = 14) -> list[Any]:
    random = np.random.default_rng(5)
    actors = []
    for x in range(side):
        for y in range(side):
            height = random.uniform(2, 9)
            house = pyvista.Cube(center=(x * 1.6, y * 1.6, height / 2), x_length=1, y_length=1, z_length=height)
            actors.append(plotter.add_mesh(house, color=random.random(3), render=False))
    plotter.camera_position = [(10.2, -3, 1.5), (10.6, 30, 2), (0, 0, 1)]
    plotter.camera.clipping_range = (0.1, 100)
    return actors


def screen(plotter: Any) -> tuple[Any, Any]:
    """A wall, and a ball behind it."""
    wall = plotter.add_mesh(pyvista.Plane(i_size=4, j_size=4), color="white", name="wall")
    ball = plotter.add_mesh(pyvista.Sphere(radius=0.5, center=(0, 0, -2)), color="red", name="ball")
    plotter.camera_position = [(0, 0, 6), (0, 0, 0), (0, 1, 0)]
    plotter.camera.clipping_range = (0.1, 100)
    return wall, ball


def test_a_city_looks_the_same_from_everywhere_and_most_of_it_is_not_drawn(plotter: Any) -> None:
    actors = streets(plotter)
    actors[3].visibility = False
    hook = hooks.attach(plotter)
    plotter.camera_position = [(10.4, 10.4, 1.5), (10.4, 20, 2), (0, 0, 1)]
    plotter.camera.clipping_range = (0.1, 100)
    for _ in range(6):
        plotter.camera.Yaw(55)
        with_hook = shot(plotter)
        (render,) = hook.renders
        assert render.shown == len(actors) - 1 and render.culled > 0.5 * len(actors)
        # What is the user's is as it was.
        assert [actor.visibility for actor in actors] == [at != 3 for at in range(len(actors))]
        hooks.detach(plotter)
        assert np.array_equal(with_hook, shot(plotter))
        hook = hooks.attach(plotter)


@pytest.mark.parametrize("parallel", [False, True])
def test_an_actor_that_is_lost_is_found_out(plotter: Any, monkeypatch: pytest.MonkeyPatch, parallel: bool) -> None:
    streets(plotter, 8)
    plotter.camera.parallel_projection = parallel
    plotter.camera.parallel_scale = 3
    plotter.camera_position = [(6, -9, 12), (6, 6, 0), (0, 0, 1)]
    (render,) = same(plotter)
    assert 0 < render.culled < render.shown
    cull = pycullet.Scene.cull
    lost: list[int] = []

    class Lossy:
        def __init__(self, scene: Any, view: Any, culler: Any) -> None:
            self.found, self.image = cull(scene, view, culler), scene.render(view)

        def mask(self) -> Any:
            mask = self.found.mask()
            lost.append(next(int(id) for id in self.image.visible if id not in lost))
            mask[lost[-1]] = False
            return mask

    monkeypatch.setattr(pycullet.Scene, "cull", lambda *words: Lossy(*words))
    for _ in range(5):
        with pytest.raises(AssertionError, match="pixels differ"):
            same(plotter)


def clip(wall: Any) -> None:
    plane = pyvista._vtk.vtkPlane() if hasattr(pyvista, "_vtk") else __import__("vtk").vtkPlane()
    plane.SetNormal(1, 0, 0)
    wall.mapper.AddClippingPlane(plane)


def shrink(data: Any) -> None:
    data.points *= 0.05


CHANGES: dict[str, tuple[Callable[[Any, Any], object], int]] = {
    "nothing": (lambda wall, ball: None, 1),
    "moved": (lambda wall, ball: setattr(wall, "position", (3, 0, 0)), 0),
    "turned": (lambda wall, ball: wall.RotateY(90), 0),
    "ball moved": (lambda wall, ball: setattr(ball, "position", (0, 0, 4)), 0),
    "user matrix": (lambda wall, ball: setattr(wall, "user_matrix", np.diag([0.05, 0.05, 1, 1])), 0),
    "hidden": (lambda wall, ball: setattr(wall, "visibility", False), 0),
    "translucent": (lambda wall, ball: setattr(wall.prop, "opacity", 0.4), 0),
    "wireframe": (lambda wall, ball: setattr(wall.prop, "style", "wireframe"), 0),
    "points": (lambda wall, ball: setattr(ball.prop, "style", "points"), 0),
    "edges": (lambda wall, ball: setattr(ball.prop, "show_edges", True), 0),
    "clipped": (lambda wall, ball: clip(wall), 0),
    "face culling": (lambda wall, ball: setattr(wall.prop, "culling", "front"), 0),
    "other data": (lambda wall, ball: wall.mapper.SetInputData(pyvista.Disc(inner=1, outer=2, c_res=24)), 0),
    "changed data": (lambda wall, ball: shrink(wall.mapper.dataset), 0),
    "translucent ball": (lambda wall, ball: setattr(ball.prop, "opacity", 0.4), 1),
    "texture": (lambda wall, ball: setattr(wall, "texture", pyvista.numpy_to_texture(np.full((8, 8, 3), 99, np.uint8))), 0),
}


@pytest.mark.parametrize("name", CHANGES)
def test_changes_show_in_the_next_render(plotter: Any, name: str) -> None:
    wall, ball = screen(plotter)
    hook = hooks.attach(plotter)
    shot(plotter)
    assert hook.renders[0] == hooks.Render(2, 1, 0)
    change, culled = CHANGES[name]
    change(wall, ball)
    with_hook = shot(plotter)
    assert hook.renders[0].culled == culled
    hooks.detach(plotter)
    assert np.array_equal(with_hook, shot(plotter))


def test_actors_come_and_go(plotter: Any) -> None:
    wall, _ = screen(plotter)
    hook = hooks.attach(plotter)
    shot(plotter)
    plotter.remove_actor(wall)
    red = shot(plotter)
    assert hook.renders[0] == hooks.Render(1, 0, 0) and (red[80, 120] != red[0, 0]).any()
    plotter.add_mesh(pyvista.Plane(i_size=4, j_size=4), color="white")
    plotter.add_mesh(pyvista.Cone(center=(0, 0, -3)), color="blue")
    shot(plotter)
    assert hook.renders[0] == hooks.Render(3, 2, 0)
    plotter.clear()
    shot(plotter)
    assert hook.renders[0].shown == 0


def test_data_that_change_often_hide_nothing_but_are_culled(plotter: Any) -> None:
    wall, ball = screen(plotter)
    hook = hooks.attach(plotter)
    for step in range(6):
        ball.mapper.dataset.points += 0.001
        wall.mapper.dataset.points *= 1.01
        shot(plotter)
        assert hook.renders[0].culled == (1 if step < 4 else 0)
    plotter.camera.position, plotter.camera.focal_point = (0, 0, 6), (0, 0, 9)
    shot(plotter)
    assert hook.renders[0].culled == 2


def test_what_is_not_known_is_left_alone(plotter: Any) -> None:
    _, ball = screen(plotter)
    shader = plotter.add_mesh(pyvista.Sphere(center=(9, 0, -2)))
    shader.GetShaderProperty().AddVertexShaderReplacement(
        "//VTK::PositionVC::Impl", True, "//VTK::PositionVC::Impl\n  gl_Position.x -= 9.0;\n", False
    )
    plotter.add_points(np.random.default_rng(1).random((9, 3)), style="points_gaussian", emissive=False)
    plotter.add_mesh(pyvista.Line((-9, 0, -3), (9, 0, -3)), line_width=9)
    plotter.add_text("words")
    plotter.add_axes()
    plotter.add_point_labels([[0.0, 0, -1]], ["label"])
    volume = plotter.add_volume(pyvista.Wavelet(), show_scalar_bar=False)
    volume.position = (0, 0, -30)
    (render,) = same(plotter)
    assert (render.shown, render.culled) == (2, 1) and render.left_alone >= 6
    ball.GetShaderProperty().ClearAllShaderReplacements()
    assert same(plotter)[0].culled == 1


def test_each_renderer_has_its_own_camera() -> None:
    plotter = pyvista.Plotter(off_screen=True, shape=(1, 2), window_size=(320, 160))
    for column in range(2):
        plotter.subplot(0, column)
        screen(plotter)
    # The first one sees the ball from its own side, the second one with parallel lines of sight and behind the wall.
    shared = plotter.renderers[0].actors["ball"]
    plotter.renderers[1].AddActor(shared)
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = 3
    plotter.renderers[0].camera_position = [(0, 0, -6), (0, 0, 0), (0, 1, 0)]
    assert same(plotter) == (hooks.Render(2, 0, 0), hooks.Render(3, 2, 0))
    assert shared.visibility
    plotter.close()


def test_blocks_are_culled_on_their_own(plotter: Any) -> None:
    screen(plotter)
    balls = pyvista.MultiBlock([pyvista.Sphere(radius=0.2, center=(x, 0, -2)) for x in (-0.5, 0, 0.5)])
    actor, mapper = plotter.add_composite(balls, color="green")
    assert same(plotter)[0] == hooks.Render(5, 4, 0)
    hook = hooks.attach(plotter)
    shot(plotter)
    # One leaves the shadow of the wall: the others stay hidden, and are the user's again after the render.
    balls[1].points += (0, 0, 4)
    shot(plotter)
    assert hook.renders[0] == hooks.Render(5, 3, 0)
    looks = mapper.GetCompositeDataDisplayAttributes()
    assert not looks.HasBlockVisibilities() and all(mapper.block_attr[at].visible is None for at in (1, 2, 3))
    assert same(plotter)[0].culled == 3
    # Once the user shows and hides blocks, they are no longer touched.
    mapper.block_attr[1].visible = False
    assert same(plotter)[0].culled == 1 and mapper.block_attr[1].visible is False
    mapper.block_attr[1].visible = None
    walls = pyvista.MultiBlock([pyvista.Plane(center=(x, 0, 2), i_size=2, j_size=4) for x in (-0.9, 0.9)])
    actor, mapper = plotter.add_composite(walls, color="blue")
    assert same(plotter)[0].culled == 4
    mapper.block_attr[1].opacity = 0.3
    assert same(plotter)[0].culled == 3


def test_surfaces_of_grids_hide_too(plotter: Any) -> None:
    screen(plotter)
    grid = pyvista.ImageData(dimensions=(3, 3, 2), spacing=(2, 2, 0.1), origin=(-2, -2, 1))
    plotter.add_mesh(grid, color="blue")
    assert same(plotter)[0] == hooks.Render(3, 2, 0)
    moved = grid.cast_to_unstructured_grid()
    plotter.clear()
    screen(plotter)
    plotter.add_mesh(moved, color="blue")
    # Faces of such a grid need not be flat: it hides nothing.
    assert same(plotter)[0] == hooks.Render(3, 1, 0)


def test_a_fault_draws_everything_and_is_told_once(plotter: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    _, ball = screen(plotter)
    hook = hooks.attach(plotter)
    shot(plotter)
    monkeypatch.setattr(hooks, "_view", lambda renderer: 1 / 0)
    with pytest.warns(RuntimeWarning, match="culls nothing: ZeroDivisionError") as told:
        shot(plotter)
        shot(plotter)
    assert len(told) == 1 and ball.visibility and hook.renders[0] == hooks.Render(0, 0, 0)
    monkeypatch.undo()
    shot(plotter)
    assert hook.renders[0].culled == 1


def test_passes_and_stereo_are_left_alone(plotter: Any) -> None:
    screen(plotter)
    plotter.enable_eye_dome_lighting()
    assert same(plotter)[0] == hooks.Render(0, 0, 0)
    plotter.disable_eye_dome_lighting()
    assert same(plotter)[0].culled == 1


def test_windows_of_vtk_and_nothing_else(plotter: Any) -> None:
    screen(plotter)
    with hooks.attach(plotter.render_window) as hook:
        shot(plotter)
        assert hook.renders[0].culled == 1
    shot(plotter)
    assert hook.renders[0].culled == 1 and not plotter.render_window.HasObserver("StartEvent")
    again = hooks.attach(plotter)
    assert hooks.attach(plotter) is not again
    shot(plotter)
    assert again.renders[0] == hooks.Render(0, 0, 0)
    with pytest.raises(TypeError, match="plotter must be a pyvista.Plotter, .* not int"):
        hooks.attach(3)
