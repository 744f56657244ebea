"""All pieces on the cheapest set of sheets: column generation over dropped sheets.

Glossary
--------
pool
    Sheets found so far. A layout is a choice of them that holds every piece at least once; a piece
    that is held twice is left out of one.
price
    What one more piece of a kind would cost in the cheapest mix of the pool's sheets: the dual of
    the linear programme (Gilmore and Gomory 1961). A sheet whose pieces are priced higher than the
    sheet itself makes the mix cheaper: such sheets are looked for.
dive
    Sheets with the largest shares in the mix are fixed, a few at a time, and sheets are looked for
    anew for what is left, until nothing is left.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from fabgeo.arrays import Array
from fabgeo.sheets.drop import drop_sheet, placements, profiles
from fabgeo.sheets.mix import Index, Mix, cheapest_choice, cheapest_mix
from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.shelf import Layout
from fabgeo.sheets.stock import Placement, remaining

if TYPE_CHECKING:
    from fabgeo.sheets.nest import Rules

KEEN = (1.0, 1.5, 2.0, 3.0)  # exponents of the worth against the room taken
A_ROUND = 48  # sheets looked for between two programmes
REDROPPED = 0.5  # share of them that begin with pieces of a sheet of the mix
DIVING = 2  # rounds before sheets are fixed
MIXING, CHOOSING = 0.3, 0.1  # shares of the time for the mix and for the last choice
MIXING_SIZES = 0.6  # for the mix of several stock sizes: more sheets are worth having there
STALLED, LEAST_GAIN = 12, 1e-3  # rounds that have to make the mix cheaper by this share
STEP_ROUNDS = 20  # rounds of the mix a step
MOST = 4000  # sheets in the pool
AT_LEAST = 2  # sheets that a dive fixes at a time
BATCH, GIVEN_UP = 240, 2  # pieces of a batch, and sheets of it that the next one takes over
FEW = 60  # kinds of pieces whose last choice is made where steps are given


@dataclass(frozen=True)
class _Found:
    """A sheet of the pool: its stock's number, how many of each kind, and where they lie."""

    stock: int
    counts: Array
    placed: tuple[Placement, ...]
    rows: tuple[int, ...] = ()  # of its profiles, as they were dropped


