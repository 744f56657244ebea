"""A dome cut by an oblique boundary: built with trim = true, and checked from its files alone."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from fabgeo import build_package
from fabgeo.review.check import check_package

PROJECT = """
name = "Oblique dome"
[surface]
unit = "m"
u = [-2.5, 2.5]
v = [-2.0, 2.0]
x = "0.9396926*u - 0.3420201*v"
y = "0.3420201*u + 0.9396926*v"
z = "-x**2/30 - y**2/15"
[surface.define]
[strips]
kind = "general"
start = "principal"
count = 4
[panels]
length = 3000.0
trim = true
joint = 10.0
thickness = 3.0
material = "aluminium"
tolerance = 3.0
[[stock]]
material = "aluminium"
length = 6000.0
width = 2500.0
[nesting]
seconds = 1.0
"""
PROJECT = PROJECT.replace(
    "-x**2/30 - y**2/15",
    "-(0.9396926*u - 0.3420201*v)**2/30 - (0.3420201*u + 0.9396926*v)**2/15",
)


@pytest.mark.slow
def test_a_dome_cut_by_an_oblique_boundary_passes_its_check(tmp_path: Path) -> None:
    (tmp_path / "dome.toml").write_text(PROJECT)
    package = build_package(tmp_path / "dome.toml", tmp_path / "out")
    report = check_package(tmp_path / "out")
    assert report.findings == ()
    review = json.loads((tmp_path / "out/checks/review.json").read_text())
    summary = review["summary"]
    assert summary["gap_max_mm"] <= 2.0
    assert summary["failed_verdicts"] == 0
    assert any("panels are cut along the boundary" in note for note in package.design.notes)
    with (tmp_path / "out/schedules/panels.csv").open(encoding="utf-8", newline="") as file:
        round_ones = [row for row in csv.DictReader(file) if row["class"] == "cylinder"]
    assert round_ones
    assert all(row["radius_min_mm"] == row["radius_max_mm"] for row in round_ones)
