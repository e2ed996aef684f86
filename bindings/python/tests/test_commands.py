"""Commands in shares on an engine."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from pycullet import distributed

# A command that works in units: a share leaves a file, and the end joins all that lie there.
_COMMAND = """
import os, pathlib, signal, sys
words = sys.argv[1:]
folder = pathlib.Path(words[words.index("--units") + 1])
folder.mkdir(exist_ok=True)
begin = folder / ("begun-" + words[words.index("--unit") + 1].replace("/", "-")) if "--unit" in words else None
if begin is None:
    assert "--resume" in words
    print(",".join(sorted(p.name for p in folder.glob("done-*"))))
    sys.exit(5)
share = int(begin.name.split("-")[1])
first = not begin.exists()
begin.write_text("")
if "always" in words and share == 2:
    print("share 2 cannot be done", file=sys.stderr)
    sys.exit(2)
if "killed" in words and share == 3 and first:
    os.kill(os.getppid(), signal.SIGKILL)
(folder / f"done-{share}").write_text("")
"""


@pytest.fixture(params=["here", "processes", "dask"])
def engine(request: pytest.FixtureRequest) -> Iterator[distributed.Engine]:
    made: distributed.Engine
    if request.param == "here":
        made = distributed.Here()
    elif request.param == "processes":
        made = distributed.Processes(2)
    else:
        pytest.importorskip("distributed")
        made = distributed.Dask()
    yield made
    made.close()


@pytest.fixture
def command(tmp_path: Path) -> list[str]:
    script = tmp_path / "command.py"
    script.write_text(_COMMAND)
    return [sys.executable, str(script)]


def test_each_share_is_run_and_then_all_are_joined(
    engine: distributed.Engine, command: list[str], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    told: list[float] = []
    code = distributed.run_command(command, engine, folder=tmp_path / "units", shares=5, progress=told.append)
    assert code == 5, "the exit code of the command that joins"
    assert capfd.readouterr().out.strip() == "done-1,done-2,done-3,done-4,done-5"
    assert told == [share / 5 for share in range(1, 6)]


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no such signal")
def test_a_lost_worker_costs_its_share_alone(
    command: list[str], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    engine = distributed.Processes(2)
    distributed.run_command([*command, "killed"], engine, folder=tmp_path / "units", shares=4)
    engine.close()
    assert capfd.readouterr().out.strip() == "done-1,done-2,done-3,done-4"


def test_a_share_that_always_fails_is_named_and_the_rest_is_kept(
    engine: distributed.Engine, command: list[str], tmp_path: Path
) -> None:
    with pytest.raises(distributed.SharesFailed, match="1 of 3 shares.*share 2 cannot be done") as raised:
        distributed.run_command([*command, "always"], engine, folder=tmp_path / "units", shares=3, retries=1)
    assert list(raised.value.failed) == [2]
    assert {p.name for p in (tmp_path / "units").glob("done-*")} == {"done-1", "done-3"}


def test_a_program_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(distributed.SharesFailed, match="no-such-program: there is no such program"):
        distributed.run_command(["no-such-program"], folder=tmp_path, shares=1, retries=0)


@pytest.mark.skipif("CULLET_PROGRAM" not in os.environ, reason="CULLET_PROGRAM names no program")
def test_views_of_a_scene_are_verified_in_shares(tmp_path: Path) -> None:
    program = os.environ["CULLET_PROGRAM"]
    words = [program, "verify", "city:cells=3,objects=40", "--views", "6", "--size", "160x90", "--samples", "1"]
    run = [sys.executable, "-m", "pycullet.distributed", "run", "--processes", "2", "--shares", "3"]
    done = subprocess.run(
        [*run, "--units", str(tmp_path / "units"), *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "0 false culls" in done.stdout
    assert len(list((tmp_path / "units").glob("*.unit"))) == 6