class Cover:
    """The pool of one group of pieces and what is made of it.

    Parameters
    ----------
    pieces : sequence of Piece
        As often as they are asked for; each fits some stock.
    end : float
        `time.monotonic()` to stop at; without effect of it where `steps` are given.
    steps : int, optional
        Dives, after so many times `STEP_ROUNDS` rounds of the mix: reproducible.
    others : callable, optional
        Layouts found elsewhere since it was last asked: their sheets join the pool.
    """

    def __init__(
        self,
        pieces: Sequence[Piece],
        rules: Rules,
        end: float,
        seed: int = 0,
        steps: int | None = None,
        others: Callable[[], list[Layout]] | None = None,
    ) -> None:
        self.kinds = list({piece.mark: piece for piece in pieces}.values())
        self._number = {piece.mark: k for k, piece in enumerate(self.kinds)}
        self.demand = np.zeros(len(self.kinds))
        for piece in pieces:
            self.demand[self._number[piece.mark]] += 1
        self.rules, self.end, self.steps = rules, end, steps
        self._others = others or (lambda: [])
        self._random = np.random.default_rng(seed)
        self._made = [profiles(self.kinds, s, rules.spacing, rules.margin) for s in rules.stocks]
        self._costs = np.array([stock.price for stock in rules.stocks])
        few = [np.inf if s.quantity is None else s.quantity for s in rules.stocks]
        self._stocked = np.array(few, dtype=np.float64)
        self._pool: list[_Found] = []
        self._best = np.inf
        self._known: set[tuple[int, bytes]] = set()

    def layouts(self) -> Iterator[Layout]:
        """Ever cheaper layouts (not each is cheaper than the one before)."""
        area = np.array([piece.area for piece in self.kinds])
        for keen in KEEN:
            yield self._greedy(area, keen)
            if self._late(0.1):
                return
        start = time.monotonic()
        share = MIXING if len(self.rules.stocks) == 1 else MIXING_SIZES
        self._mix_until(start + share * (self.end - start))
        last = self.end - CHOOSING * (self.end - start)
        dives = 0
        while dives < self.steps if self.steps is not None else time.monotonic() < last:
            before = len(self._pool)
            yield self._dive(last)
            dives += 1
            if len(self._pool) == before and dives > 1:
                break  # nothing new is found: the choice is left
        for layout in self._others():
            self._join(layout)
        if not self._late(0.5) and (self.steps is None or len(self.kinds) <= FEW):
            yield self._choice()

    def _late(self, seconds: float) -> bool:
        return self.steps is None and time.monotonic() + seconds > self.end

    def _greedy(self, worth: Array, keen: float) -> Layout:
        """Sheet after sheet, each of the stock that is filled best for its price."""
        left, stocked = self.demand.copy(), self._stocked.copy()
        chosen: list[_Found] = []
        while left.any():
            tried = [
                self._drop(k, worth, left, keen)
                for k in range(len(self._made))
                if stocked[k] > 0 and not (self._late(0.0) and chosen and k != chosen[-1].stock)
            ]
            tried = [found for found in tried if found.placed]
            if not tried:
                break
            best = max(tried, key=lambda found: found.counts @ worth / self._costs[found.stock])
            for found in tried:
                self._keep(found)
            chosen.append(best)
            left = np.maximum(left - best.counts, 0.0)
            stocked[best.stock] -= 1
        return self._layout(chosen)

    def _drop(
        self, stock: int, worth: Array, left: Array, keen: float, begin: Sequence[int] = ()
    ) -> _Found:
        made, rules = self._made[stock], self.rules
        sheet = drop_sheet(made, worth, left, self._random, keen, begin)
        rows = np.array([row for row, _, _ in sheet], dtype=np.intp)
        counts = np.bincount(made.piece[rows], minlength=len(self.kinds)).astype(np.float64)
        placed = placements(made, sheet, self.kinds, rules.spacing, rules.margin)
        return _Found(stock, counts, tuple(placed), tuple(rows.tolist()))

    def _keep(self, found: _Found) -> bool:
        key = (found.stock, found.counts.astype(np.int32).tobytes())
        if not found.placed or key in self._known:
            return False
        self._known.add(key)
        self._pool.append(found)
        return True

    def _join(self, layout: Layout) -> None:
        names = {stock.name: k for k, stock in enumerate(self.rules.stocks)}
        for stock, placed in layout:
            counts = np.zeros(len(self.kinds))
            for placement in placed:
                counts[self._number[placement.mark]] += 1
            self._keep(_Found(names[stock.name], counts, tuple(placed)))

    def _mix_until(self, end: float) -> None:
        """Look for sheets that make the mix cheaper until that stalls."""
        costs: list[float] = []
        while len(costs) < (self.steps or 0) * STEP_ROUNDS or (
            self.steps is None and time.monotonic() < end
        ):
            mix = self._mix(self.demand, self._stocked)
            costs.append(mix.cost)
            if len(costs) > STALLED and mix.cost > (1.0 - LEAST_GAIN) * costs[-1 - STALLED]:
                return
            self._look(mix, self.demand, self._stocked)

    def _look(self, mix: Mix, demand: Array, stocked: Array) -> int:
        """Sheets priced higher than they cost; their number.

        Half of them are made anew, half from sheets of the mix: some pieces taken out, the others
        dropped in another order, the rest filled up.
        """
        found = 0
        stocks = [k for k in range(len(self._made)) if stocked[k] > 0]
        mixed = [k for k in np.flatnonzero(mix.shares > 1e-6) if self._pool[k].rows]
        for turn in range(A_ROUND):
            stock, begin = stocks[turn % len(stocks)], []
            if mixed and self._random.random() < REDROPPED:
                old = self._pool[mixed[int(self._random.integers(len(mixed)))]]
                stock = old.stock if stocked[old.stock] > 0 else stock
                if stock == old.stock:
                    order = self._random.permutation(len(old.rows))
                    out = 1 + int(self._random.integers(max(1, len(order) // 2)))
                    begin = [old.rows[int(k)] for k in order[out:]]
            keen = float(self._random.choice(KEEN))
            sheet = self._drop(stock, mix.prices, demand, keen, begin)
            cost = self._costs[stock] + mix.dues[stock]
            if sheet.counts @ mix.prices > cost * (1.0 + 1e-6):
                found += self._keep(sheet)
        return found

    def _mix(self, demand: Array, stocked: Array) -> Mix:
        self._thin()
        return cheapest_mix(self._counts(), self._own(), self._costs, demand, stocked)

    def _counts(self) -> Array:
        return np.array([found.counts for found in self._pool])

    def _own(self) -> Index:
        return np.array([found.stock for found in self._pool], dtype=np.intp)

    def _thin(self) -> None:
        """Keep the pool small: the sheets that are nearest to being used."""
        if len(self._pool) <= MOST:
            return
        counts, own = self._counts(), self._own()
        mix = cheapest_mix(counts, own, self._costs, self.demand, self._stocked)
        excess = self._costs[own] + mix.dues[own] - counts @ mix.prices
        kept = np.sort(np.argsort(excess, kind="stable")[: MOST // 2])
        self._pool = [self._pool[k] for k in kept]

    def _dive(self, last: float) -> Layout:
        """Fix sheets of the mix, a few at a time; look for sheets for what is left."""
        demand, stocked = self.demand.copy(), self._stocked.copy()
        chosen: list[_Found] = []
        step = 0.0
        while demand.any():
            start = time.monotonic()
            mix = self._mix(demand, stocked)
            for _ in range(DIVING):
                if self._over(last) or not self._look(mix, demand, stocked):
                    break
                mix = self._mix(demand, stocked)
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
        return self._layout(chosen)

    def _over(self, last: float) -> bool:
        return self.steps is None and time.monotonic() > last

    def _fixed(self, mix: Mix, demand: Array, stocked: Array, many: int) -> list[_Found]:
        """Sheets of the largest shares that hold nothing twice; the first in any case."""
        held = np.array([float(np.minimum(f.counts, demand).sum()) for f in self._pool])
        order = np.argsort(-(mix.shares + 1e-6 * held), kind="stable")
        demand, stocked = demand.copy(), stocked.copy()
        out: list[_Found] = []
        for k in order:
            found = self._pool[k]
            if mix.shares[k] <= 1e-9 or len(out) >= many:
                break
            copies = max(1, int(mix.shares[k] + 1e-6))
            while copies and stocked[found.stock] > 0 and len(out) < max(many, copies):
                if out and np.any(found.counts > demand):
                    break
                out.append(found)
                demand = np.maximum(demand - found.counts, 0.0)
                stocked[found.stock] -= 1
                copies -= 1
        return out

    def _choice(self) -> Layout:
        """The cheapest whole sheets of the pool that hold all.

        A sheet whose excess over its pieces' prices is more than the best layout costs over the
        mix is in no better one.
        """
        mix, counts, own = self._mix(self.demand, self._stocked), self._counts(), self._own()
        excess = self._costs[own] + mix.dues[own] - counts @ mix.prices
        (near,) = np.nonzero(excess <= self._best - mix.cost + 1e-9 * mix.cost)
        if not len(near):
            return []
        seconds = None if self.steps is not None else max(0.1, self.end - time.monotonic())
        times = cheapest_choice(
            counts[near], own[near], self._costs, self.demand, self._stocked, seconds
        )
        return self._layout(
            [self._pool[k] for k, n in zip(near, times, strict=True) for _ in range(n)]
        )

    def _layout(self, chosen: Sequence[_Found]) -> Layout:
        """Sheets with every piece as often as it is asked for."""
        left = self.demand.copy()
        layout: Layout = []
        for found in sorted(chosen, key=lambda found: -float(found.counts.sum())):
            kept = []
            for placement in found.placed:
                kind = self._number[placement.mark]
                if left[kind] > 0:
                    left[kind] -= 1
                    kept.append(placement)
            if kept:
                layout.append((self.rules.stocks[found.stock], kept))
        if not left.any():
            self._best = min(self._best, sum(stock.price for stock, _ in layout))
        return layout


def batched(
    pieces: Sequence[Piece], rules: Rules, end: float, seed: int, steps: int | None
) -> Layout:
    """Many pieces, some at a time: a batch's worst sheets are given up to the next."""
    random = np.random.default_rng(seed)
    waiting = [pieces[int(k)] for k in random.permutation(len(pieces))]
    areas = {piece.mark: piece.area for piece in pieces}
    layout: Layout = []
    while waiting:
        now, some = time.monotonic(), waiting[:BATCH]
        share = len(some) / len(waiting)
        cover = Cover(some, rules, now + share * max(0.0, end - now), seed, steps)
        best = min(cover.layouts(), key=partial(_shortfall, len(some)))
        waiting = waiting[BATCH:]
        if not best:
            break
        if waiting:
            best = sorted(best, key=lambda s: sum(areas[p.mark] for p in s[1]) / s[0].price)
            by_mark = {piece.mark: piece for piece in some}
            few = min(GIVEN_UP, len(best) // 4)
            given_up = [by_mark[p.mark] for _, placed in best[:few] for p in placed]
            del best[:few]
            waiting = given_up + waiting
        layout += best
        rules = replace(rules, stocks=tuple(remaining(rules.stocks, best)))
    return layout


def _shortfall(count: int, layout: Layout) -> tuple[int, float]:
    return count - sum(len(placed) for _, placed in layout), sum(s.price for s, _ in layout)
