"""The search for the cheapest joint choice: candidates, sweeps, the choice among all of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fabgeo.arrays import Array, BoolArray, IntArray
from fabgeo.panels.candidates import allowed, measured, own_candidates, targets_of
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.certify import deviation
from fabgeo.panels.coordinate import Coordination
from fabgeo.panels.distinct import Distinct
from fabgeo.panels.fit_shape import fit
from fabgeo.panels.integer import IntegerChoice, solve
from fabgeo.panels.joints import joints_of
from fabgeo.panels.limits import Costs, Tolerances
from fabgeo.panels.pairs import Pairs, greedy, pairs_of
from fabgeo.panels.pool import CLASSES
from fabgeo.panels.radii import fewest, multiples, nearest
from fabgeo.panels.samples import PanelInput

_FITTED = len(CLASSES) - 1
_FINE = 0.05  # of the gap limit: candidates closer than that are one


class Search:
    """Pool, pairs and current choice while they grow."""

    def __init__(
        self,
        panels: Sequence[PanelInput],
        tolerances: Tolerances,
        costs: Costs,
        seconds: float | None = None,
    ) -> None:
        self.tolerances, self.costs, self.seconds = tolerances, costs, seconds
        self.own = own_candidates(panels, tolerances)
        self.pool, self.samples = self.own.pool, self.own.samples
        self.radii: Array = np.zeros(0)
        self.distinct = Distinct(self.samples, _FINE * tolerances.gap_mm)
        # Random numbers that stand for candidates: sums of them tell sets apart.
        self.names = np.random.default_rng(0).integers(1, 2**63, 2**20, dtype=np.uint64)
        self.tried: dict[int, NDArray[np.uint64]] = {}
        self.patches = [panel.patch for panel in panels]
        self.joints = joints_of(panels)
        self.coordination = Coordination(self.samples, self.joints, tolerances)
        self.pairs: Pairs = pairs_of(self.pool, self.joints, tolerances)
        self.current: IntArray = greedy(self.pool, self.pairs, costs)

    @property
    def cost(self) -> float:
        """Cost of the current choice."""
        return float(self.costs.of(self.pool)[self.current].sum())

    @property
    def proven(self) -> bool:
        """Whether no choice can cost less: every panel has its cheapest class."""
        return self.cost <= float(self.floors.sum()) + 1e-9

    @property
    def floors(self) -> Array:
        """Least cost (p,) by the deviation of each panel alone."""
        return np.where(self.own.possible, self.costs.by_kind, np.inf).min(axis=1)

    def limit_radii(self, radii: Sequence[float] | int | None, step: float | None = None) -> None:
        """From here on cylinders have one of few radii; those that have not are dropped.

        Parameters
        ----------
        radii : sequence of float, int or None
            The radii, mm, or how many different ones at most.
        step : float, optional
            Radii are multiples of it.
        """
        k = CLASSES.index("cylinder")
        best = self.own.fits[k]
        if radii is None or isinstance(radii, int):
            off, _ = deviation(self.samples, best)
            arc = np.linalg.norm(self.samples.edges[1], axis=-1).mean(axis=(1, 2))
            slack = 16.0 * (self.tolerances.deviation_mm - off) / arc**2
            able = self.own.possible[:, k] & (slack > 0.0) & (best.k != 0.0)
            if not able.any():
                return
            if radii is None:
                found = 1.0 / np.abs(best.k[able])
            else:
                found = fewest(best.k[able], slack[able], radii)
            self.radii = found if step is None else multiples(found, step)
        else:
            self.radii = np.array(radii, dtype=float)
        self.coordination.radii = self.radii
        self.pool = self.pool[np.flatnonzero(self.pool.kind != k)]
        self.distinct = Distinct(self.samples, _FINE * self.tolerances.gap_mm)
        everyone = np.arange(len(self.samples))
        for near in self.rolled(everyone, best):
            self.add(everyone, k, near)
        self.pairs = pairs_of(self.pool, self.joints, self.tolerances)
        self.current = greedy(self.pool, self.pairs, self.costs)

    def rolled(self, index: IntArray, guess: Carriers) -> list[Carriers]:
        """Cylinders of the allowed radii next to their own, fitted, one a panel of all."""
        samples, size = self.samples[index], self.samples.size[index]
        out = []
        for edge in (None, self.tolerances.gap_mm / 2.0):
            start = guess[index]
            start = Carriers(start.origin, start.frame, nearest(start.k, self.radii), 0.0 * start.g)
            targets = targets_of(
                samples, self.tolerances.deviation_mm, edge, None, np.zeros((1, 1))
            )
            placed = fit(targets, start, "rolled", size)
            out.append(scatter(guess, index, placed))
        return out

    def settle(self, sweeps: int = 2) -> None:
        """Sweep from what would be cheapest, and from each class wherever it is possible."""
        cost = np.where(self.own.possible, self.costs.by_kind, np.inf)
        cheapest = cost.argmin(axis=1)
        starts = [cheapest]
        for k in range(1, _FITTED):
            starts.append(np.where(self.own.possible[:, k], np.maximum(cheapest, k), _FITTED))
        for kind in starts:
            carriers = self.own.closest(kind)
            for _ in range(sweeps):
                carriers = self.coordination.sweep(carriers, kind, kind != _FITTED)
            for k in range(_FITTED):
                self.add(np.flatnonzero(kind == k), k, carriers)

    def widen(self) -> bool:
        """New candidates against the neighbours as chosen; whether there are any."""
        before = len(self.pool)
        kind = self.pool.kind[self.current]
        carriers = self.pool.carriers[self.current]
        price = self.costs.by_kind
        for k in range(_FITTED):
            cheaper = self.own.possible[:, k] & (price[k] < price[kind]) & self._moved(k)
            index = np.flatnonzero(cheaper)
            if len(index) == 0:
                continue
            guess = self.own.closest(np.full(len(kind), k, dtype=np.int64))
            stand = carriers.where(~cheaper, guess)
            # Against the neighbours as they are chosen now, then all of them moving together.
            placed = self.coordination.fitted(index, k, guess, kind, carriers)
            self.add(index, k, scatter(carriers, index, placed))
            mixed = np.where(cheaper, k, kind)
            stand = scatter(stand, index, placed)
            stand = self.coordination.sweep(stand, mixed, mixed != _FITTED)
            for each in range(_FITTED):
                self.add(np.flatnonzero(mixed == each), each, stand)
        return len(self.pool) > before

    def _moved(self, k: int) -> BoolArray:
        """Panels some of whose neighbours stand otherwise than when class k was last tried."""
        around = np.zeros(len(self.samples), dtype=np.uint64)
        names = self.names[self.current % len(self.names)]
        for side in (0, 1):
            panel, other = self.joints.panels[:, side], self.joints.panels[:, 1 - side]
            np.add.at(around, panel, names[other])
        moved = around != self.tried.get(k, np.zeros_like(around))
        self.tried[k] = around
        return moved

    def choose(self, since: int = 0) -> IntegerChoice:
        """Solve the integer programme over the pool as it is.

        Parameters
        ----------
        since : int
            Among the candidates from this one on, and those that are chosen now.
        """
        self.pairs = pairs_of(self.pool, self.joints, self.tolerances, self.pairs)
        index = np.union1d(self.current, np.arange(since, len(self.pool)))
        result = solve(
            self.pool.panel[index],
            self.costs.of(self.pool)[index],
            self.pairs.among(index),
            np.searchsorted(index, self.current),
            self.seconds,
        )
        self.current = index[result.chosen]
        return result

    def add(self, index: IntArray, k: int, carriers: Carriers) -> None:
        """Placements of class k, of `carriers` (one a panel of all) those of some panels.

        Cylinders have allowed radii by then.
        """
        if len(index) == 0:
            return
        found = measured(index, k, carriers[index], self.samples[index], self.tolerances)
        both = self.pool.with_more(allowed(found, self.patches, self.tolerances))
        self.pool = both[self.distinct.kept(both, len(self.pool))]


def scatter(carriers: Carriers, index: IntArray, values: Carriers) -> Carriers:
    """The carriers with those at an index replaced."""
    arrays: list[Array] = []
    for name in ("origin", "frame", "k", "g"):
        array = np.array(getattr(carriers, name))
        array[index] = getattr(values, name)
        arrays.append(array)
    return Carriers(*arrays)
