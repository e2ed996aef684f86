"""Any command of ``cullet`` that works in units, its shares run on an engine."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Sequence
from typing import Any

from ._engines import Engine, Here
from ._gather import gather

# What a share says by its exit code: all is well, or what it looked at is not.
_DONE = (0, 1)


class SharesFailed(RuntimeError):
    """Shares of a command failed each time that they were tried. All others are finished and kept."""

    def __init__(self, shares: int, failed: dict[int, BaseException], folder: str) -> None:
        self.failed = failed
        """What each share raised at last, by its number from 1."""
        list_of = "; ".join(f"share {share}: {error}" for share, error in sorted(failed.items()))
        super().__init__(
            f"{len(failed)} of {shares} shares failed each time: {list_of}. The others are kept in {folder}: the same command "
            "goes on from there"
        )


def run_share(command: Sequence[str], folder: str, share: int, shares: int) -> bool:
    """Runs one share of a command where it is called."""
    words = [*command, "--quiet", "--unit", f"{share}/{shares}", "--units", folder]
    try:
        done = subprocess.run(words, capture_output=True, text=True, check=False)
    except FileNotFoundError as error:
        raise RuntimeError(f"{words[0]}: there is no such program on {os.uname().nodename}") from error
    if done.returncode not in _DONE:
        said = (done.stderr.strip() or done.stdout.strip())[-500:]
        raise RuntimeError(f"{words[0]} ended with {done.returncode}: {said}")
    return True


def run_command(
    command: Sequence[str],
    engine: Engine | None = None,
    *,
    folder: str | os.PathLike[str],
    shares: int | None = None,
    retries: int = 3,
    progress: Callable[[float], None] | None = None,
) -> int:
    """Runs a command in shares, four a worker unless given, and joins them here; gives the exit code of the last.

    ``command`` is one of ``cullet bake``, ``cullet verify``, ``cullet report`` and ``cullet pvs`` with what follows it, without ``--unit``.
    ``folder`` must be seen by all nodes, by the same name, as the files that the command names. A share that is lost or fails is
    run again, up to ``retries`` times; then the others are finished, and `SharesFailed` names it.
    """
    engine = engine or Here()
    path = os.fspath(folder)
    count = shares or 4 * engine.workers()
    done: list[int] = []

    def submit(share: int, answer: Any = None) -> Any:
        return engine.submit(run_share, list(command), path, share, count)

    def take(share: int, answer: Any) -> bool:
        done.append(share)
        if progress:
            progress(len(done) / count)
        return True

    running = [(submit(share), share) for share in range(1, count + 1)]
    failed = gather(engine, running, submit, take, retries)
    if failed:
        raise SharesFailed(count, failed, path)
    return subprocess.run([*command, "--resume", "--units", path], check=False).returncode
