"""What is imported when: nothing heavy before it is needed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

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
