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
from ._worker import Behind, Items, NeedsScene, Round, Share, Unit, run_unit


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
        bake = _Bake(plan, engine, _native.UnitFolder(path), path, units, threads, retries, progress or (lambda share: None))
        return bake.run()


def _is_last(job: _native.Job) -> bool:
    """Whether no round is expected after the one that is next. One that is none all the same does no harm if it was begun, and one
    that is begins a little later if it was not."""
    return job.shares[1] >= 1


class _Bake:
    def __init__(
        self,
        plan: Plan,
        engine: Engine,
        kept: _native.UnitFolder,
        folder: str,
        units: int | None,
        threads: int,
        retries: int,
        progress: Callable[[float], None],
    ) -> None:
        self.plan, self.engine, self.kept, self.folder = plan, engine, kept, folder
        self.units, self.threads, self.retries, self.tell = units, threads, retries, progress
        self.told = 0.0
        self.key = plan.key
        # Handles of what each round found, and of the scene.
        self.rounds: list[Any] = []
        self.scene: Any = None

    def run(self) -> _native.Made:
        # Workers open the scene and end rounds while the driver does.
        ahead = self.ahead(0)
        try:
            job = _native.Job(self.plan.text, self.plan.scene, self.threads)
            while not job.is_done:
                running, ahead = ahead, []
                found = self.round(job, running)
                # Those who run the next round know all before it, but for who comes late.
                self.rounds.append(self.engine.share(found))
                ahead = [] if _is_last(job) else self.ahead(job.round + 1)
                job.merge(list(found))
        except BaseException:
            self.engine.cancel([handle for handle, _ in ahead])
            raise
        self.progress(1.0)
        return job.finish()

    def ahead(self, number: int) -> list[tuple[Any, Items | Share]]:
        """Begins a round of which nothing lies in the folder, before it is known which items it has."""
        if self.kept.units(self.key, number):
            return []
        count = self.count()
        shares = [Share(k, count) for k in range(count)]
        return [(self.submit(share, number), share) for share in shares]

    def count(self) -> int:
        """Units of a round."""
        return self.units or 4 * self.engine.workers()

    def round(self, job: _native.Job, running: list[tuple[Any, Items | Share]]) -> Round:
        """Runs what the folder lacks of a round, or goes on with what runs of it; all that it found."""
        number, (begin, end) = job.round, job.shares
        have: dict[Items, bytes] = {}
        if running:
            _, one = running[0]
            assert isinstance(one, Share)
            wanted = job.missing([], one.of)
        else:
            have = self.whole(job)
            wanted = job.missing(list(have), self.count())
            running = [(self.submit(items, number), items) for items in wanted]
        count = len(have) + len(wanted)

        def items_of(what: Items | Share) -> Items | None:
            if not isinstance(what, Share):
                return what
            return wanted[what.number] if what.number < len(wanted) else None

        def take(what: Items | Share, answer: Any) -> bool:
            if isinstance(answer, (Behind, NeedsScene)):
                return False
            items = items_of(what)
            if items is None:
                return True
            if not isinstance(answer, Unit) or answer.items != items or not job.is_whole(items, answer.found):
                raise ValueError("what came back is damaged")
            self.kept.write(self.key, number, items, answer.found)
            have[items] = answer.found
            self.progress(begin + (end - begin) * len(have) / count)
            return True

        def submit(what: Items | Share, answer: Any) -> Any:
            return self.submit(what, number, answer)

        raised = gather(self.engine, running, submit, take, self.retries)
        failed = {items: error for what, error in raised.items() if (items := items_of(what)) is not None}
        if failed:
            raise UnitsFailed(number, failed, self.folder)
        return tuple(sorted(have.items()))

    def progress(self, share: float) -> None:
        # What a round costs is an estimate until it has ended.
        self.told = max(self.told, share)
        self.tell(self.told)

    def submit(self, what: Items | Share, number: int, answer: Any = None) -> Any:
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
            run_unit, plan.text, plan.scene, plan.content, what, number, self.threads, first, handed, *rounds
        )

    def whole(self, job: _native.Job) -> dict[Items, bytes]:
        """The units of a round that lie in the folder and are whole, end to end."""
        there = {}
        for items in self.kept.units(self.key, job.round):
            found = self.kept.read(self.key, job.round, items)
            if found is not None and items[0] < items[1] and job.is_whole(items, found):
                there[items] = found
        return {items: there[items] for items in job.tiles(list(there))}
