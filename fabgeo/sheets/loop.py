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

from fabgeo.sheets.packing import pack
from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.shelf import Layout, fits
from fabgeo.sheets.stock import Placement, Stock

if TYPE_CHECKING:
    from fabgeo.sheets.nest import Rules

CANDIDATES = 24


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
    stocks = [stock for stock in rules.stocks if left[stock.name] != 0]
    seconds = _share(waiting, stocks, end)
    if not stocks or (steps is None and seconds < 0.05):
        return None
    best: tuple[Stock, list[Placement]] | None = None
    most = 0.0
    for stock in stocks:
        able = [piece for piece in waiting if fits(piece, stock, rules.margin)]
        for _ in range(steps or 1):
            if not able:
                break
            chosen = _draw(able, random)
            sheets = pack(
                chosen, stock, rules.spacing, rules.margin, seconds, "knapsack", steps is not None
            )
            placed = sheets[0] if sheets else []
            fill = sum(areas[placement.mark] for placement in placed) / _price(stock)
            if placed and fill > most and sound(stock, placed):
                best, most = (stock, placed), fill
    return best


def _draw(able: list[Piece], random: np.random.Generator) -> list[Piece]:
    if len(able) <= CANDIDATES:
        return able
    half = CANDIDATES // 2
    rest = random.choice(len(able) - half, CANDIDATES - half, replace=False)
    return able[:half] + [able[half + int(k)] for k in sorted(rest)]


def _share(waiting: list[Piece], stocks: Sequence[Stock], end: float) -> float:
    """Seconds for one try: what is left over the tries still to come (70 % fill assumed)."""
    if not stocks:
        return 0.0
    area = sum(piece.area for piece in waiting)
    size = float(np.mean([stock.length * stock.width for stock in stocks]))
    tries = max(1.0, area / (0.7 * size)) * len(stocks)
    return min(2.0, (end - time.monotonic()) / tries)


def _price(stock: Stock) -> float:
    size = stock.length * stock.width
    return max(size if stock.cost is None else stock.cost, 1e-3 * size)
