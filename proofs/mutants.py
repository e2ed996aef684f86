#!/usr/bin/env python3
"""Runs the tests once for each mutant: `mutants.py COPY FIRST LAST FOLDER PROGRAM...`, after
`cullet-mutants` and a build.

Only mutants of files whose names begin with FOLDER, as in `crates/cullet/`, are tried. Each PROGRAM
is a test program with its arguments as one word, as in 'target/release/deps/cullet-0123 occlusion'.
They run in their order until one fails. A mutant is caught by a test that fails, by a crash, or by
five times the processor time of the sources as they are. `COPY/results.tsv` gets a line for each
mutant: number, `caught` or `survived`, by which test. Several of these programs may run side by
side: `COPY/claimed` tells which mutants another has begun.
"""

import os
import re
import resource
import shlex
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

FAILED = re.compile(r"^test (\S+)(?: - should panic)? \.\.\. FAILED")


def run(program: str, mutant: int, seconds: int) -> tuple[str, float]:
    """What caught the mutant, or nothing; and the processor time that the program took."""

    def limits() -> None:
        os.setsid()
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
        resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))

    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    child = subprocess.Popen(
        [*shlex.split(program), "--test-threads", "2"],
        env={**os.environ, "CULLET_MUTANT": str(mutant)},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        preexec_fn=limits,
    )
    # One that waits takes no processor time.
    watch = threading.Timer(100 * seconds, lambda: os.killpg(child.pid, signal.SIGKILL))
    watch.start()
    by = ""
    for line in child.stdout:
        found = FAILED.match(line)
        if found:
            by = found[1]
            os.killpg(child.pid, signal.SIGKILL)
            break
    code = child.wait()
    watch.cancel()
    if not by and code != 0:
        by = {-signal.SIGXCPU: "time", -signal.SIGKILL: "time"}.get(code, f"exit code {code}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return by, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> int:
    copy, first, last, folder = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
    programs = sys.argv[5:]
    limits = []
    for program in programs:
        by, took = run(program, 0, 3600)
        print(f"{took:7.1f} s  {program} {by}", flush=True)
        if by:
            print("the sources as they are fail")
            return 2
        limits.append(int(5 * took) + 10)
    rows = [line.split("\t") for line in (copy / "mutants.tsv").read_text().splitlines()]
    rows = sorted((int(row[0]), row) for row in rows)
    caught = survived = 0
    claimed = copy / "claimed"
    claimed.mkdir(exist_ok=True)
    for number, row in rows:
        if not first <= number <= last or not row[1].startswith(folder):
            continue
        try:
            (claimed / str(number)).touch(exist_ok=False)
        except FileExistsError:
            continue
        begun, by = time.monotonic(), ""
        for program, seconds in zip(programs, limits):
            by, _ = run(program, number, seconds)
            if by:
                break
        caught, survived = caught + bool(by), survived + (not by)
        result = f"{number}\t{'caught' if by else 'survived'}\t{by}"
        with open(copy / "results.tsv", "a") as results:
            results.write(result + "\n")
        print(f"{time.monotonic() - begun:6.1f} s  {result}  {row[1]}:{row[4]} {row[5]}  {row[6]}", flush=True)
    print(f"{caught} caught, {survived} survived")
    return 0


if __name__ == "__main__":
    sys.exit(main())
