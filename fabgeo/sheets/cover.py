"""All pieces on the cheapest set of sheets: column generation over dropped sheets.

Glossary
--------
mix, pool, price
    See `fabgeo.sheets.mix` and `fabgeo.sheets.sheetpool`.
dive
    Sheets with the largest shares in the mix are fixed, a few at a time, and sheets are looked for
    anew for what is left, until nothing is left.
filling
    Sheet after sheet, each the best of some tries on every stock; large pieces are worth more than
    their area, so that small ones are left for the last sheets.
mending
    Some sheets of the best layout are given up and their pieces laid out anew, all else as it is.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

import numpy as np

from fabgeo.arrays import Array
from fabgeo.sheets.mix import Mix
from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.priced import Priced
from fabgeo.sheets.sheetpool import Found, SheetPool
from fabgeo.sheets.shelf import Layout
from fabgeo.sheets.stock import Placement, Stock

if TYPE_CHECKING:
    from fabgeo.sheets.nest import Rules

DIVING = 2  # rounds before sheets are fixed
AT_LEAST = 2  # sheets that a dive fixes at a time
STALLED, LEAST_GAIN = 12, 1e-3  # rounds that have to make the mix cheaper by this share
STEP_ROUNDS = 20  # rounds of the mix a step
FEW = 60  # kinds of pieces whose last choice is made where steps are given
LARGE = (1.0, 1.15, 1.3)  # exponents of the area: how much large pieces come first
FILLING = (1, 10, 40)  # tries a sheet
STEP_TRIES = 10  # of them a step
GIVEN_UP = 30  # pieces whose sheets are given up at a time
MENDING = 20  # tries a sheet for them
VAIN = 60  # mendings in a row that may gain nothing; of fillings a quarter as many
CHOOSING = 2.0  # seconds at most of one choice

# Shares of the time after which the filling, the dives and the mending end; of the dives' time
# the share of the mix before them.
ENDS, MIXING = (0.5, 0.62, 0.94), 0.6
ENDS_ONE = (0.2, 0.75, 0.92)  # of one stock size: dives are worth more there

type Sound = Callable[[Stock, list[Placement]], bool]


class Cover:
    """Layouts of one group of pieces, by what has been found so far.

    Parameters
    ----------
    pieces : sequence of Piece
        As often as they are asked for; each fits some stock.
    end : float
        `time.monotonic()` to stop at; without effect where `steps` are given.
    steps : int, optional
        Dives, after so many times `STEP_ROUNDS` rounds of the mix: reproducible.
    sound : callable, optional
        The exact check of a sheet. Where it is given (and no steps are), the other engine looks
        for sheets beside, in a thread of its own.
    """

    def __init__(
        self,
        pieces: Sequence[Piece],
        rules: Rules,
        end: float,
        seed: int = 0,
        steps: int | None = None,
        sound: Sound | None = None,
    ) -> None:
        self.rules, self.end, self.steps = rules, end, steps
        self.pool = SheetPool(pieces, rules, seed)
        self._sound, self._seed = sound, seed
        self._best: list[Found] = []
        self._least = np.inf

    def layouts(self) -> Iterator[Layout]:
        """Ever cheaper layouts (not each is cheaper than the one before)."""
        start, area = time.monotonic(), np.array([piece.area for piece in self.pool.kinds])
        ends = ENDS_ONE if len(self.rules.stocks) == 1 else ENDS
        filled, dived, mended = (start + s * (self.end - start) for s in ends)
        for large, tries in self._ways(filled):
            pool = self.pool
            yield self._known(self._filled(area**large, pool.demand, pool.stocked, tries, filled))
            if self._late(0.1):
                return
        yield from self._mixed(dived)
        vain = 0
        while self.steps is None and self._best and vain < VAIN and time.monotonic() < mended:
            vain += 1
            if self._mended(area, mended):
                vain = 0
                yield self._known(self._best)
        if not self._late(0.5) and (self.steps is None or len(self.pool.kinds) <= FEW):
            seconds = None if self.steps is not None else max(0.1, self.end - time.monotonic())
            demand, stocked = self.pool.demand, self.pool.stocked
            yield self._known(self.pool.choice(demand, stocked, self._least, seconds))

    def add(self, layout: Layout) -> None:
        """Take the sheets of a layout found elsewhere."""
        names = {stock.name: k for k, stock in enumerate(self.rules.stocks)}
        for stock, placed in layout:
            self.pool.join(names[stock.name], placed)

    def _mixed(self, end: float) -> Iterator[Layout]:
        """Layouts that dives take from the cheapest mix, the other engine beside."""
        pool = self.pool
        with ExitStack() as stack:
            if self._sound is not None and self.steps is None:
                pool.beside = stack.enter_context(
                    Priced(pool.kinds, self.rules, self._sound, end, self._seed)
                )
            now = time.monotonic()
            self._mix_until(now + MIXING * (end - now))
            dives = 0
            while dives < self.steps if self.steps is not None else time.monotonic() < end:
                before = len(pool)
                yield self._known(self._dive(end))
                dives += 1
                if len(pool) == before and dives > 1:
                    break  # nothing new is found: the choice is left
        pool.beside = None

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
        while self.steps is None and vain < VAIN // 4 and time.monotonic() < end:
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

    def _filled(
        self, worth: Array, demand: Array, stocked: Array, tries: int, end: float
    ) -> list[Found]:
        """Sheet after sheet, each of the stock that is filled best for its price."""
        pool = self.pool
        left, stocked = demand.copy(), stocked.copy()
        chosen: list[Found] = []
        while left.any():
            if self._over(end):
                tries = 1
            tried = [
                pool.climb(k, worth, left, tries)
                for k in range(len(stocked))
                if stocked[k] > 0 and not (self._late(0.0) and chosen and k != chosen[-1].stock)
            ]
            tried = [found for found in tried if found.placed]
            if not tried:
                break
            best = max(tried, key=lambda found: found.counts @ worth / pool.costs[found.stock])
            for found in tried:
                pool.keep(found)
            chosen.append(best)
            left = np.maximum(left - best.counts, 0.0)
            stocked[best.stock] -= 1
        return chosen

    def _mix_until(self, end: float) -> None:
        """Look for sheets that make the mix cheaper until that stalls."""
        pool, costs = self.pool, list[float]()
        while len(costs) < (self.steps or 0) * STEP_ROUNDS or (
            self.steps is None and time.monotonic() < end
        ):
            mix = pool.mix(pool.demand, pool.stocked)
            costs.append(mix.cost)
            if len(costs) > STALLED and mix.cost > (1.0 - LEAST_GAIN) * costs[-1 - STALLED]:
                return
            pool.look(mix, pool.demand, pool.stocked)

    def _dive(self, last: float) -> list[Found]:
        """Fix sheets of the mix, a few at a time; look for sheets for what is left."""
        pool = self.pool
        demand, stocked = pool.demand.copy(), pool.stocked.copy()
        chosen: list[Found] = []
        step = 0.0
        while demand.any():
            start = time.monotonic()
            mix = pool.mix(demand, stocked)
            for _ in range(DIVING):
                if self._over(last) or not pool.look(mix, demand, stocked):
                    break
                mix = pool.mix(demand, stocked)
            step = max(0.5 * step, time.monotonic() - start)
            many = AT_LEAST
            if self.steps is None:
                turns = max(1.0, (last - time.monotonic()) / step)
                many = max(many, int(np.ceil(mix.shares.sum() / turns)))
            fixed = self._fixed(mix, demand, stocked, many)
            if not fixed:
                break
            for found in fixed:
                chosen.append(found)
                demand = np.maximum(demand - found.counts, 0.0)
                stocked[found.stock] -= 1
        return chosen

    def _over(self, last: float) -> bool:
        return self.steps is None and time.monotonic() > last

    def _fixed(self, mix: Mix, demand: Array, stocked: Array, many: int) -> list[Found]:
        """Sheets of the largest shares that hold nothing twice; the first in any case."""
        sheets = self.pool.sheets
        shares = np.append(mix.shares, np.zeros(len(sheets) - len(mix.shares)))
        held = np.array([float(np.minimum(f.counts, demand).sum()) for f in sheets])
        order = np.argsort(-(shares + 1e-6 * held), kind="stable")
        demand, stocked = demand.copy(), stocked.copy()
        out: list[Found] = []
        for k in order:
            found = sheets[k]
            if shares[k] <= 1e-9 or len(out) >= many:
                break
            copies = max(1, int(shares[k] + 1e-6))
            while copies and stocked[found.stock] > 0 and len(out) < max(many, copies):
                if out and np.any(found.counts > demand):
                    break
                out.append(found)
                demand = np.maximum(demand - found.counts, 0.0)
                stocked[found.stock] -= 1
                copies -= 1
        return out

    def _mended(self, area: Array, last: float) -> bool:
        """Lay the pieces of some sheets out anew; whether the best layout is cheaper for it."""
        pool, sheets = self.pool, self._best
        held, left = [], pool.demand.copy()
        for found in sheets:  # what each holds of what the ones before do not
            held.append(np.minimum(found.counts, left))
            left = left - held[-1]
        order = pool.random.permutation(len(sheets))
        pieces = np.cumsum([held[k].sum() for k in order])
        given = order[: max(2, int(np.searchsorted(pieces, GIVEN_UP)))]
        demand = np.sum([held[k] for k in given], axis=0)
        stocked = pool.stocked - np.bincount(
            [f.stock for k, f in enumerate(sheets) if k not in given], minlength=len(pool.costs)
        )
        now = float(sum(pool.costs[sheets[k].stock] for k in given))
        large = float(pool.random.choice(LARGE))
        self._filled(area**large, demand, stocked, MENDING, last)
        seconds = float(np.clip(last - time.monotonic(), 0.1, CHOOSING))
        anew = pool.choice(demand, stocked, now, seconds)
        cost = float(sum(pool.costs[found.stock] for found in anew))
        if not anew or np.any(np.sum([f.counts for f in anew], axis=0) < demand) or cost > now:
            return False
        self._best = [f for k, f in enumerate(sheets) if k not in given] + anew
        return cost < now * (1.0 - 1e-9)
