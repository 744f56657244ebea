"""Column generation: sheets of dropped shapes are sound, mixes are as cheap as they can be."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest
import scipy.optimize

from fabgeo.panels.flat import FlatPart
from fabgeo.panels.unfold import flat_polygon
from fabgeo.sheets.batches import batched
from fabgeo.sheets.cover import Cover
from fabgeo.sheets.drop import drop_sheet, placements, profiles
from fabgeo.sheets.mix import cheapest_choice, cheapest_mix
from fabgeo.sheets.nest import Rules
from fabgeo.sheets.pieces import piece_of
from fabgeo.sheets.stock import Sheet, Stock
from fabgeo.sheets.verify import check_sheet

STOCK = Stock("S", "al", 3.0, 2000.0, 1000.0)
SPACING, MARGIN = 6.0, 10.0


def star(mark: str, random: np.random.Generator, grain: str = "steps") -> FlatPart:
    """A star-shaped part of 5 to 14 corners: concave, 60 to 1200 mm across."""
    corners = int(random.integers(5, 15))
    angle = np.sort(random.uniform(0.0, 2 * np.pi, corners))
    angle = np.linspace(0.0, 2 * np.pi, corners, endpoint=False) + 0.3 * (angle / corners)
    reach = random.uniform(30.0, 250.0) * random.uniform(0.4, 1.0, corners)
    stretch = random.uniform(1.0, 2.4)
    points = np.column_stack([stretch * reach * np.cos(angle), reach * np.sin(angle)])
    return flat_polygon(mark, "al", 3.0, points, grain=grain)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("grain", ["free", "along", "steps"])
def test_dropped_sheets_keep_spacing_and_margin(seed: int, grain: str) -> None:
    random = np.random.default_rng(seed)
    pieces = [piece_of(star(f"S-{k}", random, grain)) for k in range(30)]
    made = profiles(pieces, STOCK, SPACING, MARGIN)
    areas = np.array([piece.area for piece in pieces])
    sheet = drop_sheet(made, areas, np.ones(30), random, 1.5)
    placed = placements(made, sheet, pieces, SPACING, MARGIN)
    assert len(placed) == len({p.mark for p in placed}) >= 5
    contours = {piece.mark: piece.contour for piece in pieces}
    assert check_sheet(Sheet("x", STOCK, tuple(placed), 0.0), contours, SPACING, MARGIN) == []


def test_prices_and_choice_of_a_mix_known_by_hand() -> None:
    # Sheets (2, 0), (1, 1), (0, 3) at 6; 4 and 3 wanted: 2 x 6 + 1 x 6, prices 3 and 2.
    counts = np.array([[2.0, 0.0], [1.0, 1.0], [0.0, 3.0]])
    own, costs, stocked = np.zeros(3, dtype=np.intp), np.array([6.0]), np.array([np.inf])
    mix = cheapest_mix(counts, own, costs, np.array([4.0, 3.0]), stocked)
    assert mix.cost == pytest.approx(18.0)
    assert mix.prices == pytest.approx([3.0, 2.0])
    times = cheapest_choice(counts, own, costs, np.array([4.0, 3.0]), stocked, None)
    assert times.tolist() == [2, 0, 1]


@pytest.mark.parametrize("unit", [1.0, 3e7])
def test_the_mix_takes_few_pivots_in_any_unit_of_cost(
    unit: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Ten of 83 equal pieces a sheet: whichever they are, 8.3 sheets. In square millimetres the
    # solver once pivoted for minutes over this.
    pivots, solve = [], scipy.optimize.linprog

    def counted(*given: Any, **named: Any) -> Any:
        found = solve(*given, **named)
        pivots.append(found.nit)
        return found

    monkeypatch.setattr(scipy.optimize, "linprog", counted)
    random = np.random.default_rng(1)
    counts = np.zeros((250, 83))
    for row in counts:
        row[random.choice(83, 10, replace=False)] = 1.0
    own, costs, stocked = np.zeros(250, dtype=np.intp), np.array([unit]), np.array([np.inf])
    mix = cheapest_mix(counts, own, costs, np.ones(83), stocked)
    assert mix.cost == pytest.approx(8.3 * unit)
    assert mix.prices.sum() == pytest.approx(mix.cost)
    assert len(pivots) == 1
    assert pivots[0] < 2 * sum(counts.shape)


def test_boxes_reach_the_least_sheets() -> None:
    # Three boxes of 320 fill the height of 980 but for 20: nine boxes need three sheets.
    boxes = [
        piece_of(
            flat_polygon(
                f"B-{k}",
                "al",
                3.0,
                np.array([[0, 0], [1900, 0], [1900, 320], [0, 320.0]]),
                grain="along",
            )
        )
        for k in range(9)
    ]
    rules = Rules((STOCK,), SPACING, MARGIN)
    best = min(len(layout) for layout in Cover(boxes, rules, time.monotonic() + 2.0).layouts())
    assert best == 3


def test_copies_scarce_stock_and_batches_hold_every_piece_once() -> None:
    random = np.random.default_rng(7)
    kinds = [piece_of(star(f"S-{k}", random)) for k in range(12)]
    pieces = [piece for piece in kinds for _ in range(25)]
    scarce = Stock("rest", "al", 3.0, 1500.0, 800.0, quantity=2, cost=0.0)
    rules = Rules((STOCK, scarce), SPACING, MARGIN)
    layout = batched(pieces, rules, time.monotonic() + 1.0, 0, None)
    placed = [placement.mark for _, sheet in layout for placement in sheet]
    assert sorted(placed) == sorted(piece.mark for piece in pieces)
    assert sum(stock.name == "rest" for stock, _ in layout) <= 2


def test_steps_give_the_same_layouts() -> None:
    random = np.random.default_rng(3)
    pieces = [piece_of(star(f"S-{k}", random, "along")) for k in range(8)]
    rules = Rules((STOCK,), SPACING, MARGIN)
    once, again = (list(Cover(pieces, rules, 0.0, 5, 1).layouts()) for _ in range(2))
    assert once == again
