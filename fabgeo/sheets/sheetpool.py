"""The pool of sheets found so far for one group of pieces, and how more are found.

Glossary
--------
kind
    Pieces of one mark; the demand is how many of each are asked for.
pool
    Sheets found so far. A layout is a choice of them that holds every piece at least once; a piece
    that is held twice is left out of one.
price
    What one more piece of a kind would cost in the cheapest mix of the pool's sheets: the dual of
    the linear programme (Gilmore and Gomory 1961). A sheet whose pieces are priced higher than the
    sheet itself makes the mix cheaper: such sheets are looked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fabgeo.arrays import Array
from fabgeo.sheets.drop import drop_sheet, placements, profiles
from fabgeo.sheets.mix import Index, Mix, cheapest_choice, cheapest_mix
from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.shelf import Layout
from fabgeo.sheets.stock import Placement

if TYPE_CHECKING:
    from fabgeo.sheets.nest import Rules

KEEN = (1.0, 1.5, 2.0, 3.0)  # exponents of the worth against the room taken
A_ROUND = 48  # sheets looked for between two programmes
REDROPPED = 0.5  # share of them that begin with pieces of a sheet of the mix
MOST = 4000  # sheets in the pool


@dataclass(frozen=True)
class Found:
    """A sheet of the pool: its stock's number, how many of each kind, and where they lie."""

    stock: int
    counts: Array
    placed: tuple[Placement, ...]
    rows: tuple[int, ...] = ()  # of its profiles, as they were dropped


