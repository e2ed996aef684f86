"""The same bake by one process, by two, on Dask and on Ray with two nodes each; and once more with one lost in the middle.

    python bench/engines.py FILE [--view-cells N --rays N] [--after RAYS] [--units N] [--turns N]

The package must be built with `--release`, with its extras `ray` and `dask`. Prints a table; every row's bytes are held against the first's.
Rounds grow with the rays before: with --after what so many rays find lies there when a run begins, and the clock runs from the end of
the first round that does not, so that workers hold all of it. So large units are measured within a short time.
"""

from __future__ import annotations

import argparse
import hashlib
import shutil
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pycullet
from pycullet import _native, distributed

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
import test_distributed as tests  # noqa: E402


@dataclass
class Plain:
    """The bake without any adapter."""

    seconds: float
    sets: bytes
    units: int
    begin: float
    """The share of the work that is over when the clock begins."""


def plain(plan: distributed.Plan, units: int, there: Path | None) -> Plain:
    """The same units, one after the other, by a job in this process."""
    start = time.monotonic()
    job = _native.Job(plan.text, plan.scene)
    kept = _native.UnitFolder(there) if there else None
    made, begin, is_first = 0, 0.0, there is not None
    while not job.is_done:
        have = job.tiles(kept.units(job.key, job.round)) if kept else []
        found = [(items, kept.read(job.key, job.round, items) or b"") for items in have] if kept else []
        missing = job.missing([items for items, _ in found], units)
        found += [(items, job.run(items)) for items in missing]
        made += len(missing)
        if is_first and missing:
            is_first, start, begin, made = False, time.monotonic(), job.shares[1], 0
        job.merge(found)
    return Plain(time.monotonic() - start, job.finish().sets, made, begin)


@dataclass
class Clock:
    """Times a run from the moment at which a share of it is over, and loses a node in the middle of what follows."""

    begin: float
    lose: Callable[[], None] | None
    start: float = field(default_factory=time.monotonic)

    def __post_init__(self) -> None:
        self.is_running = self.begin == 0

    def __call__(self, share: float) -> None:
        if not self.is_running and share >= self.begin:
            self.is_running, self.start = True, time.monotonic()
        if self.lose and share >= (1 + self.begin) / 2:
            self.lose()
            self.lose = None


@contextmanager
def one_process() -> Iterator[tests.Cluster]:
    engine = distributed.Processes(1)
    yield tests.Cluster(engine, lambda: None, lambda: None)
    engine.close()


ENGINES: dict[str, tuple[str, Callable[[], Any]]] = {
    "one": ("one process", one_process),
    "processes": ("two processes", contextmanager(tests._on_processes)),
    "dask": ("Dask, two nodes", contextmanager(tests._on_dask)),
    "ray": ("Ray, two nodes", contextmanager(tests._on_ray)),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file")
    parser.add_argument("--view-cells", type=int)
    parser.add_argument("--rays", type=int)
    parser.add_argument("--after", type=int, metavar="RAYS")
    parser.add_argument("--units", type=int, default=8)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--engines", default="one,processes,dask,ray")
    parser.add_argument("--no-loss", action="store_true", help="without the rows of a lost node")
    options = parser.parse_args()
    plan = distributed.plan(options.file, view_cells=options.view_cells, rays=options.rays)
    rows: dict[str, list[float]] = {}
    with tempfile.TemporaryDirectory(prefix="cullet-engines-") as folder:
        there = Path(folder) / "there" if options.after else None
        if there:
            before = distributed.plan(options.file, view_cells=options.view_cells, rays=options.after)
            engine = distributed.Processes()
            distributed.run(before, engine, folder=there)
            engine.close()
        for _ in range(options.turns):
            alone = plain(plan, options.units, there)
            rows.setdefault("no adapter, one thread", []).append(alone.seconds)
            for name in options.engines.split(","):
                words, make = ENGINES[name]
                for loss in (False, True) if name != "one" and not options.no_loss else (False,):
                    with make() as cluster:
                        # What a first unit costs a worker beside the bake: its interpreter.
                        warm = distributed.plan("city:objects=20", view_cells=2, rays=1000)
                        distributed.run(warm, cluster.engine)
                        clock = Clock(alone.begin, cluster.kill_node if loss else None)
                        kept = Path(folder) / "kept"
                        if there:
                            shutil.copytree(there, kept)
                        made = distributed.run(plan, cluster.engine, folder=kept, units=options.units, progress=clock)
                        took = time.monotonic() - clock.start
                        shutil.rmtree(kept)
                        assert made.sets == alone.sets, words
                        assert clock.is_running and clock.lose is None
                        rows.setdefault(words + (", one lost in the middle" if loss else ""), []).append(took)
    first = statistics.median(rows["no adapter, one thread"])
    digest = hashlib.sha256(alone.sets).hexdigest()[:12]
    mean = first / alone.units
    print(f"cullet {pycullet.__version__}: {options.file}, {alone.units} units of {mean:.2f} s in the mean; sets {digest}")
    print(f"{'':<42}{'seconds':>9}{'times as fast':>15}{'after the loss':>16}")
    for words, seconds in ((words, statistics.median(took)) for words, took in rows.items()):
        base = words.removesuffix(", one lost in the middle")
        ratio = f"{seconds / statistics.median(rows[base]):.2f}" if base != words else ""
        print(f"{words:<42}{seconds:>9.2f}{first / seconds:>15.2f}{ratio:>16}")


# Processes that are started import this.
if __name__ == "__main__":
    main()
