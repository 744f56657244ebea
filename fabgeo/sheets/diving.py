"""Column generation: the cheapest mix of sheets, and layouts that dives take from it.

Glossary
--------
mix, pool, price
    See `fabgeo.sheets.mix` and `fabgeo.sheets.sheetpool`.
dive
    Sheets with the largest shares in the mix are fixed, a few at a time, and sheets are looked for
    anew for what is left, until nothing is left.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from fabgeo.arrays import Array
from fabgeo.sheets.mix import Mix
from fabgeo.sheets.sheetpool import Found, SheetPool

DIVING = 2  # rounds before sheets are fixed
AT_LEAST = 2  # sheets that a dive fixes at a time
STALLED, LEAST_GAIN = 12, 1e-3  # rounds that have to make the mix cheaper by this share
STEP_ROUNDS = 20  # rounds of the mix a step
MIXING = 0.6  # share of the time for the mix before the dives


class Dives:
    """Dives into the sheets of a pool, which grows by what they look for.

    Parameters
    ----------
    end : float
        `time.monotonic()` to stop at; without effect where `steps` are given.
    steps : int, optional
        Dives, after so many times `STEP_ROUNDS` rounds of the mix: reproducible.
    """

    def __init__(self, pool: SheetPool, end: float, steps: int | None = None) -> None:
        self.pool, self.end, self.steps = pool, end, steps

    def layouts(self) -> Iterator[list[Found]]:
        """The sheets of each dive; until nothing new is found."""
        now, dives = time.monotonic(), 0
        self._mix_until(now + MIXING * (self.end - now))
        while dives < self.steps if self.steps is not None else not self._over():
            before = len(self.pool)
            yield self._dive()
            dives += 1
            if len(self.pool) == before and dives > 1:
                return

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

    def _dive(self) -> list[Found]:
        """Fix sheets of the mix, a few at a time; look for sheets for what is left."""
        pool = self.pool
        demand, stocked = pool.demand.copy(), pool.stocked.copy()
        chosen: list[Found] = []
        step = 0.0
        while demand.any():
            start = time.monotonic()
            mix = pool.mix(demand, stocked)
            for _ in range(DIVING):
                if self._over() or not pool.look(mix, demand, stocked):
                    break
                mix = pool.mix(demand, stocked)
            step = max(0.5 * step, time.monotonic() - start)
            many = AT_LEAST
            if self.steps is None:
                turns = max(1.0, (self.end - time.monotonic()) / step)
                many = max(many, int(np.ceil(mix.shares.sum() / turns)))
            fixed = self._fixed(mix, demand, stocked, many)
            if not fixed:
                break
            for found in fixed:
                chosen.append(found)
                demand = np.maximum(demand - found.counts, 0.0)
                stocked[found.stock] -= 1
        return chosen

    def _over(self) -> bool:
        return self.steps is None and time.monotonic() > self.end

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
