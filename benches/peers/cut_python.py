#!/usr/bin/env python3
"""cullet's cuts beside those of trimesh and VTK (through pyvista), on the sphere of `cullet bench cut`.

    python3 benches/peers/cut_python.py target/release/cullet

Makes an environment of its own beside the build (target/peers-python) and installs the peers into it from PyPI
the first time. Times are wall seconds, the fastest of a few, of one thread each; cullet's come from its own bench,
run before the peers.
"""

import json
import os
import subprocess
import sys
import time
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ["numpy", "pyvista", "trimesh", "scipy", "shapely", "networkx", "mapbox_earcut", "rtree"]
NORMAL, OFFSET = (0.48, 0.6, 0.64), 0.05
LOW, HIGH = (-0.6, -0.5, -0.7), (0.5, 0.6, 0.4)


def enter_environment():
    """Runs this script again with the peers at hand, unless they are."""
    home = Path(os.environ.get("CULLET_PEERS_PYTHON", ROOT / "target" / "peers-python"))
    python = home / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if Path(sys.prefix).resolve() == home.resolve():
        return
    if not python.exists():
        print(f"making {home}", file=sys.stderr)
        venv.create(home, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
    sys.exit(subprocess.run([python, __file__, *sys.argv[1:]]).returncode)


def sphere(np, rings=500):
    """The sphere of programs/cullet-lab/src/bench/cut.rs: 998,000 triangles, closed."""
    around = rings * 2
    polar = np.pi * np.arange(1, rings) / rings
    turn = 2 * np.pi * np.arange(around) / around
    r, y = np.sin(polar)[:, None], np.cos(polar)[:, None]
    belt = np.stack([r * np.cos(turn), y + 0 * turn, -r * np.sin(turn)], axis=-1)
    points = np.concatenate([[[0, 1, 0], [0, -1, 0]], belt.reshape(-1, 3)])
    j = np.arange(around)
    at = lambda i: 2 + (i - 1) * around + j % around
    after = lambda i: 2 + (i - 1) * around + (j + 1) % around
    faces = [np.stack([0 * j, at(1), after(1)], axis=-1)]
    for i in range(1, rings - 1):
        a, b, c, d = at(i), at(i + 1), after(i + 1), after(i)
        faces += [np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)]
    faces.append(np.stack([0 * j + 1, after(rings - 1), at(rings - 1)], axis=-1))
    return points, np.concatenate(faces)


def fastest(work, rounds):
    best = float("inf")
    for _ in range(rounds):
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
    return best * 1e3


def planes():
    """Origin and normal, pointing out, of the one plane and of the six of the box."""
    one = [([n * OFFSET / sum(v * v for v in NORMAL) for n in NORMAL], NORMAL)]
    box = []
    for axis in range(3):
        for sign, corner in ((-1, LOW), (1, HIGH)):
            box.append((list(corner), [sign * (a == axis) for a in range(3)]))
    return one, box


def peers(np):
    import pyvista
    import trimesh
    import vtk

    points, faces = sphere(np)
    one, box = planes()
    mesh = trimesh.Trimesh(points, faces, process=False)
    poly = pyvista.PolyData.from_regular_faces(points, faces)

    def slice_plane(which, cap):
        origins, normals = ([list(v) for v in zip(*which)])
        return lambda: mesh.slice_plane(origins, [[-v for v in n] for n in normals], cap=cap)

    def clip(which):
        def run():
            left = poly
            for origin, normal in which:
                left = left.clip(normal=normal, origin=origin)
        return run

    def closed_surface(which):
        def run():
            collection = vtk.vtkPlaneCollection()
            for origin, normal in which:
                plane = vtk.vtkPlane()
                plane.SetOrigin(origin)
                plane.SetNormal([-v for v in normal])
                collection.AddItem(plane)
            clipper = vtk.vtkClipClosedSurface()
            clipper.SetInputData(poly)
            clipper.SetClippingPlanes(collection)
            clipper.Update()
        return run

    return len(faces), [
        ("cut/plane/open", "trimesh slice_plane", slice_plane(one, False), 3, 20),
        ("cut/plane/open", "pyvista clip", clip(one), 3, 20),
        ("cut/plane/capped", "vtkClipClosedSurface", closed_surface(one), 3, 4),
        ("cut/plane/capped", "trimesh slice_plane, cap", slice_plane(one, True), 2, None),
        ("cut/box/open", "trimesh slice_plane", slice_plane(box, False), 2, None),
        ("cut/box/open", "pyvista clip, six times", clip(box), 2, None),
        ("cut/box/capped", "vtkClipClosedSurface", closed_surface(box), 2, 35),
    ]


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: cut_python.py PATH_TO_CULLET (target/release/cullet)")
    enter_environment()
    import numpy as np

    bench = [sys.argv[1], "bench", "cut", "--json", "-"]
    rows = json.loads(subprocess.run(bench, check=True, stdout=subprocess.PIPE).stdout)
    ours = {}
    for row in rows["results"]:
        if not row["checked"]:
            sys.exit(f"{row['name']}: a wrong answer")
        ours[row["name"].rsplit("/", 1)[0]] = row["ns_per_item"] * row["items"] / 1e6
    triangles, work = peers(np)
    print(f"{triangles:,} triangles; ms, the fastest of a few")
    print(f"{'cut':18} {'cullet':>8}  {'peer':26} {'ms':>8} {'times':>6}  wanted")
    for name, peer, run, rounds, wanted in work:
        try:
            took = fastest(run, rounds)
        except Exception as error:  # A peer that fails is told, and the rest goes on.
            print(f"{name:18} {ours[name]:8.1f}  {peer:26} failed: {error}")
            continue
        print(
            f"{name:18} {ours[name]:8.1f}  {peer:26} {took:8.1f} {took / ours[name]:6.1f}"
            f"  {wanted or '-'}",
            flush=True,
        )


if __name__ == "__main__":
    main()
