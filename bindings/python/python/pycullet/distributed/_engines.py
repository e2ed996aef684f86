"""Where units run: in this process, in others, on Ray and on Dask, all alike to the driver."""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import os
import pickle
import tempfile
import time
import weakref
from collections.abc import Callable, Iterator
from concurrent import futures
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol


class Engine(Protocol):
    """What a driver needs of an engine. Handles are the engine's own."""

    def workers(self) -> int:
        """How many units may run at once, now."""

    def share(self, value: Any) -> Any:
        """Hands a value over once; the handle stands for it as an argument of `submit`."""

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Any:
        """Begins a task and gives its handle."""

    def ended(self, handles: list[Any], seconds: float) -> list[Any]:
        """Those that have ended, once one has, or none after so many seconds."""

    def result(self, handle: Any) -> Any:
        """What an ended task gave; raises what it raised, and an error of the engine where its worker was lost."""

    def cancel(self, handles: list[Any]) -> None:
        """Ends tasks, as far as the engine can."""

    def close(self) -> None:
        """Gives back what it holds."""


class Here:
    """This process: one unit at a time."""

    def workers(self) -> int:
        """How many units may run at once, now."""
        return 1

    def share(self, value: Any) -> Any:
        """Hands a value over once."""
        return value

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Any:
        """Begins a task and gives its handle."""
        # Run when it is waited for, so that what ended before is kept before the next begins.
        return [task, arguments, None]

    def ended(self, handles: list[Any], seconds: float) -> list[Any]:
        """Those that have ended, once one has, or none after so many seconds."""
        task, arguments, _ = handles[0]
        done: futures.Future[Any] = futures.Future()
        try:
            done.set_result(task(*arguments))
        except Exception as error:
            done.set_exception(error)
        handles[0][2] = done
        return [handles[0]]

    def result(self, handle: Any) -> Any:
        """What an ended task gave."""
        return handle[2].result()

    def cancel(self, handles: list[Any]) -> None:
        """Ends tasks, as far as the engine can."""
        pass

    def close(self) -> None:
        """Gives back what it holds."""
        pass


@dataclass(frozen=True)
class _Place:
    """Where the file of a value is."""

    path: str


class _Filed:
    """A value in a file of this machine, which goes with it: through a pipe it would be sent once for each unit."""

    def __init__(self, folder: str, value: Any) -> None:
        handle, path = tempfile.mkstemp(dir=folder)
        with os.fdopen(handle, "wb") as file:
            pickle.dump(value, file, pickle.HIGHEST_PROTOCOL)
        self.place = _Place(path)
        weakref.finalize(self, _remove, path)


def _remove(path: str) -> None:
    with contextlib.suppress(OSError):
        os.unlink(path)


# What this process read last: most of its units are handed the same.
_last: tuple[_Place | None, Any] = (None, None)


def _read(place: _Place) -> Any:
    global _last
    if _last[0] != place:
        # Before the next, that both need not be in memory.
        _last = (None, None)
        _last = (place, pickle.loads(Path(place.path).read_bytes()))
    return _last[1]


def _with_values(task: Callable[..., Any], *arguments: Any) -> Any:
    return task(*[_read(a) if isinstance(a, _Place) else a for a in arguments])


