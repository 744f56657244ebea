"""The tutorial's blocks run one after another, as the page says."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import fabgeo

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.mark.slow
def test_the_tutorial_runs(tmp_path: Path) -> None:
    blocks = re.findall(r"```python\n(.*?)```", (DOCS / "tutorial.md").read_text(), re.DOTALL)
    (tmp_path / "tutorial.py").write_text("\n".join(blocks))
    done = subprocess.run(
        [sys.executable, "tutorial.py"], cwd=tmp_path, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert "degrees of twist" in done.stdout


@pytest.mark.slow
def test_the_readme_runs(tmp_path: Path) -> None:
    blocks = re.findall(r"```python\n(.*?)```", (DOCS.parent / "README.md").read_text(), re.DOTALL)
    assert len(blocks) == 2
    told = (
        *blocks,
        "assert package.failures == [], package.failures",
        "(panels, cells) = part.children",
        "assert (part.label, panels.label, cells.label) == ('Roof', 'panels', 'cells')",
        "assert {p.label for p in panels.children} == set(made.choices)",
        "assert all(p.color is not None and p.volume > 0 for p in panels.children)",
        "assert set(solids) == set(flats) | {cell.mark for cell in made.cells}",
        "assert nests and not any(nest.unplaced for nest in nests)",
        "assert fabgeo.measure(result.model, surface).covered_share > 0.999",
    )
    (tmp_path / "fixtures").symlink_to(DOCS.parent / "fixtures")
    (tmp_path / "readme.py").write_text("\n".join(told))
    done = subprocess.run(
        [sys.executable, "readme.py"], cwd=tmp_path, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stderr[-2000:]


@pytest.mark.slow
def test_the_manual_is_made_without_a_warning(tmp_path: Path) -> None:
    pytest.importorskip("sphinx", reason="needs the extra docs")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html"]
    done = subprocess.run([*command, DOCS, tmp_path], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr[-3000:]
    for page in ("index", "tutorial", "reference", "gallery", "mathematics"):
        assert (tmp_path / f"{page}.html").exists()
    shown = re.findall(r'<img[^>]* src="([^"]+)"', (tmp_path / "tutorial.html").read_text())
    assert [Path(name).suffix for name in shown] == [".png", ".svg"]
    assert all((tmp_path / name).stat().st_size > 1000 for name in shown)


def test_every_public_name_is_in_the_reference() -> None:
    named = set(re.findall(r":: fabgeo\.(\w+)", (DOCS / "reference.rst").read_text()))
    assert set(fabgeo.__all__) - {"__version__"} <= named


def test_links_between_pages_lead_somewhere() -> None:
    for page in DOCS.glob("*.md"):
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text()):
            if target.startswith("made/"):
                continue  # by the tutorial itself, when the manual is made
            assert (page.parent / target).exists(), f"{page.name}: {target}"
