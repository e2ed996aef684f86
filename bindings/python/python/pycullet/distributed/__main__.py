"""``python -m pycullet.distributed``: a bake on this machine's processes, on Ray or on Dask."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

from .. import FileError
from . import Dask, Engine, Here, Processes, Ray, SharesFailed, UnitsFailed, plan, run, run_command

_EXAMPLES = """\
examples
  python -m pycullet.distributed pvs map.bsp                               on all processors of this machine
  python -m pycullet.distributed pvs map.bsp -o baked.bsp --ray 10.0.0.1:6379
  python -m pycullet.distributed pvs map.bsp --dask tcp://10.0.0.1:8786
  python -m pycullet.distributed pvs city --view-cells 1000 --heights 1 2.5 --ray local
  python -m pycullet.distributed pvs map.bsp --folder units                goes on where it was stopped
  python -m pycullet.distributed run --ray local --units /shared/city cullet bake city.glb -o baked.glb
  python -m pycullet.distributed run --units views cullet verify city.glb --views 1000

exit codes
  0 fine    1 units failed each time; the rest is kept    2 wrong usage
  3 no such file, or it is invalid    4 units cannot be kept    130 interrupted; finished units are kept in --folder
"""


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "python -m pycullet.distributed",
        description="Bakes that many processes share, on one machine or a cluster: the same bytes as by one.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="pvs|run")
    pvs = commands.add_parser(
        "pvs",
        help="potentially visible sets of a map, a portal graph or a scene",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    pvs.add_argument("file", help="a .prt, a .bsp, a scene, or the name of a built-in one")
    pvs.add_argument("-o", "--out", metavar="PATH", help="write the sets; with the ending .bsp, the map with the sets in it")
    _add_where(pvs)
    pvs.add_argument("--folder", metavar="FOLDER", help="keep finished units, and go on from those that are there [default: FILE.units]")
    pvs.add_argument("--units", type=int, metavar="N", help="units of a round [default: four a worker]")
    pvs.add_argument("--seed", type=int, default=1)
    pvs.add_argument("--fast", action="store_true", help="of cells: only a first bound, at once")
    pvs.add_argument("--view-cells", type=int, metavar="N", help="of a scene: how many view cells")
    pvs.add_argument("--heights", type=float, nargs=2, metavar=("LOW", "HIGH"), help="cells only so far above the lowest point")
    pvs.add_argument("--clusters", action="store_true", help="sets of clusters instead of instances")
    pvs.add_argument("--rays", type=int, metavar="N", help="end after about so many rays")
    command = commands.add_parser(
        "run",
        help="any command of cullet that works in units: bake, verify, report, pvs",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    _add_where(command)
    command.add_argument("--units", metavar="FOLDER", required=True, help="folder of finished units, seen by all nodes")
    command.add_argument("--shares", type=int, metavar="N", help="in how many shares [default: four a worker]")
    command.add_argument("words", nargs=argparse.REMAINDER, metavar="COMMAND", help="the command, without --unit")
    return parser


def _add_where(parser: argparse.ArgumentParser) -> None:
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--ray", metavar="ADDRESS", help="a Ray cluster; 'local' starts one here")
    where.add_argument("--dask", metavar="ADDRESS", help="a Dask scheduler; 'local' starts workers here")
    where.add_argument("--processes", type=int, metavar="N", help="processes of this machine [default: one a processor]")
    parser.add_argument("--retries", type=int, default=3, metavar="N", help="how often a lost unit is run again [default: 3]")


def _engine(options: argparse.Namespace) -> Engine:
    if options.ray is not None:
        return Ray(None if options.ray == "local" else options.ray)
    if options.dask is not None:
        return Dask(None if options.dask == "local" else options.dask)
    count = options.processes or os.cpu_count() or 1
    return Processes(count) if count > 1 else Here()


def _bar() -> Callable[[float], None]:
    """A line that says how much is over, once it takes more than two seconds; none where nobody looks."""
    begin, last = time.monotonic(), [0.0]

    def show(share: float) -> None:
        now = time.monotonic()
        if not sys.stderr.isatty() or now - begin < 2 or now - last[0] < 0.2:
            return
        last[0] = now
        left = (now - begin) * (1 - share) / max(share, 1e-6)
        full = int(share * 40)
        print(f"\r[{'#' * full}{'.' * (40 - full)}] {share:4.0%}, about {left:.0f} s left ", end="", file=sys.stderr)

    return show


def main() -> int:
    options = _arguments().parse_args()
    folder = options.units if options.command == "run" else options.folder or f"{options.file.replace(':', '-')}.units"
    try:
        return _command(options) if options.command == "run" else _sets(options, folder)
    except KeyboardInterrupt:
        print(f"interrupted; the same command goes on from {folder}", file=sys.stderr)
        return 130
    except (UnitsFailed, SharesFailed) as error:
        print(error, file=sys.stderr)
        return 1
    except (FileError, FileNotFoundError) as error:
        print(error, file=sys.stderr)
        return 3
    except ImportError as error:
        extra = "ray" if options.ray else "dask"
        print(f"{error}: pip install 'pycullet[{extra}]' brings it", file=sys.stderr)
        return 2
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(error, file=sys.stderr)
        return 4


def _command(options: argparse.Namespace) -> int:
    words = options.words[1:] if options.words[:1] == ["--"] else options.words
    if not words:
        raise ValueError("which command? Such as: cullet bake city.glb -o baked.glb")
    engine = _engine(options)
    try:
        return run_command(
            words, engine, folder=options.units, shares=options.shares, retries=options.retries, progress=_bar()
        )
    finally:
        engine.close()


def _sets(options: argparse.Namespace, folder: str) -> int:
    made_plan = plan(
        options.file,
        seed=options.seed,
        fast=options.fast,
        view_cells=options.view_cells,
        heights=tuple(options.heights) if options.heights else None,
        clusters=options.clusters,
        rays=options.rays,
    )
    begin = time.monotonic()
    engine = _engine(options)
    try:
        made = run(made_plan, engine, folder=folder, units=options.units, retries=options.retries, progress=_bar())
    finally:
        engine.close()
    took = time.monotonic() - begin
    of_all = made.cells * made.targets
    print(f"{options.file}: {made.cells} cells, {made.visible_pairs} pairs are seen of {of_all}; {took:.1f} s")
    if options.out:
        to_map = options.out.lower().endswith(".bsp")
        if to_map and made.map is None:
            print(f"{options.file} is no map to write the sets into; give another ending to --out", file=sys.stderr)
            return 2
        data = made.map if to_map and made.map is not None else made.sets
        Path(options.out).write_bytes(data)
        print(f"{options.out}, {len(data)} bytes")
    return 0


# Workers import this module too.
if __name__ == "__main__":
    sys.exit(main())
