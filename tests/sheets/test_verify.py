"""The check of layouts finds what is wrong, and passes what is right to the last 0.02 mm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fabgeo.sheets.contour import Contour
from fabgeo.sheets.stock import Nest, Placement, Sheet, Stock
from fabgeo.sheets.verify import check_nest, check_sheet

STOCK = Stock("S", "al", 3.0, 1000.0, 500.0, quantity=1)
# A plate whose right side bulges by 50 mm: half circle-like arcs need exact treatment.
CAP = Contour(np.array([[0, 0, 0], [200, 0, 0.5], [200, 200, 0], [0, 200, 0.0]]))
CONTOURS = {"a": CAP, "b": CAP}


def sheet(*placements: Placement) -> Sheet:
    return Sheet("SHEET-001", STOCK, placements, 0.0)


def test_sound_layout_passes() -> None:
    made = sheet(Placement("a", 10, 10, 0.0), Placement("b", 266.0, 10, 0.0))
    assert check_sheet(made, CONTOURS, 6.0, 10.0) == []


@pytest.mark.parametrize(("x", "sound"), [(266.0, True), (265.97, False), (265.0, False)])
def test_spacing_is_measured_on_the_arc(x: float, sound: bool) -> None:
    made = sheet(Placement("a", 10, 10, 0.0), Placement("b", x, 10, 0.0))
    assert (check_sheet(made, CONTOURS, 6.0, 10.0) == []) is sound


@pytest.mark.parametrize(("x", "sound"), [(740.0, True), (740.05, False)])
def test_margin_is_measured_on_the_arc(x: float, sound: bool) -> None:
    problems = check_sheet(sheet(Placement("a", x, 10, 0.0)), CONTOURS, 6.0, 10.0)
    assert (problems == []) is sound


def test_overlap_touch_and_nesting_inside() -> None:
    touch = sheet(Placement("a", 10, 10, 0.0), Placement("b", 10, 210, 0.0))
    assert check_sheet(touch, CONTOURS, 0.0, 10.0) == []
    within = sheet(Placement("a", 10, 10, 0.0), Placement("b", 10, 10, 0.0))
    assert "overlap" in check_sheet(within, CONTOURS, 0.0, 10.0)[0]
    across = sheet(Placement("a", 10, 10, 0.0), Placement("b", 200, 100, 0.0))
    assert "overlap" in check_sheet(across, CONTOURS, 6.0, 10.0)[0]


def test_every_part_once_rotations_and_stock() -> None:
    good = sheet(Placement("a", 10, 10, 0.0), Placement("b", 266.0, 10, 0.0))
    made = Nest("al", 3.0, (good,), {}, 0.0, 6.0, 10.0)
    rotations = {"a": (0.0, np.pi), "b": (0.0, np.pi)}
    assert check_nest(made, CONTOURS, rotations) == []
    twice = replace(made, sheets=(good, replace(good, name="SHEET-002")))
    problems = check_nest(twice, CONTOURS, rotations)
    assert any("a is placed 2 times, expected 1" in p for p in problems)
    assert any("stock S: 2 used of 1" in p for p in problems)
    missing = replace(made, sheets=(sheet(good.placements[0]),))
    assert any("b is placed 0 times" in p for p in check_nest(missing, CONTOURS, rotations))
    named = replace(missing, unplaced={"b": "too long"})
    assert check_nest(named, CONTOURS, rotations) == []
    turned = replace(made, sheets=(sheet(Placement("a", 400, 100, 0.1), good.placements[0]),))
    assert any("turned by 5.730 deg" in p for p in check_nest(turned, CONTOURS, rotations))
