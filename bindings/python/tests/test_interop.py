"""trimesh, pyvista and files; cutting, occluders, sets and reports."""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np
import pytest

import pycullet

trimesh = pytest.importorskip("trimesh")
pyvista = pytest.importorskip("pyvista")


def boxes() -> Any:
    scene = trimesh.Scene()
    box = trimesh.creation.box()
    scene.add_geometry(box, node_name="left", geom_name="box")
    for name, x in (("middle", 3.0), ("right", 6.0)):
        place = trimesh.transformations.translation_matrix([x, 0, 0])
        scene.graph.update(name, matrix=place, geometry="box")
    return scene


def test_a_scene_of_trimesh_keeps_its_instances_and_names() -> None:
    scene = pycullet.Scene.from_trimesh(boxes())
    assert (scene.mesh_count, scene.instance_count) == (1, 3)
    names = [scene.name(i) for i in range(3)]
    assert sorted(names) == ["left", "middle", "right"]
    x = {"left": 0.0, "middle": 3.0, "right": 6.0}
    assert [t[0, 3] for t in scene.transforms()] == [x[n] for n in names]
    camera = pycullet.Camera.look_at((x[names[1]], 0, 5), (x[names[1]], 0, 0), fov_y=20, size=(64, 64))
    assert scene.cull(camera).visible.tolist() == [1]


def test_rays_of_trimesh_agree_with_the_reference_picture() -> None:
    mesh = trimesh.creation.icosphere(subdivisions=3)
    scene = pycullet.Scene.from_trimesh(mesh)
    camera = pycullet.Camera.look_at((0, 0, 3), (0, 0, 0), fov_y=50, size=(41, 41))
    image = scene.render(camera)
    tangent = np.tan(np.radians(25))
    at = (np.arange(41) + 0.5) / 41 * 2 - 1
    x, y = np.meshgrid(at * tangent, -at * tangent)
    ways = np.stack([x, y, -np.ones_like(x)], -1).reshape(-1, 3)
    hit = mesh.ray.intersects_first(np.tile([0.0, 0, 3], (len(ways), 1)), ways).reshape(41, 41)
    same = hit == image.triangles
    # Rays that meet an edge may take either side.
    assert same.mean() > 0.98 and (image.triangles >= 0).mean() > 0.3


def test_sides_are_those_of_the_material_where_it_says_them(tmp_path: pathlib.Path) -> None:
    corners, faces = [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]
    behind = pycullet.Camera.look_at((0.2, 0.2, -5), (0.2, 0.2, 0))
    for sides, drawn in ((False, []), (True, [0])):
        material = trimesh.visual.material.PBRMaterial(doubleSided=sides)
        visual = trimesh.visual.TextureVisuals(uv=np.zeros((3, 2)), material=material)
        mesh = trimesh.Trimesh(corners, faces, visual=visual)
        path = tmp_path / f"{sides}.glb"
        mesh.export(path)
        opened = pycullet.Scene.open(path)
        for scene in (opened, pycullet.Scene.from_trimesh(trimesh.load(path)), pycullet.Scene.from_trimesh(mesh)):
            assert scene.cull(behind).visible.tolist() == drawn and scene.verify(behind)
        other = pycullet.Scene.from_trimesh(mesh, two_sided=not sides)
        assert other.cull(behind).visible.tolist() == ([] if sides else [0])
    # Without a material an open mesh shows both sides, and a solid its outside.
    bare = pycullet.Scene.from_trimesh(trimesh.Trimesh(corners, faces))
    assert bare.cull(behind).visible.tolist() == [0]
    inside = pycullet.Camera.look_at((0, 0, 0), (0, 0, -1))
    box = trimesh.creation.box()
    assert (pycullet.Scene.from_trimesh(box).render(inside).ids == -1).all()
    box.visual = trimesh.visual.TextureVisuals(uv=np.zeros((8, 2)), material=material)
    assert (pycullet.Scene.from_trimesh(box).render(inside).ids == 0).all()


