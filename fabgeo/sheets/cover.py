"""All pieces on the cheapest set of sheets: filled one after the other, then mended.

Glossary
--------
filling, dive, mending
    See `fabgeo.sheets.filling`, `fabgeo.sheets.diving` and `fabgeo.sheets.mending`. Dives are worth
    their time where all sheets are alike.
choice
    The cheapest whole sheets of all that were found (`fabgeo.sheets.sheetpool`).
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fabgeo.sheets.diving import Dives
from fabgeo.sheets.filling import LARGE, Wanted, filled
from fabgeo.sheets.mending import Hand, mend, mended
from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.sheetpool import Found, SheetPool
from fabgeo.sheets.shelf import Layout

if TYPE_CHECKING:
    from fabgeo.sheets.nest import Rules

FILLING = (1, 10, 40)  # tries a sheet
VAIN = 15  # fillings in a row that may gain nothing
FEW = 60  # kinds of pieces whose last choice is made
STEP_TRIES, STEP_MENDINGS = 10, 20  # of them a step
FILLED, DIVED, MENDED = 0.06, 0.45, 0.98  # shares of the time after which each ends


class Cover:
    """Layouts of one group of pieces, by what has been found so far.

    Parameters
    ----------
    pieces : sequence of Piece
        As often as they are asked for; each fits some stock.
    end : float
        `time.monotonic()` to stop at; without effect where `steps` are given.
    steps : int, optional
        Dives, then so many times `STEP_MENDINGS` mendings in this process: reproducible.
    jobs : int, optional
        Processes that mend side by side where no steps are given; None: one for each core.
    """

    def __init__(
        self,
        pieces: Sequence[Piece],
        rules: Rules,
        end: float,
        seed: int = 0,
        steps: int | None = None,
        jobs: int | None = 1,
    ) -> None:
        self.rules, self.end, self.steps, self._jobs = rules, end, steps, jobs
        self.pool = SheetPool(pieces, rules, seed)
        self._seed = seed
        self._best: list[Found] = []
        self._least = np.inf

    def layouts(self) -> Iterator[Layout]:
        """Ever cheaper layouts (not each is cheaper than the one before)."""
        start, pool = time.monotonic(), self.pool
        wanted = Wanted(pool.demand, pool.stocked)
        soon, end = (start + FILLED * (self.end - start), self.end)
        if self.steps is not None:
            soon = end = np.inf
        for large, tries in self._ways(soon):
            yield self._known(filled(pool, pool.areas**large, wanted, tries, soon, end))
            if self._late(0.1):
                return
        if self._best and (self.steps is not None or len(self.rules.stocks) == 1):
            for sheets in Dives(pool, start + DIVED * (self.end - start), self.steps).layouts():
                yield self._known(sheets)
        if self._best:
            for sheets in self._mended(start + MENDED * (self.end - start)):
                yield self._known(sheets)
        if not self._late(0.5) and len(pool.kinds) <= FEW:
            seconds = None if self.steps is not None else max(0.1, self.end - time.monotonic())
            yield self._known(pool.choice(pool.demand, pool.stocked, self._least, seconds))

    def add(self, layout: Layout) -> None:
        """Take the sheets of a layout found elsewhere."""
        names = {stock.name: k for k, stock in enumerate(self.rules.stocks)}
        for stock, placed in layout:
            self.pool.join(names[stock.name], placed)

    def _mended(self, end: float) -> Iterator[list[Found]]:
        from joblib import cpu_count

        if self.steps is None:
            jobs = cpu_count() if self._jobs is None else self._jobs
            yield from mended(self.pool, self._best, end, jobs, self._seed)
        else:
            hand = Hand(tuple(self._best), Wanted(self.pool.demand, self.pool.stocked))
            yield mend(self.pool, hand, most=self.steps * STEP_MENDINGS)

    def _ways(self, end: float) -> Iterator[tuple[float, int]]:
        """Exponents of the area and tries a sheet, again and again as long as there is time."""
        for tries in FILLING:
            for large in LARGE:
                yield large, tries
            if self.steps is None and time.monotonic() > end:
                return
            if self.steps is not None and tries >= self.steps * STEP_TRIES:
                return
        least, vain = self._least, 0
        while self.steps is None and vain < VAIN and time.monotonic() < end:
            yield float(self.pool.random.choice(LARGE)), FILLING[-1]
            vain = 0 if self._least < least else vain + 1
            least = self._least

    def _late(self, seconds: float) -> bool:
        return self.steps is None and time.monotonic() + seconds > self.end

    def _known(self, chosen: Sequence[Found]) -> Layout:
        """The layout of sheets, remembered if it holds all for less than any before."""
        layout = self.pool.layout(chosen)
        held = sum(len(placed) for _, placed in layout)
        cost = sum(stock.price for stock, _ in layout)
        if held == self.pool.demand.sum() and cost < self._least:
            self._best, self._least = list(chosen), cost
        return layout
