"""Sheet after sheet, each the best of some tries on every stock.

Glossary
--------
worth
    Of every kind of piece: its area to some power above 1, so that large pieces come first and
    small ones are left for the last sheets.
held
    What a sheet of a layout holds of what the sheets before it do not.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array
from fabgeo.sheets.sheetpool import Found, SheetPool

LARGE = (1.0, 1.15, 1.3)  # exponents of the area: how much large pieces come first


@dataclass(frozen=True)
class Wanted:
    """Pieces that are to be laid out: how many of every kind, and of every stock's sheets."""

    demand: Array
    stocked: Array


def filled(
    pool: SheetPool,
    worth: Array,
    wanted: Wanted,
    tries: int,
    soon: float = np.inf,
    end: float = np.inf,
) -> list[Found]:
    """Sheets that hold what is wanted, as far as the stock lasts; the best tries join the pool.

    Parameters
    ----------
    soon, end : float
        `time.monotonic()` after which one try a stock is made, and on one stock only.
    """
    left, stocked = wanted.demand.copy(), wanted.stocked.copy()
    chosen: list[Found] = []
    while left.any():
        late = time.monotonic() > end and bool(chosen)
        tried = [
            pool.climb(k, worth, left, 1 if time.monotonic() > soon else tries)
            for k in range(len(stocked))
            if stocked[k] > 0 and not (late and k != chosen[-1].stock)
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


def held(sheets: Iterable[Found], demand: Array) -> list[Array]:
    """What each sheet holds of a demand that the ones before do not."""
    out, left = [], demand.copy()
    for found in sheets:
        out.append(np.minimum(found.counts, left))
        left = left - out[-1]
    return out


def cost_of(pool: SheetPool, sheets: Sequence[Found]) -> float:
    """What the sheets cost."""
    return float(sum(pool.costs[found.stock] for found in sheets))