def test_a_mesh_that_changes_behind_a_scene_is_noticed(ahead: pycullet.Camera) -> None:
    mesh, sphere = trimesh.creation.box(), pyvista.Sphere()
    scene, other = pycullet.Scene.from_trimesh(mesh), pycullet.Scene.from_pyvista(sphere)
    assert scene.changed_sources() == [] and other.changed_sources() == []
    before = scene.bounds
    mesh.apply_translation([100, 0, 0])
    sphere.points += 1
    assert scene.changed_sources() == ["mesh"] and other.changed_sources() == ["mesh"]
    # It answers for what was copied.
    assert before is not None and scene.bounds is not None and np.array_equal(scene.bounds, before)


def test_data_sets_of_pyvista_come_as_their_surfaces() -> None:
    sphere = pycullet.Scene.from_pyvista(pyvista.Sphere())
    assert sphere.triangle_count == pyvista.Sphere().n_cells
    # Quads and volumes too.
    assert pycullet.Scene.from_pyvista(pyvista.Cube()).triangle_count == 12
    grid = pyvista.ImageData(dimensions=(3, 3, 3))
    assert pycullet.Scene.from_pyvista(grid).triangle_count == 48
    both = pycullet.Scene.from_pyvista(pyvista.MultiBlock([pyvista.Cube(), None, pyvista.Sphere()]))
    assert both.instance_count == 2


def test_a_plotter_gives_what_it_shows() -> None:
    plotter = pyvista.Plotter(off_screen=True)
    plotter.add_mesh(pyvista.Cube())
    plotter.add_mesh(pyvista.Sphere()).position = (3, 0, 0)
    plotter.add_mesh(pyvista.Cone()).visibility = False
    scene = pycullet.Scene.from_pyvista(plotter)
    assert scene.instance_count == 2
    assert np.allclose(scene.boxes(1)[0].mean(0), (3, 0, 0), atol=0.01)
    plotter.close()


def test_other_things_are_refused() -> None:
    with pytest.raises(TypeError, match=r"trimesh.Trimesh or trimesh.Scene, not ndarray"):
        pycullet.Scene.from_trimesh(np.zeros((3, 3)))
    with pytest.raises(TypeError, match="pyvista data set, MultiBlock or Plotter, not int"):
        pycullet.Scene.from_pyvista(3)


def test_far_from_the_origin_nothing_is_lost() -> None:
    mesh = trimesh.creation.icosphere()
    mesh.apply_translation([4.5e6, 5.2e6, 100])
    scene = pycullet.Scene.from_trimesh(mesh)
    assert scene.bounds is not None and np.allclose(scene.bounds, mesh.bounds, atol=1e-3)
    centre = mesh.bounds.mean(0)
    camera = pycullet.Camera.look_at(centre + [0, 0, 3], centre, size=(64, 64))
    depth = scene.render(camera).depth
    assert abs(depth.min() - 2) < 0.02 and scene.verify(camera)


def test_a_capped_cut_is_closed() -> None:
    scene = pycullet.Scene.from_trimesh(boxes())
    ids = {scene.name(i): i for i in range(3)}
    half = scene.cut((1, 0, 0, 3.2))
    assert half.is_watertight and abs(half.volume - 1.7) < 1e-6
    assert set(half.face_attributes["id"].tolist()) == {ids["left"], ids["middle"]}
    caps = half.face_attributes["cap"]
    assert 0 < caps.sum() < len(caps) and np.allclose(half.triangles[caps][:, :, 0], 3.2)
    rest = scene.cut((1, 0, 0, 3.2), keep="outside")
    assert abs(half.volume + rest.volume - 3) < 1e-6
    assert not scene.cut((1, 0, 0, 3.2), cap=False).is_watertight
    corner = scene.cut([[1, 0, 0, 0.25], [0, 1, 0, 0.25]])
    assert corner.is_watertight and abs(corner.volume - 0.75**2) < 1e-6
    assert len(scene.cut((1, 0, 0, -9)).faces) == 0
    with pytest.raises(ValueError, match="not a plane"):
        scene.cut((0, 0, 0, 1))
    with pytest.raises(ValueError, match=r"planes has the shape \(3,\)"):
        scene.cut((1, 0, 0))


