"""All panels chosen together: the least sum of costs within every limit.

Candidates come first: every panel by itself, then sweeps in which neighbours settle on common
boundaries. The integer programme chooses among them; then every panel that might still be cheaper
is fitted against the neighbours as chosen, and the programme is solved again, until nothing is
gained. What this reaches is compared with two proven figures: the solver's bound among the
candidates, and the floor below which no placement at all can come.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fabgeo.arrays import Array, BoolArray, IntArray
from fabgeo.panels.candidates import allowed, measured, own_candidates, targets_of
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.certify import deviation
from fabgeo.panels.classify import PanelChoice, describe
from fabgeo.panels.coordinate import Coordination
from fabgeo.panels.distinct import Distinct
from fabgeo.panels.fit_shape import fit
from fabgeo.panels.forming import Sheet
from fabgeo.panels.integer import IntegerChoice, solve
from fabgeo.panels.joints import joints_of
from fabgeo.panels.limits import Costs, Tolerances
from fabgeo.panels.pairs import Pairs, greedy, pairs_of
from fabgeo.panels.pool import CLASSES
from fabgeo.panels.radii import fewest, nearest
from fabgeo.panels.samples import PanelInput

_FITTED = len(CLASSES) - 1
_FINE = 0.05  # of the gap limit: candidates closer than that are one


@dataclass(frozen=True)
class JointChoice:
    """The panels chosen together, and what that is worth.

    Attributes
    ----------
    panels : tuple of PanelChoice
    cost : float
        Sum of the chosen classes' costs.
    bound : float
        Proven by the solver: no choice among the candidates costs less.
    floor : float
        Every panel in the cheapest class that its deviation alone allows, whatever that does to
        its neighbours: no choice of any placements costs less.
    one_by_one : float
        Cost of the choice panel by panel under the same limits (`classify`).
    candidates : int
        Size of the pool.
    status : str
        "optimal" (among the candidates) or "time limit".
    history : tuple of float
        Cost after each round.
    seconds : float
    """

    panels: tuple[PanelChoice, ...]
    cost: float
    bound: float
    floor: float
    one_by_one: float
    candidates: int
    status: str
    history: tuple[float, ...]
    seconds: float

    @property
    def saving(self) -> float:
        """Share of the panel-by-panel cost that the joint choice saves."""
        return 1.0 - self.cost / self.one_by_one


def choose(
    panels: Sequence[PanelInput],
    tolerances: Tolerances | None = None,
    costs: Costs | None = None,
    sheet: Sheet | None = None,
    rounds: int = 4,
    seconds: float = 20.0,
    radii: Sequence[float] | int | None = None,
) -> JointChoice:
    """Choose the classes and placements of all panels together.

    Parameters
    ----------
    panels : sequence of PanelInput
    tolerances, costs, sheet : optional
        The project's; defaults of the hand-over contract.
    rounds : int
        Most rounds of new candidates after the first choice; they end earlier when one gains less
        than 0.05 %.
    seconds : float
        Time limit of one integer programme.
    radii : sequence of float or int, optional
        Equal radii: the radii that cylinders may have, mm, or how many different ones at most.
    """
    began = time.perf_counter()
    tolerances, costs = tolerances or Tolerances(), costs or Costs()
    search = _Search(panels, tolerances, costs, seconds)
    one_by_one = search.cost
    if radii is not None:
        search.limit_radii(radii)
    search.settle()
    history = [search.cost]
    result = search.choose()
    history.append(search.cost)
    for _ in range(rounds):
        if not search.widen():
            break
        result = search.choose()
        history.append(search.cost)
        if history[-1] > history[-2] * (1.0 - 5e-4):
            break
    chosen = describe(
        panels,
        search.own,
        search.pool,
        search.joints,
        search.current,
        tolerances,
        costs,
        sheet or Sheet(),
    )
    return JointChoice(
        panels=tuple(chosen),
        cost=search.cost,
        bound=result.bound,
        floor=search.floor,
        one_by_one=one_by_one,
        candidates=len(search.pool),
        status=result.status,
        history=tuple(history),
        seconds=time.perf_counter() - began,
    )


class _Search:
    """Pool, pairs and current choice while they grow."""

    def __init__(
        self, panels: Sequence[PanelInput], tolerances: Tolerances, costs: Costs, seconds: float
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
    def floor(self) -> float:
        """Least cost by the deviation of each panel alone."""
        cost = np.where(self.own.possible, self.costs.by_kind, np.inf)
        return float(cost.min(axis=1).sum())

    def limit_radii(self, radii: Sequence[float] | int) -> None:
        """From here on cylinders have one of few radii; those that have not are dropped."""
        k = CLASSES.index("cylinder")
        best = self.own.fits[k]
        if isinstance(radii, int):
            able = self.own.possible[:, k]
            off, _ = deviation(self.samples, best)
            arc = np.linalg.norm(self.samples.edges[1], axis=-1).mean(axis=(1, 2))
            slack = 16.0 * (self.tolerances.deviation_mm - off) / arc**2
            able &= slack > 0.0
            if not able.any():
                return
            self.radii = fewest(best.k[able], slack[able], radii)
        else:
            self.radii = np.array(radii, dtype=float)
        self.pool = self.pool[np.flatnonzero(self.pool.kind != k)]
        self.distinct = Distinct(self.samples, _FINE * self.tolerances.gap_mm)
        for near in self._rolled(np.arange(len(self.samples)), best):
            self._add_as_they_are(np.arange(len(self.samples)), k, near)
        self.pairs = pairs_of(self.pool, self.joints, self.tolerances)
        self.current = greedy(self.pool, self.pairs, self.costs)

    def _rolled(self, index: IntArray, guess: Carriers) -> list[Carriers]:
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
            out.append(_scatter(guess, index, placed))
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
                self._add(np.flatnonzero(kind == k), k, carriers)

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
            self._add(index, k, _scatter(carriers, index, placed))
            mixed = np.where(cheaper, k, kind)
            stand = _scatter(stand, index, placed)
            stand = self.coordination.sweep(stand, mixed, mixed != _FITTED)
            for each in range(_FITTED):
                self._add(np.flatnonzero(mixed == each), each, stand)
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

    def choose(self) -> IntegerChoice:
        """Solve the integer programme over the pool as it is."""
        self.pairs = pairs_of(self.pool, self.joints, self.tolerances, self.pairs)
        result = solve(
            self.pool.panel, self.costs.of(self.pool), self.pairs, self.current, self.seconds
        )
        self.current = result.chosen
        return result

    def _add(self, index: IntArray, k: int, carriers: Carriers) -> None:
        if len(index) == 0:
            return
        if len(self.radii) and k == CLASSES.index("cylinder"):
            for near in self._rolled(index, carriers):
                self._add_as_they_are(index, k, near)
        else:
            self._add_as_they_are(index, k, carriers)

    def _add_as_they_are(self, index: IntArray, k: int, carriers: Carriers) -> None:
        found = measured(index, k, carriers[index], self.samples[index])
        both = self.pool.with_more(allowed(found, self.patches, self.tolerances))
        self.pool = both[self.distinct.kept(both, len(self.pool))]


def _scatter(carriers: Carriers, index: IntArray, values: Carriers) -> Carriers:
    arrays: list[Array] = []
    for name in ("origin", "frame", "k", "g"):
        array = np.array(getattr(carriers, name))
        array[index] = getattr(values, name)
        arrays.append(array)
    return Carriers(*arrays)
