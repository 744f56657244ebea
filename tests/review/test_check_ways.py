"""Beams built in other ways than most: the check finds nothing in packages that are sound."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_check_real import PROJECT

from fabgeo.build import build_package
from fabgeo.project import parse_project
from fabgeo.review.check import check_package
from fabgeo.review.solid_plate import _thickness

BARE = {key: value for key, value in PROJECT.items() if key not in ("cells", "connectors")}
WAYS: dict[str, dict[str, Any]] = {
    "one flange, end plates": {"section": "T", "end_plate": 12.0, "cuts": [1.0]},
    "bevelled at both ends": {"weld_gap": 2.0, "bevel": 50.0, "cuts": [0.9, 1.8]},
    "envelope flanges": {"flanges": "envelope"},
    "two webs": {"section": "box", "flange_width": 120.0},
}


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_nothing_is_found_in_beams(way: str, tmp_path: Path) -> None:
    beams = {**PROJECT["beams"], **WAYS[way]}
    build_package(parse_project({**BARE, "beams": beams}), tmp_path / "out")
    report = check_package(tmp_path / "out")
    assert report.ok, list(report.lines())
    assert report.measured["solids"] > 20


def arc(radius: float, begin: float, end: float) -> np.ndarray:
    turn = np.linspace(begin, end, 65)
    return radius * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)


@pytest.mark.parametrize("bevels", [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0)])
def test_a_plate_is_as_thick_between_bevels_as_elsewhere(bevels: tuple[float, float]) -> None:
    """Skins of a bent plate 10 mm thick, one of them longer by 4.66 mm at its bevelled ends."""
    run = 4.66 / 9000.0
    one = arc(9005.0, -run * bevels[0], 0.2 + run * bevels[1])
    two = arc(8995.0, 0.0, 0.2)
    up, ends = np.array([0.0, 0.0, 200.0]), ((one[0], two[0]), (one[-1], two[-1]))
    sides = [(np.linspace(a, a + up, 65), np.linspace(b, b + up, 65)) for a, b in ends]
    assert _thickness([(one, two), (one + up, two + up), *sides]) == pytest.approx(10.0, abs=1e-5)