def test_occluders_lie_within_their_meshes(ahead: pycullet.Camera) -> None:
    scene = pycullet.Scene.from_trimesh(trimesh.creation.icosphere(subdivisions=3))
    (occluder,) = scene.occluders()
    assert 0.3 < occluder.efficiency <= 1 and len(occluder.boxes) + len(occluder.triangles) > 0
    corners = occluder.boxes.reshape(-1, 3)
    assert (np.linalg.norm(corners, axis=1) <= 1).all()
    assert scene.verify(pycullet.Camera.look_at((0, 0, 3), (0, 0, 0), size=(64, 64)), "exact")


def test_sets_are_baked_kept_and_culled_by(wall: pycullet.Scene, tmp_path: pathlib.Path) -> None:
    pvs = wall.bake_pvs((2, 1, 2), region=[[-2, 0, -2], [2, 2, 2]], rays=200_000)
    assert len(pvs) == 4 and pvs.cells.shape == (4, 2, 3) and pvs.matrix.shape == (4, 4)
    (cell,) = pvs.cell_of((1, 1, 1))
    assert {0, 1} <= set(pvs.visible(cell).tolist()) and 2 not in pvs.visible(cell)
    assert pvs.cell_of([[0, 0, 9], [1, 1, 1]]).tolist() == [-1, cell]
    assert np.array_equal(pvs.visible(np.arange(4)), np.flatnonzero(pvs.matrix.any(0)))
    pvs.save(tmp_path / "wall.pvs")
    again = wall.open_pvs(tmp_path / "wall.pvs")
    assert np.array_equal(again.matrix, pvs.matrix) and np.array_equal(again.missing, pvs.missing)
    wall.set_pvs(again)
    camera = pycullet.Camera.look_at((1, 1, 1), (1, 1, -1), size=(64, 64))
    only = pycullet.Culler(without=["frustum", "occlusion"])
    assert np.array_equal(wall.cull(camera, only).visible, pvs.visible(cell))
    wall.set_pvs(None)
    assert wall.cull(camera, only).visible.tolist() == [0, 1, 2, 3]
    wall.remove(3)
    with pytest.raises(pycullet.FileError, match="another scene"):
        wall.open_pvs(tmp_path / "wall.pvs")
    for cells in (0, (1, 0, 1), "many"):
        with pytest.raises(ValueError, match="cells is"):
            wall.bake_pvs(cells)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="region"):
        wall.bake_pvs(4, region=[[1, 1, 1], [0, 0, 0]])
    with pytest.raises(IndexError, match="no cell 4; there are 4"):
        pvs.visible(4)


def test_files_come_back_as_they_went(city: pycullet.Scene, tmp_path: pathlib.Path) -> None:
    city.save(tmp_path / "city.glb")
    again = pycullet.Scene.open(tmp_path / "city.glb")
    assert again.triangle_count == city.triangle_count and len(again) == len(city)
    camera = pycullet.Cameras.along(city, "walk", 3, size=(320, 200))[1]
    assert np.array_equal(again.cull(camera).visible, city.cull(camera).visible)
    loaded = pycullet.Scene.from_trimesh(trimesh.load(tmp_path / "city.glb"))
    assert loaded.triangle_count == city.triangle_count


def test_a_report_adds_up(city: pycullet.Scene, tmp_path: pathlib.Path) -> None:
    report = city.report(pycullet.Cameras.along(city, "walk", 4, size=(160, 100)))
    proof = report.proof
    assert proof and int(report.stages["triangles"].sum()) == proof.all - proof.kept
    assert 0.5 < report.wasted < 1 and report.title.startswith("city")
    report.save(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert page.count("data:image/png") == 2 and "Nothing visible was lost" in page
    assert len(city.report().results) == 8
    camera = pycullet.Cameras.along(city, "walk", 4, size=(160, 100))[2]
    one = city.report(camera)
    assert len(one.results) == 1 and np.array_equal(one.results[0], city.cull(camera).visible)
    with pytest.raises(ValueError, match="no cameras"):
        city.report(pycullet.Cameras.along(city, "walk", 4)[:0])
