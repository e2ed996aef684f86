"""The program that the wheel brings along."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pycullet

_PROGRAM = Path(sys.executable).parent / "cullet"


def _run(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([_PROGRAM, *words], cwd=folder, capture_output=True, text=True, timeout=300)


def test_it_writes_a_report_and_ends_as_the_program_does(tmp_path: Path) -> None:
    assert _run(tmp_path, "--version").stdout == f"cullet {pycullet.__version__}\n"
    said = _run(tmp_path, "report", "solids", "--views", "2", "--quiet")
    assert said.returncode == 0, said.stderr
    page = (tmp_path / "report" / "index.html").read_text(encoding="utf-8")
    assert "solids" in page and (tmp_path / "report" / "report.json").exists()


def test_a_wrong_command_line_ends_with_2_and_a_missing_file_with_3(tmp_path: Path) -> None:
    wrong = _run(tmp_path, "reprot")
    assert wrong.returncode == 2 and "report" in wrong.stderr
    missing = _run(tmp_path, "info", "nowhere.glb")
    assert missing.returncode == 3 and "nowhere.glb" in missing.stderr
