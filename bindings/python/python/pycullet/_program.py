"""The program ``cullet``: ``cullet report model.glb``, and the other commands that need nothing beside it."""

from __future__ import annotations

import sys

from . import _native


def main() -> int:
    """Runs the program on this process's arguments, and returns its exit code."""
    return _native.program(["cullet", *sys.argv[1:]])
