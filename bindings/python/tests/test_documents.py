"""What the documents show runs, and what they say holds."""

from __future__ import annotations

import ast
import doctest
import json
import pathlib
import re
import subprocess
import sys

import pytest

import pycullet

HERE = pathlib.Path(__file__).resolve().parent.parent
CHAPTER = HERE.parent.parent / "docs" / "src" / "python.md"


def programs(path: pathlib.Path) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```", path.read_text(encoding="utf-8"), re.M | re.S)


@pytest.mark.parametrize("path", [HERE / "README.md", CHAPTER], ids=["README", "chapter"])
def test_programs_of_the_documents_run(path: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if not path.exists():
        pytest.skip(f"{path.name} lies in the repository only")
    monkeypatch.chdir(tmp_path)
    found = programs(path)
    assert found
    # Each goes on from those before it, as a reader does.
    names: dict[str, object] = {}
    for program in found:
        exec(compile(program, str(path), "exec"), names)


def test_the_first_program_is_ten_lines_at_most() -> None:
    first = programs(HERE / "README.md")[0]
    lines = [line for line in first.splitlines() if line.strip()]
    assert len(lines) <= 10 and "scene.cull(camera)" in first


def test_examples_in_docstrings_hold() -> None:
    assert doctest.testmod(pycullet).failed == 0 and doctest.testmod(pycullet).attempted > 3


def test_the_notebook_runs_and_shows_pictures() -> None:
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    path = HERE / "examples" / "first.ipynb"
    plain = json.loads(path.read_text(encoding="utf-8"))
    assert all(not cell.get("outputs") for cell in plain["cells"]), "outputs are not kept in the repository"
    notebook = nbformat.read(path, 4)
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    shown = json.dumps(notebook)
    assert shown.count("data:image/png") == 4 and "image/png" in shown and "nothing visible was lost" in shown


def test_all_that_is_public_is_documented() -> None:
    stub = pathlib.Path(pycullet.__file__).parent
    bare = []
    for file in ("_native.pyi", "_scene.py", "_answers.py", "_report.py", "pyvista.py"):
        for node in ast.parse((stub / file).read_text(encoding="utf-8")).body:
            if not isinstance(node, ast.ClassDef) or node.name.startswith("_"):
                continue
            if ast.get_docstring(node) is None:
                bare.append(f"{file}: {node.name}")
            for item in node.body:
                if not isinstance(item, ast.FunctionDef) or item.name.startswith("_"):
                    continue
                # Of an overloaded one, the last has the words for all.
                overloaded = any(isinstance(d, ast.Name) and d.id == "overload" for d in item.decorator_list)
                if ast.get_docstring(item) is None and not overloaded:
                    bare.append(f"{file}: {node.name}.{item.name}")
    assert not bare, bare


def test_stubs_name_what_there_is() -> None:
    """Every method that the stub promises is there, and the other way round."""
    tree = ast.parse((pathlib.Path(pycullet.__file__).parent / "_native.pyi").read_text(encoding="utf-8"))
    native = sys.modules["pycullet._native"]
    for node in tree.body:
        if not isinstance(node, ast.ClassDef):
            continue
        promised = {m.name for m in node.body if isinstance(m, ast.FunctionDef)}
        promised |= {m.target.id for m in node.body if isinstance(m, ast.AnnAssign) and isinstance(m.target, ast.Name)}
        there = {n for n in vars(getattr(native, node.name)) if not n.startswith("__")}
        assert {n for n in promised if not n.startswith("__")} == there, node.name


def test_help_says_what_the_stub_says() -> None:
    for name in ("cull", "set_transforms", "bake_pvs"):
        text = getattr(pycullet.Scene, name).__doc__
        assert text and len(text) > 60, name


def test_types_hold() -> None:
    pytest.importorskip("mypy")
    words = [sys.executable, "-m", "mypy", "--config-file", str(HERE / "pyproject.toml"), "tests"]
    done = subprocess.run(words, cwd=HERE, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