class Processes:
    """Other processes on this machine; as many as it has processors, unless told. A lost one is replaced."""

    def __init__(self, count: int | None = None) -> None:
        self._count = count or os.cpu_count() or 1
        if self._count < 1:
            raise ValueError(f"{self._count} processes; at least 1 is needed")
        self._pool: futures.ProcessPoolExecutor | None = None
        self._folder = tempfile.TemporaryDirectory(prefix="cullet-handed-", ignore_cleanup_errors=True)

    def workers(self) -> int:
        """How many units may run at once, now."""
        return self._count

    def share(self, value: Any) -> Any:
        """Hands a value over once."""
        return _Filed(self._folder.name, value)

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Any:
        """Begins a task and gives its handle."""
        given = [a.place if isinstance(a, _Filed) else a for a in arguments]
        for _ in range(2):
            if self._pool is None:
                # Begun anew, not forked: a fork would hold the locks of threads that it does not have.
                spawn = multiprocessing.get_context("spawn")
                self._pool = futures.ProcessPoolExecutor(self._count, mp_context=spawn)
            try:
                return self._pool.submit(_with_values, task, *given)
            except futures.process.BrokenProcessPool:
                self._pool.shutdown(wait=False)
                self._pool = None
        raise RuntimeError("processes end as soon as they begin")

    def ended(self, handles: list[Any], seconds: float) -> list[Any]:
        """Those that have ended, once one has, or none after so many seconds."""
        done, _ = futures.wait(handles, seconds, futures.FIRST_COMPLETED)
        return list(done)

    def result(self, handle: Any) -> Any:
        """What an ended task gave."""
        return handle.result()

    def cancel(self, handles: list[Any]) -> None:
        """Ends tasks, as far as the engine can."""
        for handle in handles:
            handle.cancel()
        self._kill()

    def close(self) -> None:
        """Gives back what it holds."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None
        self._folder.cleanup()

    def _kill(self) -> None:
        if self._pool is not None:
            # A unit has no end of its own before it is done.
            for process in list((self._pool._processes or {}).values()):
                process.kill()
            self._pool.shutdown(wait=False, cancel_futures=True)
            self._pool = None


class Ray:
    """A Ray cluster: at an address, or one that is started on this machine. Needs ``pycullet[ray]``.

    Ray refuses 127.0.0.1; give the address that ``ray start`` prints. Its own repetition of tasks is switched off, for the driver
    repeats what was lost on every engine alike.
    """

    def __init__(self, address: str | None = None, *, cpus: float = 1) -> None:
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        import ray

        self._ray = ray
        self._started = not ray.is_initialized()
        if self._started:
            ray.init(address=address, log_to_driver=False, logging_level="error", configure_logging=False)
        self._cpus = cpus
        self._tasks: dict[Callable[..., Any], Any] = {}

    def workers(self) -> int:
        """How many units may run at once, now."""
        cpus = float(self._ray.cluster_resources().get("CPU", 1))
        return max(1, int(cpus / self._cpus))

    def share(self, value: Any) -> Any:
        """Hands a value over once."""
        return self._ray.put(value)

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Any:
        """Begins a task and gives its handle."""
        if task not in self._tasks:
            # Else all go where what was found in the last round lies.
            remote = self._ray.remote(num_cpus=self._cpus, max_retries=0, scheduling_strategy="SPREAD")
            self._tasks[task] = remote(task)
        return self._tasks[task].remote(*arguments)

    def ended(self, handles: list[Any], seconds: float) -> list[Any]:
        """Those that have ended, once one has, or none after so many seconds."""
        done, _ = self._ray.wait(handles, num_returns=1, timeout=seconds, fetch_local=False)
        return list(done)

    def result(self, handle: Any) -> Any:
        """What an ended task gave."""
        return self._ray.get(handle)

    def cancel(self, handles: list[Any]) -> None:
        """Ends tasks, as far as the engine can."""
        for handle in handles:
            self._ray.cancel(handle, force=True)

    def close(self) -> None:
        """Gives back what it holds."""
        if self._started:
            self._ray.shutdown()


class Dask:
    """A Dask cluster: at the address of its scheduler, a ``distributed.Client``, or workers started on this machine.

    Needs ``pycullet[dask]``.
    """

    def __init__(self, address: Any = None) -> None:
        import distributed

        self._distributed = distributed
        self._own = not isinstance(address, distributed.Client)
        if not self._own:
            self._client = address
        elif address is None:
            self._client = distributed.Client(threads_per_worker=1, dashboard_address=None)
        else:
            self._client = distributed.Client(address)
        # The threads of the workers by their addresses, and the one that was preferred last.
        self._threads: list[str] = []
        self._turn = 0

    def workers(self) -> int:
        """How many units may run at once, now."""
        threads: dict[str, int] = self._client.nthreads()
        most = max(threads.values(), default=0)
        self._threads = [address for k in range(most) for address, count in sorted(threads.items()) if k < count]
        return max(1, len(self._threads))

    def share(self, value: Any) -> Any:
        """Hands a value over once."""
        return _Kept(self._client, value)

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Any:
        """Begins a task and gives its handle."""
        given = [a.future() if isinstance(a, _Kept) else a for a in arguments]
        if not self._threads:
            self.workers()
        # Else all go where what was found in the last round lies. A worker that is gone or busy leaves its tasks to others.
        where: dict[str, Any] = {}
        if self._threads:
            self._turn = (self._turn + 1) % len(self._threads)
            where = {"workers": [self._threads[self._turn]], "allow_other_workers": True}
        return self._client.submit(task, *given, pure=False, **where)

    def ended(self, handles: list[Any], seconds: float) -> list[Any]:
        """Those that have ended, once one has, or none after so many seconds."""
        try:
            done = self._distributed.wait(handles, timeout=seconds, return_when="FIRST_COMPLETED").done
        except (TimeoutError, self._distributed.TimeoutError):
            return []
        except _CANCELLED:
            # What was handed over lay on a node that is gone, and all that waits for it goes with it.
            return [handle for handle in handles if handle.status != "pending"]
        return list(done)

    def result(self, handle: Any) -> Any:
        """What an ended task gave."""
        try:
            return handle.result()
        except _CANCELLED as error:
            raise RuntimeError("lost with a node that had what it needs") from error

    def cancel(self, handles: list[Any]) -> None:
        """Ends tasks, as far as the engine can."""
        with contextlib.suppress(Exception):
            self._client.cancel(handles, force=True)

    def close(self) -> None:
        """Gives back what it holds."""
        if self._own:
            self._client.close()


# The interpreter has two of the name, one of which is no Exception.
_CANCELLED = (asyncio.CancelledError, futures.CancelledError)


class _Kept:
    """A value on a Dask cluster, which is sent again where the node that had it is gone."""

    def __init__(self, client: Any, value: Any) -> None:
        self._client, self._value = client, value
        self._future: Any = None

    def future(self) -> Any:
        if self._future is None or self._future.status != "finished":
            self._future = self._sent()
        return self._future

    def _sent(self) -> Any:
        # To one node, from which the others fetch it: sent to all at once, it would be waited for without end if one is lost meanwhile.
        for is_last in (False, False, False, True):
            try:
                # In a list, for the parts of a tuple would be sent one by one.
                (sent,) = self._client.scatter([self._value], hash=False)
                return sent
            except Exception:
                # The node may have been lost that it was to go to.
                if is_last:
                    raise
                time.sleep(0.5)


@contextlib.contextmanager
def opened(engine: Engine | None) -> Iterator[Engine]:
    """An engine that is given, and stays its giver's; or this process."""
    yield Here() if engine is None else engine
