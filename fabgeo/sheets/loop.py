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
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np

from fabgeo.sheets.packing import QUEUE, pack_sheet
from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.shelf import Layout, fits
from fabgeo.sheets.stock import Placement, Stock

if TYPE_CHECKING:
    from fabgeo.sheets.nest import Rules

CANDIDATES = 24
MOST_TRIES = 12  # a sheet and stock
LEAST_QUEUE, MOST_QUEUE = 2, 32  # of the tree search
THREADS = 2


def knapsack_loop(
    pieces: Sequence[Piece],
    rules: Rules,
    end: float,
    seed: int,
    steps: int | None,
    sound: Callable[[Stock, list[Placement]], bool],
    stopped: Callable[[], bool] = lambda: False,
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
    stopped : callable
        Whether somebody asks to leave off.
    """
    loop = _Loop(rules, end, steps, sound, np.random.default_rng(seed))
    waiting = sorted(pieces, key=lambda piece: -piece.area)
    left = {stock.name: stock.quantity for stock in rules.stocks}
    layout: Layout = []
    while waiting and not stopped():
        found = loop.best_sheet(waiting, [s for s in rules.stocks if left[s.name] != 0])
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


class _Loop:
    """Rounds of tries, one a stock; the engine works on them side by side (it frees Python)."""

    def __init__(
        self,
        rules: Rules,
        end: float,
        steps: int | None,
        sound: Callable[[Stock, list[Placement]], bool],
        random: np.random.Generator,
    ) -> None:
        self.rules, self.end, self.steps = rules, end, steps
        self.sound, self.random = sound, random
        self.pace = 0.05  # seconds of one try over the queue's size, measured as it goes

    def best_sheet(
        self, waiting: list[Piece], stocks: list[Stock]
    ) -> tuple[Stock, list[Placement]] | None:
        areas = {piece.mark: piece.area for piece in waiting}
        able = {
            stock.name: [piece for piece in waiting if fits(piece, stock, self.rules.margin)]
            for stock in stocks
        }
        stocks = [stock for stock in stocks if able[stock.name]]
        if not stocks:
            return None
        share = _share(waiting, stocks, self.end)
        stop = time.monotonic() + share
        best: tuple[Stock, list[Placement]] | None = None
        most = 0.0
        for k in range(self.steps or MOST_TRIES):
            now = time.monotonic()
            if self.steps is None and (now >= self.end or (k > 0 and now >= stop)):
                break
            chosen = [_draw(able[stock.name], self.random) for stock in stocks]
            for stock, placed in zip(stocks, self._round(stocks, chosen, share), strict=True):
                fill = sum(areas[placement.mark] for placement in placed) / stock.price
                if placed and fill > most and self.sound(stock, placed):
                    best, most = (stock, placed), fill
            if all(len(some) == len(waiting) for some in chosen):
                break  # all that waits was on offer: another draw brings nothing new
        return best

    def _round(
        self, stocks: list[Stock], chosen: list[list[Piece]], share: float
    ) -> list[list[Placement]]:
        start = time.monotonic()
        seconds = None if self.steps is not None else max(0.1, self.end - start)
        queue = QUEUE
        if self.steps is None:
            queue = int(np.clip(share / (self.pace * len(stocks)), LEAST_QUEUE, MOST_QUEUE))

        def one(stock: Stock, pieces: list[Piece]) -> list[Placement]:
            rules = self.rules
            return pack_sheet(pieces, stock, rules.spacing, rules.margin, seconds, queue)

        with ThreadPoolExecutor(min(THREADS, len(stocks))) as pool:
            placed = list(pool.map(one, stocks, chosen))
        self.pace = (time.monotonic() - start) / (queue * len(stocks))
        return placed


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
