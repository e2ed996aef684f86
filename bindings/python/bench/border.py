"""What the border costs: `scene.cull(camera).visible` against the same work in Rust, turn by turn in one run.

    cargo build --release -p cullet-python --example python_border
    python bench/border.py target/release/examples/python_border

The package must be built with `--release` too.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import time

import numpy as np

import pycullet

RUNS, TURNS = 200, 15


def views(scene: pycullet.Scene) -> dict[str, pycullet.Camera]:
    size = (1280, 720)
    return {
        "street": pycullet.Camera.look_at((5, 1.7, 40), (5, 1.7, 0), size=size, far=4000),
        "from above": pycullet.Camera.look_at((0, 250, 900), (0, 0, 0), size=size, far=4000),
        "all of it": pycullet.Camera.look_at((0, 1500, 2600), (0, 0, 0), size=size, far=8000),
    }


def main(program: str) -> None:
    spec = "city"
    scene = pycullet.Scene.builtin(spec)
    print(f"{scene.instance_count} instances; medians of {TURNS} turns of {RUNS} culls each, in microseconds")
    print(f"{'view':<12}{'visible':>9}{'Rust':>9}{'Python':>9}{'ratio':>8}")
    for name, camera in views(scene).items():
        matrix = [repr(float(v)) for v in camera.clip_from_world.T.ravel()]
        words = [program, spec, *map(str, camera.size), *matrix]
        peer = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert peer.stdin and peer.stdout
        rust, python = [], []
        visible = scene.cull(camera).visible
        for _ in range(TURNS):
            peer.stdin.write(f"{RUNS}\n")
            peer.stdin.flush()
            nanoseconds, count, total = map(int, peer.stdout.readline().split())
            assert (count, total) == (len(visible), int(visible.sum(dtype=np.uint64)))
            rust.append(nanoseconds / 1e3)
            times = []
            for _ in range(RUNS):
                begin = time.perf_counter_ns()
                visible = scene.cull(camera).visible
                times.append(time.perf_counter_ns() - begin)
            python.append(statistics.median(times) / 1e3)
        peer.stdin.close()
        peer.wait()
        a, b = statistics.median(rust), statistics.median(python)
        print(f"{name:<12}{len(visible):>9}{a:>9.1f}{b:>9.1f}{b / a:>8.3f}")


if __name__ == "__main__":
    main(sys.argv[1])
