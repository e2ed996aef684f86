"""The same bytes on every engine, after every loss."""

from __future__ import annotations

import os
import resource
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from pycullet import FileError, _native, distributed
from pycullet.distributed import _driver, _worker

SCENE = "city:objects=150"
SETTINGS: dict[str, Any] = {"view_cells": 10, "heights": (0.5, 3.0), "rays": 400_000}


@pytest.fixture(scope="module")
def plan() -> distributed.Plan:
    return distributed.plan(SCENE, **SETTINGS)


@pytest.fixture(scope="module")
def expected(plan: distributed.Plan) -> bytes:
    return distributed.run(plan, units=1).sets


class Cluster:
    """An engine, and ways to hurt it."""

    def __init__(
        self, engine: distributed.Engine, kill_worker: Callable[[], None], kill_node: Callable[[], None]
    ) -> None:
        self.engine, self.kill_worker, self.kill_node = engine, kill_worker, kill_node


def _on_processes() -> Iterator[Cluster]:
    engine = distributed.Processes(2)

    def kill() -> None:
        assert engine._pool is not None
        os.kill(next(iter(engine._pool._processes)), signal.SIGKILL)

    yield Cluster(engine, kill, kill)
    engine.close()


def _on_dask() -> Iterator[Cluster]:
    pytest.importorskip("distributed")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    quiet: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "start_new_session": True}
    python = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1"]
    scheduler = subprocess.Popen([*python, "--port", str(port), "--no-dashboard"], **quiet)
    one = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard"]
    nodes = [subprocess.Popen(one, **quiet) for _ in range(2)]
    engine = distributed.Dask(address)
    try:
        engine._client.wait_for_workers(2, timeout=60)

        def kill_worker() -> None:
            # The nanny begins another.
            pid = next(iter(engine._client.run(os.getpid).values()))
            os.kill(pid, signal.SIGKILL)

        def kill_node() -> None:
            os.killpg(nodes[0].pid, signal.SIGKILL)

        yield Cluster(engine, kill_worker, kill_node)
    finally:
        engine.close()
        for process in [*nodes, scheduler]:
            try:
                os.killpg(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
            process.wait()


def _on_ray() -> Iterator[Cluster]:
    pytest.importorskip("ray")
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    from ray.cluster_utils import Cluster as RayCluster

    cluster = RayCluster(initialize_head=True, head_node_args={"num_cpus": 1, "object_store_memory": 100 << 20})
    second = cluster.add_node(num_cpus=1, object_store_memory=100 << 20)
    engine = distributed.Ray(cluster.address)
    try:
        cluster.wait_for_nodes()

        def kill_worker() -> None:
            import ray

            pid = ray.get(ray.remote(max_retries=0)(lambda: os.getpid()).remote())
            os.kill(pid, signal.SIGKILL)

        yield Cluster(engine, kill_worker, lambda: cluster.remove_node(second, allow_graceful=False))
    finally:
        engine.close()
        cluster.shutdown()


ENGINES = {"processes": _on_processes, "dask": _on_dask, "ray": _on_ray}


@contextmanager
def _at_most(seconds: int) -> Iterator[None]:
    """Raises `TimeoutError` where more time passes: a test that waits for a lost task would never end."""

    def late(*_: object) -> None:
        raise TimeoutError(f"not over after {seconds} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def _once_at(share: float, act: Callable[[], None]) -> tuple[Callable[[float], None], list[float]]:
    """A progress that does something once so much is over; and what it was told."""
    seen: list[float] = []

    def progress(now: float) -> None:
        if now >= share and not any(s >= share for s in seen):
            act()
        seen.append(now)

    return progress, seen


@pytest.mark.parametrize("kind", ENGINES)
def test_every_engine_makes_the_same_bytes_after_any_loss(
    kind: str, plan: distributed.Plan, expected: bytes
) -> None:
    # Ray sometimes gives a task to nobody once a worker was killed; a second cluster shows that it is not ours.
    for tries_left in [1, 0] if kind == "ray" else [0]:
        try:
            with _at_most(180), contextmanager(ENGINES[kind])() as cluster:
                _bake_with_losses(cluster, plan, expected)
            return
        except TimeoutError:
            if not tries_left:
                raise


def _bake_with_losses(cluster: Cluster, plan: distributed.Plan, expected: bytes) -> None:
    assert distributed.run(plan, cluster.engine).sets == expected
    progress, seen = _once_at(0.2, cluster.kill_worker)
    assert distributed.run(plan, cluster.engine, units=5, progress=progress).sets == expected
    assert seen == sorted(seen) and seen[-1] == 1.0 and 0.2 < max(seen[:-1]) <= 1.0
    progress, _ = _once_at(0.4, cluster.kill_node)
    assert distributed.run(plan, cluster.engine, progress=progress).sets == expected


def test_what_lay_on_a_lost_node_is_handed_over_again() -> None:
    for cluster in _on_dask():
        engine = cluster.engine
        value = engine.share((b"a round", 2))
        value.future().cancel()
        time.sleep(0.5)
        late = engine.submit(len, value)
        assert engine.ended([late], 30.0) == [late] and engine.result(late) == 2
        # A task whose value goes while it waits ends with an error that the driver takes for a loss.
        # By its name no node would find it.
        after = lambda seconds, _: time.sleep(seconds) or seconds  # type: ignore[func-returns-value]  # noqa: E731
        waits = engine.submit(after, 3.0, value)
        value.future().cancel()
        kept = engine.share(b"stays")
        stays = engine.submit(after, 0.1, kept)
        left, results = [waits, stays], []
        while left:
            for handle in engine.ended(left, 30.0):
                left.remove(handle)
                try:
                    results.append(engine.result(handle))
                except RuntimeError:
                    results.append(None)
        assert 0.1 in results and len(results) == 2


def test_workers_cut_rounds_as_the_driver_does(plan: distributed.Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_worker._here, "held", None)
    job = _native.Job(plan.text, plan.scene)
    wanted = job.missing([], 5)
    ask = (plan.text, plan.scene, None)
    made = _worker.run_unit(*ask, _worker.Share(2, 5), 0, 1, 0, None)
    assert made == _worker.Unit(wanted[2], job.run(wanted[2]))
    # A round may have fewer items than units are asked for.
    assert _worker.run_unit(*ask, _worker.Share(1 << 20, 1 << 21), 0, 1, 0, None) is None
    sizes = [end - begin for begin, end in wanted]
    assert sizes[0] > sizes[-1]


def test_a_round_that_is_begun_and_is_none_changes_nothing(
    plan: distributed.Plan, expected: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Where the last round finds enough, or takes more rays than expected, the next was begun already.
    monkeypatch.setattr(_driver, "_is_last", lambda job: False)
    engine = distributed.Processes(2)
    try:
        for _ in range(2):
            assert distributed.run(plan, engine).sets == expected
    finally:
        engine.close()


def test_what_is_handed_over_lies_in_a_file_for_as_long_as_it_is_held() -> None:
    engine = distributed.Processes(1)
    try:
        value = engine.share([7, 8])
        place = Path(value.place.path)
        handles = [engine.submit(len, value), engine.submit(sum, value)]
        while len(engine.ended(handles, 30.0)) < 2:
            pass
        assert [engine.result(handle) for handle in handles] == [2, 15]
        assert place.exists()
        del value
        assert not place.exists()
        # A task whose value is gone fails, and the process lives on.
        lost = engine.share("gone")
        os.unlink(lost.place.path)
        late = engine.submit(len, lost)
        engine.ended([late], 30.0)
        with pytest.raises(FileNotFoundError):
            engine.result(late)
        assert engine.result(engine.submit(len, "here")) == 4
    finally:
        engine.close()


@pytest.mark.parametrize("data", ["CULLET_DATA"], indirect=True)
def test_a_map_is_the_same_with_its_sets_in_it(data: Path, tmp_path: Path) -> None:
    made = distributed.plan(data / "portals" / "gen_small.prt")
    one = distributed.run(made, units=1)
    assert one.map is None and one.cells > 10
    engine = distributed.Processes(2)
    try:
        assert distributed.run(made, engine, units=3).sets == one.sets
    finally:
        engine.close()


def test_what_is_finished_is_kept_and_what_is_damaged_is_made_again(
    plan: distributed.Plan, expected: bytes, tmp_path: Path
) -> None:
    class Stopped(Exception):
        pass

    def stop() -> None:
        raise Stopped

    progress, _ = _once_at(0.3, stop)
    with pytest.raises(Stopped):
        distributed.run(plan, folder=tmp_path, units=4, progress=progress)
    files = sorted(tmp_path.iterdir())
    assert len(files) > 4 and not any(".part" in f.name for f in files)
    # Clocks that differ by a century change nothing, nor does another split.
    for k, file in enumerate(files):
        os.utime(file, (0, 0) if k % 2 else (4e9, 4e9))
    times = {f: f.stat().st_mtime for f in files}
    files[0].write_bytes(files[0].read_bytes()[:-5])
    files[3].write_bytes(b"")
    assert distributed.run(plan, folder=tmp_path, units=7).sets == expected
    again = [f for f in files if f.stat().st_mtime != times[f]]
    assert files[0] in again or len(list(tmp_path.iterdir())) > len(files)
    # Only what was damaged is made again.
    assert set(again) <= {files[0], files[3]}


def test_two_drivers_may_share_a_folder(plan: distributed.Plan, expected: bytes, tmp_path: Path) -> None:
    found: list[bytes] = []

    def drive(units: int) -> None:
        found.append(distributed.run(plan, folder=tmp_path, units=units).sets)

    drivers = [threading.Thread(target=drive, args=(units,)) for units in (3, 3, 5)]
    for driver in drivers:
        driver.start()
    for driver in drivers:
        driver.join()
    assert found == [expected] * 3


class Failing(distributed.Here):
    """Fails the first unit of a round, so often."""

    def __init__(self, times: int) -> None:
        self.times, self.tries = times, 0

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Any:
        what, number = arguments[3], arguments[4]
        first = what.number == 0 if isinstance(what, _worker.Share) else what[0] == 0
        if first and number == 1 and self.tries < self.times:
            self.tries += 1
            return super().submit(self.fail)
        return super().submit(task, *arguments)

    def fail(self) -> None:
        raise MemoryError("no room on this node")


def test_a_unit_that_always_fails_is_named_and_the_rest_is_kept(
    plan: distributed.Plan, expected: bytes, tmp_path: Path
) -> None:
    with pytest.raises(distributed.UnitsFailed, match="round 1.*items 0 to .*MemoryError: no room.*goes on") as raised:
        distributed.run(plan, Failing(1000), folder=tmp_path, units=4, retries=2)
    ((begin, end),) = raised.value.failed
    folder = _native.UnitFolder(tmp_path)
    kept = sorted(folder.units(plan.key, 1))
    assert begin == 0 and kept[0][0] == end and len(kept) == 3
    # A unit that fails and then does not is none the worse.
    failing = Failing(2)
    assert distributed.run(plan, failing, folder=tmp_path, units=4, retries=2).sets == expected
    assert failing.tries == 2


def _command(folder: Path, *words: str) -> list[str]:
    sizes = ["--view-cells", "10", "--heights", "0.5", "3", "--rays", "400000"]
    start = [sys.executable, "-m", "pycullet.distributed", "pvs", SCENE, *sizes]
    return [*start, "--folder", str(folder), *words]


def test_a_driver_that_is_killed_is_gone_on_from(expected: bytes, tmp_path: Path) -> None:
    units, out = tmp_path / "units", tmp_path / "sets"
    driver = subprocess.Popen(_command(units, "--processes", "2"), start_new_session=True)
    begin = time.monotonic()
    while not units.exists() or len(list(units.glob("*.unit"))) < 6:
        assert time.monotonic() - begin < 60 and driver.poll() is None
        time.sleep(0.01)
    os.killpg(driver.pid, signal.SIGKILL)
    driver.wait()
    kept = {f: f.stat().st_mtime_ns for f in units.glob("*.unit")}
    done = subprocess.run(_command(units, "--processes", "2", "-o", str(out)), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "10 cells" in done.stdout and out.read_bytes() == expected
    assert all(f.stat().st_mtime_ns == when for f, when in kept.items()), "what was finished is not made again"


def test_a_full_disk_is_named_and_leaves_nothing_torn(tmp_path: Path) -> None:
    units = tmp_path / "units"

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (900, 900))

    done = subprocess.run(_command(units, "--processes", "1"), capture_output=True, text=True, preexec_fn=limit)
    assert done.returncode == 4, done.stderr
    assert str(units) in done.stderr and "cannot be kept" in done.stderr
    assert not list(units.glob("*.part"))


def test_the_command_says_what_is_wrong(tmp_path: Path) -> None:
    start = [sys.executable, "-m", "pycullet.distributed"]

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([*start, *words], capture_output=True, text=True, cwd=tmp_path)

    gone = run("pvs", "nowhere.bsp")
    assert gone.returncode == 3 and "nowhere.bsp" in gone.stderr
    (tmp_path / "odd.prt").write_text("PRT9\n")
    assert run("pvs", "odd.prt").returncode == 3
    assert "--ray" in run("pvs", "--help").stdout and "examples" in run("--help").stdout
    no_map = run("pvs", SCENE, "--view-cells", "2", "--rays", "1000", "-o", "a.bsp", "--processes", "1")
    assert no_map.returncode == 2 and "no map" in no_map.stderr


@pytest.mark.parametrize("data", ["CULLET_DATA"], indirect=True)
def test_a_node_without_the_file_is_handed_it_once(data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here = tmp_path / "here.prt"
    shutil.copy(data / "portals" / "gen_small.prt", here)
    made = distributed.plan(here)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    elsewhere = str(tmp_path / "elsewhere" / "here.prt")
    monkeypatch.setattr(_worker._here, "held", None)
    ask = (made.text, elsewhere, made.content, (0, 1), 0, 1, 0)
    assert _worker.run_unit(*ask, None) == _worker.NeedsScene()
    first = _worker.run_unit(*ask, here.read_bytes())
    assert isinstance(first, _worker.Unit)
    monkeypatch.setattr(_worker._here, "held", None)
    assert _worker.run_unit(*ask, None) == first, "the second worker of the node finds it"
    assert first.found == _native.Job(made.text, str(here)).run((0, 1))
    # Who comes late is handed all that was found.
    assert _worker.run_unit(made.text, elsewhere, made.content, (0, 1), 1, 1, 0, None) == _worker.Behind(0)


def test_another_file_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "a.off"
    off = "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 {}\n1 1 1\n3 0 1 2\n3 1 3 2\n"
    file.write_text(off.format(0))
    made = distributed.plan(file, view_cells=2, rays=1000)
    file.write_text(off.format(2))
    with pytest.raises(FileError, match="a.off.*plan was made of"):
        distributed.run(made)
