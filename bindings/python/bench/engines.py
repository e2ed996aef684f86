"""The same bake by one process, by two, on Dask and on Ray with two nodes each; and once more with one lost in the middle.

    python bench/engines.py FILE [--view-cells N --rays N] [--units N] [--turns N]

The package must be built with `--release`, with its extras `ray` and `dask`. Prints a table; every row's bytes are held against the first's.
"""

from __future__ import annotations

import argparse
import hashlib
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cullet
from cullet import _native, distributed

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
import test_distributed as tests  # noqa: E402


def plain(plan: distributed.Plan, units: int) -> tuple[float, bytes, int]:
    """The bake without any adapter: the same units, one after the other, by a job in this process."""
    begin = time.monotonic()
    job = _native.Job(plan.text, plan.scene)
    count = 0
    while not job.is_done:
        found = [(items, job.run(items)) for items in job.missing([], units)]
        count += len(found)
        job.merge(found)
    return time.monotonic() - begin, job.finish().sets, count


@contextmanager
def one_process() -> Iterator[tests.Cluster]:
    engine = distributed.Processes(1)
    yield tests.Cluster(engine, lambda: None, lambda: None)
    engine.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file")
    parser.add_argument("--view-cells", type=int)
    parser.add_argument("--rays", type=int)
    parser.add_argument("--units", type=int, default=8)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--engines", default="one,processes,dask,ray")
    options = parser.parse_args()
    plan = distributed.plan(options.file, view_cells=options.view_cells, rays=options.rays)
    engines: dict[str, tuple[str, Callable[[], Any]]] = {
        "one": ("one process", one_process),
        "processes": ("two processes", contextmanager(tests._on_processes)),
        "dask": ("Dask, two nodes", contextmanager(tests._on_dask)),
        "ray": ("Ray, two nodes", contextmanager(tests._on_ray)),
    }
    rows: dict[str, list[float]] = {}
    expected = None
    for turn in range(options.turns):
        took, sets, count = plain(plan, options.units)
        expected = expected or sets
        assert sets == expected
        rows.setdefault("no adapter, one thread", []).append(took)
        for name in options.engines.split(","):
            words, make = engines[name]
            for loss in (False, True) if name != "one" else (False,):
                with make() as cluster:
                    # What a first unit costs a worker beside the bake: its interpreter, and the scene.
                    warm = distributed.plan("city:objects=20", view_cells=2, rays=1000)
                    distributed.run(warm, cluster.engine)
                    lost: list[float] = []

                    def progress(share: float) -> None:
                        if loss and share >= 0.5 and not lost:
                            lost.append(time.monotonic())
                            cluster.kill_node()

                    begin = time.monotonic()
                    made = distributed.run(plan, cluster.engine, units=options.units, progress=progress)
                    took = time.monotonic() - begin
                    assert made.sets == expected, words
                    assert bool(lost) == loss
                    rows.setdefault(words + (", one lost in the middle" if loss else ""), []).append(took)
    first = statistics.median(rows["no adapter, one thread"])
    digest = hashlib.sha256(expected or b"").hexdigest()[:12]
    print(f"cullet {cullet.__version__}: {options.file}, {count} units of {first / count:.2f} s in the mean, {made.cells} cells; sets {digest}")
    print(f"{'':<42}{'seconds':>9}{'times as fast':>15}{'after the loss':>16}")
    for words, took in rows.items():
        seconds = statistics.median(took)
        base = words.removesuffix(", one lost in the middle")
        ratio = f"{seconds / statistics.median(rows[base]):.2f}" if base != words else ""
        print(f"{words:<42}{seconds:>9.2f}{first / seconds:>15.2f}{ratio:>16}")


# Processes that are started import this.
if __name__ == "__main__":
    main()
