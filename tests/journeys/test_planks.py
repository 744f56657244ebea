"""A geodesic model built to planks cut from boards, the grain along them."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from fabgeo.build import build_package

ROOF = """
name = "Planked roof"
drawings = false
[surface]
unit = "m"
u = [-1.0, 1.0]
v = [-1.5, 1.5]
x = "u"
y = "v"
z = "-0.06*u**2 - 0.05*v**2"
[strips]
kind = "geodesic"
count = 10
[panels]
count = 1
joint = 0.0
thickness = 12.0
material = "wood"
choice = "single"
tolerance = 0.001
[nesting]
rotations = "grain"
steps = 1
[[stock]]
material = "wood"
length = 4000.0
width = 260.0
"""

PART = """start = "geodesic"
part = [2, 3]
count = 3"""


@pytest.mark.slow
def test_planks_are_nearly_straight_and_lie_edge_to_edge(tmp_path: Path) -> None:
    (tmp_path / "roof.toml").write_text(ROOF)
    build_package(tmp_path / "roof.toml", tmp_path / "out")
    with (tmp_path / "out" / "schedules" / "panels.csv").open(encoding="utf-8") as stream:
        panels = list(csv.DictReader(stream))
    assert len(panels) >= 10
    for row in panels[1:-1]:  # the outermost are cut along sides that bulge by 14 mm
        assert float(row["plank_sag_mm"]) < 1e-4 * float(row["flat_length_mm"])
    for row in panels:
        assert 0.5 < float(row["plank_yield"]) <= 1.0
        assert float(row["flat_width_mm"]) < 260.0
        assert float(row["sheet_rotation_deg"]) % 180.0 == pytest.approx(0.0)
        assert row["sheet"]
    beside = [float(r["edge_congruence_mm"]) for r in panels if r["edge_congruence_mm"]]
    assert len(beside) == len(panels) - 1
    # Laid side by side unmirrored, a lens of 1.8 mm stays open; mirrored they are one curve.
    assert max(beside) < 1e-4 * float(panels[0]["flat_length_mm"])


@pytest.mark.slow
def test_one_of_several_models_is_built_with_a_plank_for_each_strip(tmp_path: Path) -> None:
    part = ROOF.replace('kind = "geodesic"\ncount = 10', 'kind = "geodesic"\n' + PART)
    (tmp_path / "roof.toml").write_text(part)
    build_package(tmp_path / "roof.toml", tmp_path / "out")
    with (tmp_path / "out" / "schedules" / "panels.csv").open(encoding="utf-8") as stream:
        panels = list(csv.DictReader(stream))
    assert len(panels) == 3
    assert all(float(row["plank_yield"]) > 0.5 for row in panels)
    # Three models of three strips lie across 2 m and its arc: none has drawn in.
    width = sum(float(row["flat_width_mm"]) for row in panels)
    assert 2000.0 / 3.0 <= width <= 1.1 * 2000.0 / 3.0
