"""Whole builds: the same bytes, only what changed made again, going on after an interrupt."""

from __future__ import annotations

import signal
import time
from collections import Counter
from pathlib import Path

import pytest
from builds import ROOF, build, entries, files, start

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def roof(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the package `out`, built by this process alone."""
    folder = tmp_path_factory.mktemp("roof")
    build(folder, ROOF, "--jobs", "1")
    return folder


def different(first: Path, second: Path) -> set[str]:
    a, b = files(first), files(second)
    return {name for name in {*a, *b} if a.get(name) != b.get(name)}


def test_serial_parallel_and_cached_builds_give_the_same_bytes(roof: Path, tmp_path: Path) -> None:
    build(tmp_path, ROOF, "--jobs", "2")
    assert different(roof / "out", tmp_path / "out") == set()
    before = entries(tmp_path / "out")
    build(tmp_path, ROOF, "--jobs", "2")
    assert entries(tmp_path / "out") == before
    assert different(roof / "out", tmp_path / "out") == set()


def test_another_material_remakes_nests_but_no_shape(roof: Path) -> None:
    before = entries(roof / "out")
    stock = '[[stock]]\nmaterial = "copper"\nlength = 6000.0\nwidth = 2500.0\n'
    copper = "[materials.copper]\ndensity = 8900.0\nE = 120000.0\nyield_stress = 130.0\n"
    copper += "rolls_radius = 100.0\n"
    text = ROOF.replace("[panels]", '[panels]\nmaterial = "copper"') + stock + copper
    build(roof, text, "--jobs", "1")
    after = entries(roof / "out")
    made = Counter(name.split("/")[0] for name in after.keys() - before.keys())
    assert made == {"nest": 1, "latest": 1, "page": 12}  # a page tells mass and sheet
    assert Counter(n.split("/")[0] for n in before.keys() - after.keys()) == made  # pruned


def test_a_build_goes_on_after_an_interrupt(roof: Path, tmp_path: Path) -> None:
    build(roof, ROOF, "--jobs", "1")
    process = start(tmp_path, ROOF, "--jobs", "2")
    end = time.monotonic() + 300.0
    while len(list((tmp_path / "out/.fabgeo/cache").glob("flat/*"))) < 3:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=120)
    assert process.returncode == 130, err
    assert "what was finished is kept" in err
    assert {p.name for p in (tmp_path / "out").iterdir()} == {".fabgeo"}
    kept = entries(tmp_path / "out")
    assert sum(name.startswith("fit/") for name in kept) == 1
    build(tmp_path, ROOF, "--jobs", "2")
    after = entries(tmp_path / "out")
    assert all(after[name] == written for name, written in kept.items() if "." not in name)
    assert different(roof / "out", tmp_path / "out") == set()
