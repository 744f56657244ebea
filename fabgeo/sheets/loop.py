"""Sheet after sheet: for every stock size a knapsack of candidates, the best fill is kept.

Glossary
--------
candidates
    Some of the pieces that wait: half of them the largest, half drawn at random.
fill
    Area of the pieces over the cost of the sheet (its area where no cost is given).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fabgeo.sheets.packing import pack_sheet
from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.shelf import Layout, fits
from fabgeo.sheets.stock import Placement, Stock

if TYPE_CHECKING:
    from fabgeo.sheets.nest import Rules

CANDIDATES = 24
MOST_TRIES = 12  # a sheet and stock


def knapsack_loop(
    pieces: Sequence[Piece],
    rules: Rules,
    end: float,
    seed: int,
    steps: int | None,
    sound: Callable[[Stock, list[Placement]], bool],
) -> Layout:
    """Fill one sheet after the other until no piece waits, no stock is left or time is up.

    Parameters
    ----------
    end : float
        `time.monotonic()` to stop at, kept by shorter tries as it nears.
    steps : int, optional
        Tries a sheet and stock size; without effect of `end` then.
    sound : callable
        The exact check of one sheet.
    """
    random = np.random.default_rng(seed)
    waiting = sorted(pieces, key=lambda piece: -piece.area)
    left = {stock.name: stock.quantity for stock in rules.stocks}
    layout: Layout = []
    while waiting:
        found = _best_sheet(waiting, rules, left, end, random, steps, sound)
        if found is None:
            break
        stock, placements = found
        layout.append(found)
        count = left[stock.name]
        left[stock.name] = None if count is None else count - 1
        for placement in placements:
            k = next(k for k, piece in enumerate(waiting) if piece.mark == placement.mark)
            waiting.pop(k)
    return layout


def _best_sheet(
    waiting: list[Piece],
    rules: Rules,
    left: dict[str, int | None],
    end: float,
    random: np.random.Generator,
    steps: int | None,
    sound: Callable[[Stock, list[Placement]], bool],
) -> tuple[Stock, list[Placement]] | None:
    areas = {piece.mark: piece.area for piece in waiting}
    able = {
        stock.name: [piece for piece in waiting if fits(piece, stock, rules.margin)]
        for stock in rules.stocks
        if left[stock.name] != 0
    }
    stocks = [stock for stock in rules.stocks if able.get(stock.name)]
    if not stocks:
        return None
    stop = time.monotonic() + _share(waiting, stocks, end)
    best: tuple[Stock, list[Placement]] | None = None
    most, tries = 0.0, 0
    # Every stock is tried once whatever the clock says, unless the end itself has come.
    while tries < (steps or MOST_TRIES) * len(stocks):
        now = time.monotonic()
        if steps is None and (now >= end or (tries >= len(stocks) and now >= stop)):
            break
        stock = stocks[tries % len(stocks)]
        chosen = _draw(able[stock.name], random)
        seconds = end - now if steps is None else None
        placed = pack_sheet(chosen, stock, rules.spacing, rules.margin, seconds)
        fill = sum(areas[placement.mark] for placement in placed) / _price(stock)
        if placed and fill > most and sound(stock, placed):
            best, most = (stock, placed), fill
        tries += 1
        if len(chosen) == len(waiting) and tries >= len(stocks):
            break  # all that waits was on offer: another draw brings nothing new
    return best


def _draw(able: list[Piece], random: np.random.Generator) -> list[Piece]:
    if len(able) <= CANDIDATES:
        return able
    half = CANDIDATES // 2
    rest = random.choice(len(able) - half, CANDIDATES - half, replace=False)
    return able[:half] + [able[half + int(k)] for k in sorted(rest)]


def _share(waiting: list[Piece], stocks: Sequence[Stock], end: float) -> float:
    """Seconds for one sheet: what is left over the sheets still to come (70 % fill assumed)."""
    area = sum(piece.area for piece in waiting)
    size = float(np.mean([stock.length * stock.width for stock in stocks]))
    return (end - time.monotonic()) / max(1.0, area / (0.7 * size))


def _price(stock: Stock) -> float:
    size = stock.length * stock.width
    return max(size if stock.cost is None else stock.cost, 1e-3 * size)
