"""Rounds of units on an engine, what is finished kept in a folder, and the end joined from it."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .. import _native
from ._engines import Engine, Here
from ._gather import gather
from ._plan import Plan
from ._worker import Behind, Items, NeedsScene, run_unit


class UnitsFailed(RuntimeError):
    """Units failed each time that they were tried. All others of their round are finished and kept."""

    def __init__(self, round: int, failed: dict[Items, BaseException], folder: str) -> None:
        self.round = round
        """The round."""
        self.failed = failed
        """What each unit raised at last."""
        list_of = "; ".join(f"items {a} to {b}: {type(e).__name__}: {e}" for (a, b), e in failed.items())
        super().__init__(
            f"{len(failed)} of the units of round {round} failed each time: {list_of}. The others are kept in {folder}: "
            "the same command goes on from there"
        )


@contextmanager
def _folder_of(folder: str | os.PathLike[str] | None) -> Iterator[str]:
    if folder is not None:
        yield os.fspath(folder)
        return
    with tempfile.TemporaryDirectory(prefix="cullet-units-") as made:
        yield made


def run(
    plan: Plan,
    engine: Engine | None = None,
    *,
    folder: str | os.PathLike[str] | None = None,
    units: int | None = None,
    threads: int = 1,
    retries: int = 3,
    progress: Callable[[float], None] | None = None,
) -> _native.Made:
    """Bakes a plan and gives what was made: the same bytes on every engine.

    ``engine`` is `Here` unless given. Finished units are kept in ``folder``, so that the same call goes on after Ctrl-C or the loss
    of the driver, and ``cullet pvs --resume --units FOLDER`` too; without it in one that goes with the call. Each round is cut into ``units`` of even cost,
    four a worker unless given, each run on ``threads``. ``progress`` is called with the share that is over, 0 to 1.

    A unit that is lost or raises is run again, up to ``retries`` times; then the rest of its round is finished, and `UnitsFailed`
    names it. `OSError` is raised where a unit cannot be kept.
    """
    engine = engine or Here()
    with _folder_of(folder) as path:
        kept = _native.UnitFolder(path)
        job = _native.Job(plan.text, plan.scene, threads)
        bake = _Bake(plan, engine, job, kept, path, threads, retries, progress or (lambda share: None))
        while not job.is_done:
            bake.round(units)
        bake.progress(1.0)
        return job.finish()


class _Bake:
    def __init__(
        self,
        plan: Plan,
        engine: Engine,
        job: _native.Job,
        kept: _native.UnitFolder,
        folder: str,
        threads: int,
        retries: int,
        progress: Callable[[float], None],
    ) -> None:
        self.plan, self.engine, self.job, self.kept, self.folder = plan, engine, job, kept, folder
        self.threads, self.retries, self.tell = threads, retries, progress
        self.told = 0.0
        self.key = job.key
        # Handles of what each round found, and of the scene.
        self.rounds: list[Any] = []
        self.scene: Any = None

    def round(self, units: int | None) -> None:
        """Runs what the folder lacks of a round, and ends it."""
        number, (begin, end) = self.job.round, self.job.shares
        have = self.whole(number)
        wanted = self.job.missing(list(have), units or 4 * self.engine.workers())
        count = len(have) + len(wanted)

        def take(items: Items, found: Any) -> bool:
            if not isinstance(found, bytes):
                return False
            if not self.job.is_whole(items, found):
                raise ValueError("what came back is damaged")
            self.kept.write(self.key, number, items, found)
            have[items] = found
            self.progress(begin + (end - begin) * len(have) / count)
            return True

        def submit(items: Items, answer: Any) -> Any:
            return self.submit(items, number, answer)

        failed = gather(self.engine, wanted, submit, take, self.retries)
        if failed:
            raise UnitsFailed(number, failed, self.folder)
        found = tuple(sorted(have.items()))
        self.job.merge(list(found))
        # Those who run the next round know all before it, but for who comes late.
        self.rounds.append(self.engine.share(found))

    def progress(self, share: float) -> None:
        # What a round costs is an estimate until it has ended.
        self.told = max(self.told, share)
        self.tell(self.told)

    def submit(self, items: Items, number: int, answer: Any) -> Any:
        first = max(0, number - 1)
        if isinstance(answer, Behind):
            first = answer.round
        handed = None
        if isinstance(answer, NeedsScene):
            if self.scene is None:
                self.scene = self.engine.share(Path(self.plan.scene).read_bytes())
            handed = self.scene
        rounds = self.rounds[first:number]
        plan = self.plan
        return self.engine.submit(
            run_unit, plan.text, plan.scene, plan.content, items, number, self.threads, first, handed, *rounds
        )

    def whole(self, number: int) -> dict[Items, bytes]:
        """The units of a round that lie in the folder and are whole, end to end."""
        there = {}
        for items in self.kept.units(self.key, number):
            found = self.kept.read(self.key, number, items)
            if found is not None and items[0] < items[1] and self.job.is_whole(items, found):
                there[items] = found
        return {items: there[items] for items in self.job.tiles(list(there))}
