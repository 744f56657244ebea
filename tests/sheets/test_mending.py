"""Mending: every piece stays laid out, sheets are spared, short stock lasts, processes share it."""

from __future__ import annotations

import time

import numpy as np
import pytest

from fabgeo.panels.unfold import flat_polygon
from fabgeo.sheets import mending
from fabgeo.sheets.filling import Wanted, cost_of, filled, held
from fabgeo.sheets.mending import mended
from fabgeo.sheets.nest import Rules
from fabgeo.sheets.pieces import Piece, piece_of
from fabgeo.sheets.sheetpool import Found, SheetPool
from fabgeo.sheets.stock import Stock

LARGE = Stock("large", "al", 3.0, 2000.0, 1000.0)
SMALL = Stock("small", "al", 3.0, 2000.0, 400.0, quantity=2)


def box(mark: str, length: float, width: float) -> Piece:
    corners = np.array([[0, 0], [length, 0], [length, width], [0, width]])
    return piece_of(flat_polygon(mark, "al", 3.0, corners, grain="along"))


def one_a_sheet(pieces: list[Piece], stocks: tuple[Stock, ...]) -> tuple[SheetPool, list[Found]]:
    """Every piece on a sheet of its own of the first stock."""
    pool = SheetPool(pieces, Rules(stocks, 6.0, 10.0), 3)
    sheets = []
    for k in range(len(pieces)):
        alone = np.where(np.arange(len(pieces)) == k, 1.0, 0.0)
        sheets.append(pool.drop(0, alone, alone, 1.0))
        pool.keep(sheets[-1])
    return pool, sheets


@pytest.mark.parametrize("jobs", [1, 2])
def test_twelve_boxes_need_four_sheets(jobs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    # Three boxes of 320 fill the height of 980 but for 20.
    monkeypatch.setattr(mending, "STARTING", 0.0)
    pool, sheets = one_a_sheet([box(f"B-{k}", 1900.0, 320.0) for k in range(12)], (LARGE,))
    assert len(sheets) == 12
    for found in mended(pool, sheets, time.monotonic() + 8.0, jobs, 0):
        assert np.all(sum(f.counts for f in found) >= pool.demand)
        sheets = found
        if len(sheets) == 4:
            break
    assert len(sheets) == 4
    assert sum(len(placed) for _, placed in pool.layout(sheets)) == 12


def test_short_stock_is_used_as_often_as_it_is_there() -> None:
    # Three boxes of 320 fill a large sheet, one a small one: five take one large and both small.
    pool, sheets = one_a_sheet([box(f"B-{k}", 1900.0, 320.0) for k in range(5)], (LARGE, SMALL))
    *_, best = mended(pool, sheets, time.monotonic() + 1.5, 1, 0)
    assert np.all(sum(f.counts for f in best) >= pool.demand)
    assert sorted(f.stock for f in best) == [0, 1, 1]  # three boxes, one, one
    assert cost_of(pool, best) == pytest.approx(2.0e6 + 2 * 0.8e6)


def test_a_sheet_holds_what_the_ones_before_do_not() -> None:
    pool, _ = one_a_sheet([box(f"B-{k}", 900.0, 320.0) for k in range(4)], (LARGE,))
    area = np.array([piece.area for piece in pool.kinds])
    sheets = filled(pool, area, Wanted(pool.demand, pool.stocked), 3)
    assert sum(held([*sheets, *sheets], pool.demand)) == pytest.approx(pool.demand)
    assert not np.any(held([*sheets, *sheets], pool.demand)[-1])
