"""What runs on a node: one unit, by a job that is held open from unit to unit."""

from __future__ import annotations

import hashlib
import os
import tempfile
import threading
from dataclasses import dataclass
from pathlib import Path

from .. import _native

Items = tuple[int, int]
Round = tuple[tuple[Items, bytes], ...]


@dataclass(frozen=True)
class Share:
    """One of the units into which a round is cut, by its number from 0: for who does not know yet which items those are."""

    number: int
    of: int


@dataclass(frozen=True)
class Unit:
    """A unit that was run: its items, and what they found."""

    items: Items
    found: bytes


@dataclass(frozen=True)
class Behind:
    """The node lacks what was found before this round: to be run again with all that was."""

    round: int


@dataclass(frozen=True)
class NeedsScene:
    """The node has no such file: to be run again with its bytes."""


@dataclass
class _Held:
    plan: str
    job: _native.Job


class _Here(threading.local):
    """One at a time, for scenes are large; and one a thread, for engines may run several in a process."""

    held: _Held | None = None


_here = _Here()


def run_unit(
    plan: str,
    scene: str,
    content: int | None,
    what: Items | Share,
    round: int,
    threads: int,
    first: int,
    handed: bytes | None,
    *rounds: Round,
) -> Unit | Behind | NeedsScene | None:
    """Runs a unit; None where the round has not so many. ``rounds`` is what was found in the rounds from ``first`` on; ``handed``
    the bytes of the scene."""
    held = _here.held
    if held is None or held.plan != plan or held.job.round > round:
        held = _here.held = None
        place = _place(scene, content, handed)
        if place is None:
            return NeedsScene()
        held = _here.held = _Held(plan, _native.Job(plan, place, threads))
    job = held.job
    for number, found in enumerate(rounds, first):
        if number == job.round:
            job.merge(list(found))
    if job.round < round:
        return Behind(job.round)
    if isinstance(what, Share):
        # None, too, where the round before was the last.
        units = job.missing([], what.of)
        if what.number >= len(units):
            return None
        what = units[what.number]
    return Unit(what, job.run(what, threads))


def _place(scene: str, content: int | None, handed: bytes | None) -> str | None:
    """Where the scene lies on this node."""
    if content is None:
        return scene
    if os.path.exists(scene) and _native.content_hash(scene) == content:
        return scene
    # Named by its content: all workers of a node find what the first has kept.
    user = hashlib.sha256(str(Path.home()).encode()).hexdigest()[:8]
    folder = Path(tempfile.gettempdir()) / f"cullet-scenes-{user}"
    kept = folder / f"{content:016x}{Path(scene).suffix}"
    if kept.exists() and _native.content_hash(str(kept)) == content:
        return str(kept)
    if handed is None:
        return None
    folder.mkdir(mode=0o700, exist_ok=True)
    handle, beside = tempfile.mkstemp(dir=folder)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(handed)
        os.replace(beside, kept)
    except BaseException:
        Path(beside).unlink(missing_ok=True)
        raise
    return str(kept)
