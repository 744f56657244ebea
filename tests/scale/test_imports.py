"""What is imported when: nothing heavy before it is needed."""

from __future__ import annotations

import ast
import subprocess
import sys
from importlib.metadata import requires
from pathlib import Path

import pytest

import fabgeo
from fabgeo.build.cache import LIBRARIES

HEAVY = {"OCP", "build123d", "cadquery", "matplotlib", "trimesh", "ezdxf", "reportlab", "scipy"}


@pytest.mark.parametrize(
    ("statement", "allowed"),
    [
        ("import fabgeo", set()),
        ("import fabgeo.cli", set()),
        ("import fabgeo; fabgeo.read_project, fabgeo.FormulaSurface", {"scipy"}),
        ("import fabgeo.build", set()),
        ("import fabgeo.build.flats", {"scipy"}),
    ],
)
def test_heavy_libraries_wait(statement: str, allowed: set[str]) -> None:
    script = f"{statement}\nimport sys\nprint(*{{name.split('.')[0] for name in sys.modules}})"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert HEAVY & set(done.stdout.split()) <= allowed


def test_the_command_tells_the_version_that_the_changelog_is_at() -> None:
    said = subprocess.run(
        [sys.executable, "-m", "fabgeo", "--version"], capture_output=True, text=True, check=True
    )
    changelog = (Path(__file__).parents[2] / "CHANGELOG.md").read_text(encoding="utf-8")
    newest = next(line for line in changelog.splitlines() if line.startswith("## "))
    assert said.stdout.split() == ["fabgeo", newest.split()[1]]


def test_type_checkers_see_every_public_name() -> None:
    tree = ast.parse(Path(fabgeo.__file__).read_text(encoding="utf-8"))
    seen = {
        name.asname
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for name in node.names
    }
    assert set(fabgeo.__all__) - {"__version__"} <= seen


def test_results_of_another_library_version_are_not_taken_over() -> None:
    """Every dependency makes something that is kept, but for those that are named here."""
    no_numbers = {"pydantic", "typer", "rich", "joblib", "dask", "openpyxl", "cadquery"}
    not_kept = {"ifcopenshell"}  # its file is written anew
    needed = {
        line.split(";")[0].strip()
        for line in requires("fabgeo") or ()
        if 'extra == "dev"' not in line and 'extra == "docs"' not in line
    }
    names = {name.partition("[")[0].rstrip("<>=.,0123456789") for name in needed}
    assert names - no_numbers - not_kept <= set(LIBRARIES)


SAYING = """
import os, sys
import fabgeo.build.surface
from fabgeo.cli import main

class Found:
    def as_dict(self):
        return {"faces": 1}

def inspect_file(*_):
    os.write(1, b"a solver tells its version")
    os.system("echo so does another process")
    return Found()

fabgeo.build.surface.inspect_file = inspect_file
sys.argv = ["fabgeo", "inspect", "roof.step", "--json"]
main()
"""


def test_standard_output_holds_json_alone() -> None:
    done = subprocess.run([sys.executable, "-c", SAYING], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["{", '"faces":', "1", "}"]


def test_an_interrupt_while_the_command_loads_is_told_in_a_line() -> None:
    script = """
import sys

class Interrupted:
    def find_spec(self, name, *_):
        if name == "typer":
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interrupted())
from fabgeo.__main__ import main
main()
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "fabgeo: interrupted\n")
