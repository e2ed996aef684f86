#!/usr/bin/env python3
"""Kills bakes at random: `killed_bakes.py [--kills N] [--seed N] BAKER ARGUMENT...`, as in
`killed_bakes.py target/release/cullet-baker bake castle.glb --merge --occluders`.

The bake is run once undisturbed. Then, until N runs were killed: a new folder of units, one to
three runs in a row that get SIGKILL, and one that ends. A kill comes once a run has used a random
part of the processor time of the whole bake, so that the load of the machine does not matter. After each kill the output is what was there before or the whole file; at the end it has the
bytes of the undisturbed bake. Exit code 1 where not.
"""

import argparse
import hashlib
import json
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

OLD = b"what was there before"


def used(pid: int) -> float:
    """Seconds of processor time of a process, in steps of 10 ms (Linux)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("command", nargs=argparse.REMAINDER)
    args = parser.parse_args()
    chance = random.Random(args.seed)
    folder = Path(tempfile.mkdtemp(prefix="cullet-killed-"))
    out, whole, units = folder / "out.glb", folder / "whole.glb", folder / "units"

    def begin(to: Path, *more: str) -> subprocess.Popen:
        command = [*args.command, "-o", str(to), "--quiet", *more]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    if begin(whole).wait() != 0:
        print("the undisturbed bake fails")
        return 2
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    length = spent.ru_utime + spent.ru_stime
    sha = hashlib.sha256(whole.read_bytes()).hexdigest()
    print(f"undisturbed: {length:.2f} s of the processor, {whole.stat().st_size} bytes, sha256 {sha[:16]}")

    resume = ("--resume", "--units", str(units))
    hit = late = torn = wrong = rounds = resumed = 0
    while hit < args.kills:
        rounds += 1
        shutil.rmtree(units, ignore_errors=True)
        out.write_bytes(OLD)
        for _ in range(chance.randint(1, 3)):
            child = begin(out, *resume)
            at = chance.uniform(0, length)
            while child.poll() is None and used(child.pid) < at:
                time.sleep(0.001)
            # Within the step.
            time.sleep(chance.uniform(0, 0.01))
            child.kill()
            killed = child.wait() < 0
            hit, late = hit + killed, late + (not killed)
            left = out.read_bytes()
            if left != OLD and left != whole.read_bytes():
                wrong += 1
                print(f"round {rounds}: {len(left)} bytes of neither file")
        # Files under another name, which a run that was killed left half written.
        torn += sum(1 for f in units.glob("*") if f.suffix not in (".levels", ".group", ".occluders"))
        child = begin(out, *resume, "--json", "-")
        said, _ = child.communicate()
        if child.returncode != 0 or out.read_bytes() != whole.read_bytes():
            wrong += 1
            print(f"round {rounds}: other bytes, exit code {child.returncode}: {said[:300]!r}")
        else:
            resumed += json.loads(said)["resumed"]
        print(f"round {rounds}: {hit} killed, {late} ended before, {resumed} units taken over", flush=True)
    shutil.rmtree(folder)
    print(f"{rounds} rounds: {hit} runs killed, {late} ended before their kill, {torn} other files beside the units,")
    print(f"{resumed} units taken over in all; {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
