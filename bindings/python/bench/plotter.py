"""Frames of a pyvista plotter with culling and without, by turns, while the camera turns by 2 degrees a
frame.

    python bench/plotter.py [--blocks] [side of the city, 50 unless given] [samples a pixel, 4 unless given]

With ``--blocks`` the houses are blocks of one composite actor.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
import pyvista

import pycullet.pyvista

FRAMES = 40


def city(side: int, as_blocks: bool, samples: int = 4) -> Any:
    plotter = pyvista.Plotter(off_screen=True, window_size=(640, 400))
    plotter.render_window.SetMultiSamples(samples if samples > 1 else 0)
    random = np.random.default_rng(5)
    houses = pyvista.MultiBlock()
    for at in range(side * side):
        height = random.uniform(2, 9)
        centre = (at // side * 1.6, at % side * 1.6, height / 2)
        house = pyvista.Cube(center=centre, x_length=1, y_length=1, z_length=height)
        if as_blocks:
            houses.append(house)
        else:
            plotter.add_mesh(house, color=random.random(3), render=False)
    if as_blocks:
        plotter.add_composite(houses)
    middle = (side // 2 - 0.5) * 1.6
    plotter.camera_position = [(middle, middle, 1.5), (middle, middle + 9, 2), (0, 0, 1)]
    plotter.camera.clipping_range = (0.1, side * 4)
    return plotter


def main() -> None:
    words = [word for word in sys.argv[1:] if word != "--blocks"]
    side = int(words[0]) if words else 50
    samples = int(words[1]) if len(words) > 1 else 4
    plain, culled = (city(side, "--blocks" in sys.argv, samples) for _ in range(2))
    hook = pycullet.pyvista.attach(culled)
    times: dict[str, list[float]] = {"plain": [], "culled": []}
    kept = []
    for frame in range(FRAMES + 1):
        for name, plotter in (("plain", plain), ("culled", culled)):
            plotter.camera.view_angle = 50
            plotter.camera.Yaw(2)
            start = time.perf_counter()
            plotter.render() if frame else plotter.show(auto_close=False)
            took = time.perf_counter() - start
            # The first one of each uploads everything it draws.
            if frame:
                times[name].append(took)
            else:
                print(f"first frame, {name}: {took:.2f} s")
        kept.append(hook.renders[0].shown - hook.renders[0].culled)
        same = np.array_equal(plain.screenshot(return_img=True), culled.screenshot(return_img=True))
        assert same, f"frame {frame} differs"
    middle = {name: float(np.median(own)) for name, own in times.items()}
    print(f"{side * side} houses, {np.median(kept):.0f} drawn: {1e3 * middle['plain']:.0f} ms, {1e3 * middle['culled']:.0f} ms with culling,")
    print(f"{middle['plain'] / middle['culled']:.1f} times as fast; slowest {1e3 * max(times['culled']):.0f} ms")


if __name__ == "__main__":
    main()
