"""A thousand poses on a model: `cullet` against rays of trimesh and the frustum selection of pyvista.

    CULLET_DATA=... python bench/poses.py [POSES]

The questions differ, and so do the answers. trimesh casts one ray a pixel at 32 × 20 pixels: what it finds is visible,
and what is between the rays is missed. pyvista takes out what is in the frustum: hidden or not, and cell by cell. cullet
gives every instance that may be visible, and loses none. Each answer is checked: rays against the reference picture,
what rays hit against what cullet keeps, and what cullet keeps against the boxes that meet the frustum.
"""

from __future__ import annotations

import os
import pathlib
import sys
import time

import numpy as np
import numpy.typing as npt
import pyvista
import trimesh
import vtk

import pycullet

SIZE = (32, 20)
# Poses that the others are timed on: the rest is reckoned from them.
SOME = 4
# Rays that trimesh is given at once: the castle's candidates for all of a pose take 24 GB.
AT_ONCE = 16
FOV = 60.0
FAR = 1e4


def rays(eye: npt.NDArray[np.float64], target: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Directions through the middles of pixels, row by row from the top."""
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, [0, 1, 0])
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    height = np.tan(np.radians(FOV) / 2)
    x = ((np.arange(SIZE[0]) + 0.5) / SIZE[0] * 2 - 1) * height * SIZE[0] / SIZE[1]
    y = (1 - (np.arange(SIZE[1]) + 0.5) / SIZE[1] * 2) * height
    grid_x, grid_y = np.meshgrid(x, y)
    ways: npt.NDArray[np.float64] = ahead + grid_x[..., None] * right + grid_y[..., None] * up
    return ways.reshape(-1, 3)


def main(poses: int) -> None:
    file = pathlib.Path(os.environ["CULLET_DATA"]) / "intel-castle" / "intel-castle.glb"
    source = trimesh.load(file)
    assert isinstance(source, trimesh.Scene)
    scene = pycullet.Scene.from_trimesh(source, two_sided=True)
    cameras = pycullet.Cameras.along(scene, "walk", poses, size=SIZE)
    # Eyes of the walk, one projection for all three.
    random = np.random.default_rng(1)
    eyes = cameras.eyes
    angles = random.uniform(0, 2 * np.pi, poses)
    targets = eyes + np.stack([np.sin(angles), np.zeros(poses), np.cos(angles)], 1)
    cameras = pycullet.Cameras.look_at(eyes, targets, size=SIZE, fov_y=FOV, near=0.1, far=FAR)
    print(f"{file.name}: {scene.instance_count} instances, {scene.triangle_count} triangles; {poses} poses")

    seconds: dict[str, float] = {}
    for preset in ("fast", "balanced", "exact"):
        begin = time.perf_counter()
        results = scene.cull(cameras, preset)
        seconds[f"cullet, {preset}"] = time.perf_counter() - begin
        print(f"cullet, {preset}: {results.counts.mean():.1f} instances kept on average")
    begin = time.perf_counter()
    for at in range(poses):
        scene.cull(cameras[at])
    seconds["cullet, balanced, one at a time"] = time.perf_counter() - begin
    kept = scene.cull(cameras, "exact")

    # One mesh, and of which instance each of its triangles is.
    nodes = [source.graph[node] for node in source.graph.nodes_geometry]
    parts = [source.geometry[name].copy().apply_transform(place) for place, name in nodes]
    whole = trimesh.util.concatenate(parts)
    instance = np.repeat(np.arange(len(parts)), [len(p.faces) for p in parts])
    whole.ray.intersects_first(eyes[:1], targets[:1] - eyes[:1])
    some = min(poses, SOME)
    begin, lost, agreed = time.perf_counter(), 0, []
    found = []
    for at in range(some):
        ways = rays(eyes[at], targets[at])
        pieces = np.array_split(ways, -(-len(ways) // AT_ONCE))
        hits = [whole.ray.intersects_first(np.tile(eyes[at], (len(w), 1)), w) for w in pieces]
        hit = np.concatenate(hits)
        found.append(np.where(hit >= 0, instance[hit], -1))
    seconds["trimesh, rays"] = (time.perf_counter() - begin) * poses / some
    for at, ids in enumerate(found):
        lost += int((~np.isin(ids[ids >= 0], kept[at])).sum())
        agreed.append((scene.render(cameras[at]).ids.ravel() == ids).mean())
    print(f"trimesh: {np.mean(agreed):.2%} of rays hit what the reference picture shows; {lost} hit what cullet dropped")
    assert np.mean(agreed) > 0.98

    surface = pyvista.wrap(whole)
    surface.cell_data["instance"] = instance
    begin, wider = time.perf_counter(), 0
    selected = []
    for at in range(some):
        camera = pyvista.Camera()
        camera.position, camera.focal_point, camera.up = eyes[at], targets[at], (0, 1, 0)
        camera.view_angle, camera.clipping_range = FOV, (0.1, FAR)
        planes = [0.0] * 24
        camera.GetFrustumPlanes(SIZE[0] / SIZE[1], planes)
        frustum = vtk.vtkPlanes()
        frustum.SetFrustumPlanes(planes)
        selector = vtk.vtkExtractGeometry()
        selector.SetInputData(surface)
        selector.SetImplicitFunction(frustum)
        selector.ExtractBoundaryCellsOn()
        selector.Update()
        inside = pyvista.wrap(selector.GetOutput())
        selected.append(np.unique(inside.cell_data["instance"]))
    seconds["pyvista, frustum"] = (time.perf_counter() - begin) * poses / some
    frustum_only = scene.cull(cameras[:some], pycullet.Culler("exact", output="instances", without=["occlusion"]))
    for at in range(some):
        wider += int((~np.isin(selected[at], frustum_only[at])).sum())
    print(f"pyvista: {np.mean([len(s) for s in selected]):.1f} instances in the frustum on average; cullet's frustum lacks {wider} of them")
    assert wider == 0

    base = seconds["cullet, balanced"]
    print(f"\n{'for all poses':<36}{'seconds':>10}{'poses/s':>12}{'times cullet':>14}")
    for name, s in seconds.items():
        print(f"{name:<36}{s:>10.3f}{poses / s:>12.0f}{s / base:>14.1f}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