class SheetPool:
    """The pool of one group of pieces.

    Parameters
    ----------
    pieces : sequence of Piece
        As often as they are asked for; each fits some stock.
    """

    def __init__(self, pieces: Sequence[Piece], rules: Rules, seed: int = 0) -> None:
        self.kinds = list({piece.mark: piece for piece in pieces}.values())
        self._number = {piece.mark: k for k, piece in enumerate(self.kinds)}
        self.demand = np.zeros(len(self.kinds))
        for piece in pieces:
            self.demand[self._number[piece.mark]] += 1
        self.rules = rules
        self.random = np.random.default_rng(seed)
        self.areas = np.array([piece.area for piece in self.kinds])
        self.sizes = np.array([stock.length * stock.width for stock in rules.stocks])
        self.costs = np.array([stock.price for stock in rules.stocks])
        few = [np.inf if s.quantity is None else s.quantity for s in rules.stocks]
        self.stocked = np.array(few, dtype=np.float64)
        self.sheets: list[Found] = []
        self._made = [profiles(self.kinds, s, rules.spacing, rules.margin) for s in rules.stocks]
        self._known: set[tuple[int, bytes]] = set()

    def __len__(self) -> int:
        return len(self.sheets)

    def drop(
        self, stock: int, worth: Array, left: Array, keen: float, begin: Sequence[int] = ()
    ) -> Found:
        """Fill one sheet with pieces of most worth; it does not join the pool by itself."""
        made, rules = self._made[stock], self.rules
        sheet = drop_sheet(made, worth, left, self.random, keen, begin)
        rows = np.array([row for row, _, _ in sheet], dtype=np.intp)
        counts = np.bincount(made.piece[rows], minlength=len(self.kinds)).astype(np.float64)
        placed = placements(made, sheet, self.kinds, rules.spacing, rules.margin)
        return Found(stock, counts, tuple(placed), tuple(rows.tolist()))

    def climb(self, stock: int, worth: Array, left: Array, tries: int) -> Found:
        """The sheet of most worth of some tries: the later ones change the best one before."""
        best, most = self.drop(stock, worth, left, KEEN[1]), 0.0
        for turn in range(tries):
            begin = self.partly(best) if turn >= tries // 2 else []
            keen = float(self.random.choice(KEEN))
            found = self.drop(stock, worth, left, keen, begin) if turn else best
            if (value := float(found.counts @ worth)) > most:
                best, most = found, value
        return best

    def partly(self, found: Found) -> list[int]:
        """Some pieces of a dropped sheet in another order."""
        order = self.random.permutation(len(found.rows))
        out = 1 + int(self.random.integers(max(1, len(order) // 2)))
        return [found.rows[int(k)] for k in order[out:]]

    def keep(self, found: Found) -> bool:
        """Take a sheet into the pool; whether it is new."""
        key = (found.stock, found.counts.astype(np.int32).tobytes())
        if not found.placed or key in self._known:
            return False
        self._known.add(key)
        self.sheets.append(found)
        return True

    def join(self, stock: int, placed: Sequence[Placement]) -> bool:
        """Take a sheet of the other engine; whether it is new."""
        counts = np.zeros(len(self.kinds))
        for placement in placed:
            counts[self._number[placement.mark]] += 1
        return self.keep(Found(stock, counts, tuple(placed)))

    def mix(self, demand: Array, stocked: Array) -> Mix:
        """The cheapest mix for some demand and stock."""
        self.thin()
        return cheapest_mix(self.counts(), self.own(), self.costs, demand, stocked)

    def look(self, mix: Mix, demand: Array, stocked: Array, many: int = A_ROUND) -> int:
        """Sheets priced higher than they cost; their number.

        Half of them are made anew, half from sheets of the mix: some pieces taken out, the others
        dropped in another order, the rest filled up.
        """
        found, stocks = 0, np.flatnonzero(stocked > 0).tolist()
        shares = np.append(mix.shares, np.zeros(len(self) - len(mix.shares)))
        mixed = [k for k in np.flatnonzero(shares > 1e-6) if self.sheets[k].rows]
        for turn in range(many):
            stock, begin = stocks[turn % len(stocks)], []
            if mixed and self.random.random() < REDROPPED:
                old = self.sheets[mixed[int(self.random.integers(len(mixed)))]]
                stock = old.stock if stocked[old.stock] > 0 else stock
                if stock == old.stock:
                    begin = self.partly(old)
            keen = float(self.random.choice(KEEN))
            sheet = self.drop(stock, mix.prices, demand, keen, begin)
            cost = self.costs[stock] + mix.dues[stock]
            if sheet.counts @ mix.prices > cost * (1.0 + 1e-6):
                found += self.keep(sheet)
        return found

    def counts(self) -> Array:
        """How many of each kind every sheet of the pool holds."""
        return np.array([found.counts for found in self.sheets])

    def own(self) -> Index:
        """Number of every sheet's stock."""
        return np.array([found.stock for found in self.sheets], dtype=np.intp)

    def choice(
        self, demand: Array, stocked: Array, below: float, seconds: float | None
    ) -> list[Found]:
        """The cheapest whole sheets of the pool that hold a demand for less than `below`.

        A sheet whose excess over its pieces' prices is more than `below` is over the mix is in no
        such choice.
        """
        mix, counts, own = self.mix(demand, stocked), self.counts(), self.own()
        excess = self.costs[own] + mix.dues[own] - counts @ mix.prices
        (near,) = np.nonzero(excess <= below - mix.cost + 1e-9 * mix.cost)
        if not len(near):
            return []
        times = cheapest_choice(counts[near], own[near], self.costs, demand, stocked, seconds)
        return [self.sheets[k] for k, n in zip(near, times, strict=True) for _ in range(n)]

    def layout(self, chosen: Sequence[Found]) -> Layout:
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
        return layout

    def thin(self, most: int = MOST) -> None:
        """Keep the pool small: the sheets that are nearest to being used."""
        if len(self.sheets) <= most:
            return
        counts, own = self.counts(), self.own()
        mix = cheapest_mix(counts, own, self.costs, self.demand, self.stocked)
        excess = self.costs[own] + mix.dues[own] - counts @ mix.prices
        kept = np.sort(np.argsort(excess, kind="stable")[: most // 2])
        self.sheets = [self.sheets[k] for k in kept]
