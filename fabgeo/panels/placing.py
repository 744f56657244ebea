"""Strips placed by integer programmes: what they could cost at least, and better placements."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from fabgeo.arrays import Array, BoolArray, IntArray
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.certify import deviation
from fabgeo.panels.firstorder import Boundaries, Option, option_of
from fabgeo.panels.groups import colours_of, strips_of
from fabgeo.panels.pool import CLASSES
from fabgeo.panels.programme import Decision, Group, Rim, settle_group, solve_group
from fabgeo.panels.search import Search, scatter

_FITTED = len(CLASSES) - 1
_CYLINDER = CLASSES.index("cylinder")
_WIDE = 1.03  # of the limits in a bound: more than what linear features are off
_NARROW = 0.98  # of the limits in placements that are to keep them
_SETTLE = 2  # linear programmes about the placements before
_EACH = 5.0  # seconds that one strip may take


class StripPlacing:
    """Programmes of whole strips on top of a search.

    Parameters
    ----------
    search : Search
        Whose pool the placements join.
    seconds : float
        Time for all of them together.

    Attributes
    ----------
    groups : list of (n,) int arrays
        The strips' panels.
    bounds : (g,) array
        What each strip costs at least, whatever its placements and its neighbours.
    proven : int
        Strips whose bound comes from their programme, not from their panels one by one.
    """

    def __init__(self, search: Search, seconds: float) -> None:
        self.search, self.until = search, time.perf_counter() + seconds
        self.boundaries = Boundaries(search.joints, search.tolerances)
        self.groups = strips_of(len(search.samples), search.joints)
        self.bounds = np.array([search.floors[group].sum() for group in self.groups])
        self.proven = 0
        self._options: list[Option] = []

    @property
    def costs(self) -> Array:
        """What the strips cost as chosen, (g,)."""
        cost = self.search.costs.of(self.search.pool)[self.search.current]
        return np.array([cost[group].sum() for group in self.groups])

    @property
    def late(self) -> bool:
        """Whether the time is used up."""
        return time.perf_counter() > self.until

    @property
    def options(self) -> list[Option]:
        """Every class about its closest placements, cylinders of any radius."""
        if not self._options:
            own = self.search.own
            self._options = [
                self._option(k, base, own.possible[:, k]) for k, base in enumerate(own.fits)
            ]
        return self._options

    @property
    def offered(self) -> list[Option]:
        """The same, cylinders of the nearest radius that is offered."""
        search = self.search
        if not len(search.radii):
            return self.options
        everyone = np.arange(len(search.samples))
        base = search.rolled(everyone, search.own.fits[_CYLINDER])[0]
        able = deviation(search.samples, base)[0] <= search.tolerances.deviation_mm
        return [
            self._option(k, base, able, rolled=True) if k == _CYLINDER else option
            for k, option in enumerate(self.options)
        ]

    def prove(self) -> None:
        """Raise the bounds of strips that cost more than their panels' floors."""
        open_ = np.flatnonzero(self.costs > self.bounds + 1e-6)
        found = self._decided([self._alone(self.groups[g]) for g in open_], self.options, _WIDE)
        for g, decision in zip(open_, found, strict=True):
            if decision is not None:
                self.proven += 1
                self.bounds[g] = max(self.bounds[g], decision.bound)

    def improve(self) -> bool:
        """Place strips that cost more than they must against their neighbours as chosen.

        Strips of one colour have no joint in common: they are placed at once. Whether it gained.
        """
        search, before, options = self.search, self.search.cost, self.offered
        colour = colours_of(self.groups, search.joints)
        for each in range(int(colour.max(initial=-1)) + 1):
            some = np.flatnonzero((colour == each) & (self.costs > self.bounds + 1e-6))
            if self.late:
                break
            if len(some) == 0:
                continue
            asked = [self._beside(self.groups[g]) for g in some]
            self._settle(asked, self._decided(asked, options, _NARROW), options)
            search.choose()
        return search.cost < before - 1e-9

    def _decided(
        self, groups: Sequence[Group], options: Sequence[Option], share: float
    ) -> list[Decision | None]:
        search = self.search

        def decided(group: Group) -> Decision | None:
            if self.late:
                return None
            prices = search.costs.by_kind
            return solve_group(group, options, search.joints, prices, share, _EACH)

        return _side_by_side(decided, groups)

    def _settle(
        self,
        groups: Sequence[Group],
        decisions: Sequence[Decision | None],
        decided: Sequence[Option],
    ) -> None:
        """Placements of the classes decided, from linear programmes about them in turn."""
        search = self.search
        kind = np.full(len(search.samples), _FITTED, dtype=np.int64)
        few = len(search.radii) > 0
        stand = search.own.fits[-1]
        for group, decision in zip(groups, decisions, strict=True):
            if decision is not None:
                kind[group.panels] = decision.option % len(CLASSES)
                stand = self._moved(stand, group, decided, kind, decision.steps)
        for _ in range(_SETTLE):
            options = [
                self._option(k, stand, kind == k, rolled=few and k == _CYLINDER)
                for k in range(_FITTED)
            ]

            def settled(group: Group, options: list[Option] = options) -> list[Array] | None:
                own = [options[k] if k != _FITTED else None for k in kind[group.panels]]
                return settle_group(group, own, search.joints)

            for group, steps in zip(groups, _side_by_side(settled, groups), strict=True):
                if steps is not None:
                    stand = self._moved(stand, group, options, kind, steps)
        for k in range(_FITTED):
            search.add(np.flatnonzero(kind == k), k, stand)

    def _moved(
        self,
        stand: Carriers,
        group: Group,
        options: Sequence[Option],
        kind: IntArray,
        steps: Sequence[Array],
    ) -> Carriers:
        for p, step in zip(group.panels.tolist(), steps, strict=True):
            if kind[p] != _FITTED:
                at = np.array([p])
                stand = scatter(stand, at, options[kind[p]].placed(at, step[None]))
        return stand

    def _option(self, kind: int, base: Carriers, able: BoolArray, rolled: bool = False) -> Option:
        name = CLASSES[kind]
        zero = np.zeros(len(base))
        base = Carriers(
            base.origin,
            base.frame,
            zero if name == "flat" else base.k,
            base.g if name == "cone" else zero,
        )
        return option_of(
            kind, "rolled" if rolled else name, base, able, self.search.samples, self.boundaries
        )

    def _alone(self, panels: IntArray) -> Group:
        here = np.isin(self.search.joints.panels, panels)
        return Group(panels, np.flatnonzero(here.all(axis=1)))

    def _beside(self, panels: IntArray) -> Group:
        search = self.search
        here = np.isin(search.joints.panels, panels)
        rims = []
        for side in (0, 1):
            joint = np.flatnonzero(here[:, side] & ~here[:, 1 - side])
            chosen = search.current[search.joints.panels[joint, 1 - side]]
            beyond = self.boundaries.features(
                1 - side, joint, search.pool.carriers[chosen], search.pool.replaced[chosen]
            )
            rims += [Rim(int(j), side, f) for j, f in zip(joint, beyond, strict=True)]
        return Group(panels, np.flatnonzero(here.all(axis=1)), tuple(rims))


def _side_by_side[P, R](function: Callable[[P], R], items: Sequence[P]) -> list[R]:
    with ThreadPoolExecutor(os.cpu_count() or 1) as threads:
        return list(threads.map(function, items))
