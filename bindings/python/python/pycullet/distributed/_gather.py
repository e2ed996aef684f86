"""Tasks on an engine until each has given what is wanted of it, or failed too often."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from ._engines import Engine

Unit = TypeVar("Unit")

# How long an engine is waited for before Ctrl-C is looked at.
_LOOK = 0.5


def gather(
    engine: Engine,
    running: list[tuple[Any, Unit]],
    submit: Callable[[Unit, Any], Any],
    take: Callable[[Unit, Any], bool],
    retries: int,
) -> dict[Unit, BaseException]:
    """Takes what submitted units give; what each raised at last that failed more than ``retries`` times.

    ``running`` has the engine's handle of each unit. ``submit`` submits one again and gives its handle; its second argument is
    what the unit gave before, if ``take`` said that this is not what is wanted. What ``take`` raises of a unit's answer by
    `ValueError` counts as a failure of the unit; any other error ends all, and cancels what runs.
    """
    failed: dict[Unit, BaseException] = {}
    # Not every engine's handles can be hashed.
    running = list(running)
    tries = {unit: 0 for _, unit in running}
    try:
        while running:
            for handle in engine.ended([handle for handle, _ in running], _LOOK):
                place = next(k for k, (other, _) in enumerate(running) if other is handle or other == handle)
                _, unit = running.pop(place)
                answer: Any = None
                error: BaseException | None = None
                try:
                    answer = engine.result(handle)
                except Exception as raised:
                    error = raised
                is_taken = False
                if error is None:
                    try:
                        is_taken = take(unit, answer)
                    except ValueError as raised:
                        error, answer = raised, None
                if error is not None:
                    tries[unit] += 1
                    if tries[unit] > retries:
                        failed[unit] = error
                        continue
                if not is_taken:
                    running.append((submit(unit, answer), unit))
    except BaseException:
        engine.cancel([handle for handle, _ in running])
        raise
    return failed
