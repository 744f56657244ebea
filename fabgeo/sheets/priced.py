"""Sheets of the other engine, sought at the prices of the mix: a thread of its own.

Glossary
--------
offer
    What sheets are sought for: a price and a number of every kind, and the stocks there are. The
    mix makes the offers; until it does, the prices are the areas.
candidates
    A few times what a sheet holds, drawn by price a square millimetre: the engine places those of
    most price (a knapsack).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from queue import Queue
from threading import Event, Thread
from typing import TYPE_CHECKING

import numpy as np

from fabgeo.arrays import Array
from fabgeo.sheets.packing import pack_sheet
from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.shelf import fits
from fabgeo.sheets.stock import Placement, Stock

if TYPE_CHECKING:
    from fabgeo.sheets.nest import Rules

OFFERED = 2.7  # areas of a sheet that its candidates fill
FEWEST, MOST = 12, 32  # candidates
QUEUES = (4, 8, 16)  # of the engine's tree search
NOISE = (0.1, 0.2, 0.4)  # of the drawn prices, as the logarithm's deviation
LAST = 0.3  # seconds: less is not worth a call


@dataclass(frozen=True)
class _Offer:
    """Prices and numbers of all kinds, costs of a sheet of every stock (infinite: none left)."""

    prices: Array
    demand: Array
    costs: Array


class Priced:
    """The engine in its thread, from `with` to the end of it.

    Parameters
    ----------
    kinds : sequence of Piece
    sound : callable
        The exact check of one sheet.
    end : float
        `time.monotonic()` to stop at.
    """

    def __init__(
        self,
        kinds: Sequence[Piece],
        rules: Rules,
        sound: Callable[[Stock, list[Placement]], bool],
        end: float,
        seed: int = 0,
    ) -> None:
        self.kinds, self.rules, self.sound, self.end = kinds, rules, sound, end
        self._areas = np.array([piece.area for piece in kinds])
        self._fits = np.array([[fits(p, s, rules.margin) for p in kinds] for s in rules.stocks])
        self._random = np.random.default_rng(seed)
        self._found: Queue[tuple[int, list[Placement]]] = Queue()
        self._offer: _Offer | None = None
        self._stop = Event()
        self._thread = Thread(target=self._run, daemon=True)

    def __enter__(self) -> Priced:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    def offer(self, prices: Array, demand: Array, costs: Array) -> None:
        """What to look for from now on."""
        self._offer = _Offer(prices, demand, costs)

    def taken(self) -> list[tuple[int, list[Placement]]]:
        """Sheets found since this was last asked: stock's number and placements."""
        return [self._found.get() for _ in range(self._found.qsize())]

    def _run(self) -> None:
        turn = 0
        while not self._stop.is_set() and time.monotonic() + LAST < self.end:
            offer, turn = self._offer, turn + 1
            if offer is None or not np.isfinite(offer.costs).any():
                self._stop.wait(0.05)
                continue
            open_ = np.flatnonzero(np.isfinite(offer.costs))
            k = int(open_[turn % len(open_)])
            placed = self._sheet(k, offer)
            if placed and self.sound(self.rules.stocks[k], placed):
                self._found.put((k, placed))

    def _sheet(self, k: int, offer: _Offer) -> list[Placement]:
        """As much price as possible on a sheet of one stock."""
        rules, random = self.rules, self._random
        stock, areas = rules.stocks[k], self._areas
        noise = random.normal(0.0, random.choice(NOISE), len(areas))
        able = self._fits[k] & (offer.demand > 0) & (offer.prices > 0.0)
        dense = np.where(able, offer.prices / areas * np.exp(noise), 0.0)
        order = np.repeat(np.arange(len(areas)), np.where(able, offer.demand, 0).astype(int))
        order = order[np.argsort(-dense[order], kind="stable")]
        few = int(np.searchsorted(np.cumsum(areas[order]), OFFERED * stock.length * stock.width))
        chosen = order[: int(np.clip(few, FEWEST, MOST))]
        if not len(chosen):
            self._stop.wait(0.05)
            return []
        return pack_sheet(
            [self.kinds[i] for i in chosen],
            stock,
            rules.spacing,
            rules.margin,
            max(LAST, self.end - time.monotonic()),
            int(random.choice(QUEUES)),
            offer.prices[chosen].tolist(),
        )
