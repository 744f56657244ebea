"""Strips placed by integer programmes: what they could cost at least, and better placements."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from fabgeo.arrays import Array, BoolArray, IntArray
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.certify import deviation
from fabgeo.panels.enclosure import Meeting, enclose
from fabgeo.panels.firstorder import ENDS, Boundaries, Option, option_of
from fabgeo.panels.groups import colours_of, strips_of, windows_of
from fabgeo.panels.highs import all_solved, divisor
from fabgeo.panels.joints import compare, made_boundary
from fabgeo.panels.pool import CLASSES
from fabgeo.panels.programme import Decision, Group, Rim, choosing
from fabgeo.panels.proof import bounding_all
from fabgeo.panels.search import Search, scatter
from fabgeo.panels.settling import Missed, settling

_FITTED = len(CLASSES) - 1
_CYLINDER = CLASSES.index("cylinder")
_WIDE = 1.03  # of the limits in a bound: more than what linear features are off
_NARROW = 0.98  # of the limits in placements that are to keep them
_NARROWER = 0.92  # of three strips and more, which move farther
_SETTLE = 2  # linear programmes about the placements before
_HOPELESS = 1.2  # times the limit: closest shapes farther off are out of reach
MANY = 1000  # panels beyond which less is tried: no further sweeps, no own bound
_ENCLOSED = 600  # panels whose boxes are worked out at most


class StripPlacing:
    """Programmes of whole strips on top of a search.

    Parameters
    ----------
    search : Search
        Whose pool the placements join.
    jobs : int, optional
        Processes that solve them; None: this one alone.
    seconds : float, optional
        Limit by the clock of all of them together.

    Attributes
    ----------
    groups : list of (n,) int arrays
        The strips' panels.
    bounds : (g,) array
        What each strip costs at least to first order, whatever its placements and neighbours.
    proven : int
        Strips whose bound comes from their programme, not from their panels one by one.
    """

    def __init__(
        self, search: Search, jobs: int | None = None, seconds: float | None = None
    ) -> None:
        self.search, self.jobs = search, jobs
        self.until = np.inf if seconds is None else time.perf_counter() + seconds
        self.boundaries = Boundaries(search.joints, search.tolerances)
        self.groups = strips_of(len(search.samples), search.joints)
        self.bounds = np.array([search.floors[group].sum() for group in self.groups])
        self.proven = 0
        self._options: list[Option] = []
        self._offered: list[Option] = []
        self._tried: dict[bytes, bytes] = {}  # neighbours that strips were last placed against

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
        if not self._offered:
            everyone = np.arange(len(search.samples))
            base = search.rolled(everyone, search.own.fits[_CYLINDER])[0]
            able = deviation(search.samples, base)[0] <= search.tolerances.deviation_mm
            self._offered = [
                self._option(k, base, able, rolled=True) if k == _CYLINDER else option
                for k, option in enumerate(self.options)
            ]
        return self._offered

    def prove(self) -> None:
        """Raise the bounds of strips that cost more than their panels' floors."""
        search = self.search
        open_ = np.flatnonzero(self.costs > self.bounds + 1e-6)
        alone = [self._alone(self.groups[g]) for g in open_]
        asked = [
            choosing(group, self.options, search.joints, search.costs.by_kind, _WIDE).programme
            for group in alone
        ]
        for g, solution in zip(open_, all_solved(asked, self.jobs), strict=True):
            self.proven += 1
            if np.isfinite(solution.bound):
                self.bounds[g] = max(self.bounds[g], solution.bound)

    def certify(self) -> float:
        """What all panels cost at least, proven for placements in their boxes (`enclosure`).

        Classes whose closest shape is off by more than `_HOPELESS` times the limit are left out.
        Strips that cost more than their panels must are looked at, up to `_ENCLOSED` panels.
        """
        search, limits, prices = self.search, self.search.tolerances, self.search.costs.by_kind
        near = [
            deviation(search.samples, base)[0] <= _HOPELESS * limits.deviation_mm
            for base in search.own.fits
        ]
        least = np.full(len(search.samples), float(prices[-1]))
        for k, able in enumerate(near):
            least = np.where(able, np.minimum(least, prices[k]), least)
        looked = self._dearest(least)
        inside = np.zeros(len(least), dtype=bool)
        inside[[p for g in looked for p in self.groups[g].tolist()]] = True
        meeting = Meeting.of(search.joints)
        options = [
            enclose(
                self._option(k, base, near[k] & inside),
                search.samples,
                search.joints,
                meeting,
                limits,
            )
            for k, base in enumerate(search.own.fits)
            if prices[k] < prices[-1] and (near[k] & inside).any()
        ]
        least[inside] = prices[-1]
        for option in options:
            least = np.where(option.able, np.minimum(least, prices[option.kind]), least)
        floors = np.array([least[group].sum() for group in self.groups])
        if options:
            groups = [self._alone(self.groups[g]) for g in looked]
            asked = bounding_all(groups, options, search.joints, meeting, limits, prices)
            found = [solution.bound for solution in all_solved(asked, self.jobs)]
            floors[looked] = np.maximum(floors[looked], found)
        return float(floors.sum())

    def _dearest(self, least: Array) -> IntArray:
        """Strips that cost more than the least of their panels, by how much more, to a number."""
        floors = np.array([least[group].sum() for group in self.groups])
        order = np.argsort(floors - self.costs, kind="stable")
        count = np.cumsum([len(self.groups[g]) for g in order])
        return order[(self.costs[order] > floors[order] + 1e-6) & (count <= _ENCLOSED)]

    def improve(self) -> None:
        """Place strips that cost more than they must against their neighbours as chosen."""
        self._improve(self.groups, self.bounds)

    def improve_windows(self, count: int, shift: int = 0) -> None:
        """The same of `count` neighbouring strips at once, looking at all features of joints."""
        windows = windows_of(self.groups, self.search.joints, count, shift)
        panels = [np.concatenate([self.groups[g] for g in window]) for window in windows]
        bounds = np.array([self.bounds[window].sum() for window in windows])
        self._improve(panels, bounds, count)

    def _improve(self, groups: Sequence[IntArray], bounds: Array, wide: int = 1) -> None:
        """Groups of one colour have no joint in common: they are placed at once."""
        search = self.search
        colour = colours_of(groups, search.joints)
        for each in range(int(colour.max(initial=-1)) + 1):
            if self.late:
                break
            cost = search.costs.of(search.pool)[search.current]
            costs = np.array([cost[group].sum() for group in groups])
            open_ = (colour == each) & (costs > bounds + 1e-6)
            some = [g for g in np.flatnonzero(open_).tolist() if self._anew(groups[g])]
            beside = [self._beside(groups[g]) for g in some]
            decisions = self._cheaper(beside, costs[some], wide)
            found = [(g, d) for g, d in zip(beside, decisions, strict=True) if d is not None]
            if found:
                before = len(search.pool)
                turns = 2 * _SETTLE if wide > 1 else _SETTLE  # windows move farther
                self._settle([g for g, _ in found], [d for _, d in found], turns)
                search.choose(before)

    def _anew(self, group: IntArray) -> bool:
        """Whether neighbours of a group stand otherwise than when it was last placed."""
        search = self.search
        here = np.isin(search.joints.panels, group)
        beside = search.joints.panels[here[:, ::-1] & ~here]
        stand = search.current[beside].tobytes()
        anew = self._tried.get(group.tobytes()) != stand
        self._tried[group.tobytes()] = stand
        return anew

    def _cheaper(self, groups: Sequence[Group], costs: Array, wide: int) -> list[Decision | None]:
        """Classes and placements of groups that cost less than now; None where there are none."""
        prices, options, joints = self.search.costs.by_kind, self.offered, self.search.joints
        least = divisor(prices)  # what a cheaper choice saves
        share = _NARROWER if wide > 2 else _NARROW
        asked = [
            choosing(group, options, joints, prices, share, cost - 0.99 * least, every=wide > 1)
            for group, cost in zip(groups, costs, strict=True)
        ]
        work = {"nodes": 150, "iterations": 20000} if wide > 1 else {}
        found = all_solved([replace(one.programme, **work) for one in asked], self.jobs)
        return [
            one.decision(group, options, solution)
            for one, group, solution in zip(asked, groups, found, strict=True)
        ]

    def _settle(self, groups: Sequence[Group], decisions: Sequence[Decision], turns: int) -> None:
        """Placements of the classes decided, from linear programmes about them in turn."""
        search = self.search
        kind = np.full(len(search.samples), _FITTED, dtype=np.int64)
        few = len(search.radii) > 0
        for group, decision in zip(groups, decisions, strict=True):
            kind[group.panels] = decision.option % len(CLASSES)
        steps: Iterable[Sequence[Array] | None] = [decision.steps for decision in decisions]
        stand = self._moved(search.own.fits[-1], groups, self.offered, kind, steps)
        groups = [group for group in groups if np.any(kind[group.panels] != _FITTED)]
        for turn in range(turns):
            options = [
                self._option(k, stand, kind == k, rolled=few and k == _CYLINDER)
                for k in range(_FITTED)
            ]
            missed = self._missed(options, stand, kind, groups)
            asked = [
                settling(
                    group,
                    [options[k] if k != _FITTED else None for k in kind[group.panels]],
                    search.joints,
                    missed,
                )
                for group in groups
            ]
            found = all_solved([one.programme for one in asked], self.jobs)
            steps = [
                one.steps(group, solution)
                for one, group, solution in zip(asked, groups, found, strict=True)
            ]
            stand = self._moved(stand, groups, options, kind, steps)
            for k in range(_FITTED) if turn + 1 >= _SETTLE else ():
                search.add(np.flatnonzero(kind == k), k, stand)

    def _missed(
        self, options: Sequence[Option], stand: Carriers, kind: IntArray, groups: Sequence[Group]
    ) -> Missed:
        """What features do not see of groups as they stand, beside their neighbours as chosen."""
        search, limits, boundaries = self.search, self.search.tolerances, self.boundaries
        own = np.zeros(len(kind))
        index = np.flatnonzero(kind != _FITTED)
        found = deviation(search.samples[index], stand[index])[0] / limits.deviation_mm
        seen = np.max([np.abs(o.value[index, :-ENDS]).max(axis=1) for o in options], axis=0)
        own[index] = np.maximum(found - seen, 0.0)
        here = np.zeros(len(kind), dtype=bool)
        here[np.concatenate([group.panels for group in groups])] = True
        carriers = stand.where(here, search.pool.carriers[search.current])
        made = np.where(here, kind != _FITTED, search.pool.replaced[search.current])
        joint, use = search.joints, np.zeros(len(search.joints))
        at = np.flatnonzero(here[joint.panels].any(axis=1))
        sides, features = [], []
        for side, panel in enumerate(joint.panels[at].T):
            one, still = carriers[panel], made[panel]
            line = joint.points[at], joint.normals[side, at], joint.ends[at]
            sides.append(made_boundary(one, still, *line))
            features.append(boundaries.features(side, at, one, still))
        gap, kink = compare(sides[0], sides[1], joint.own[at])
        whole = np.maximum(gap / limits.gap_mm, kink / limits.kink)
        use[at] = np.maximum(whole - np.abs(features[1] - features[0]).max(axis=1), 0.0)
        return Missed(own, use)

    def _moved(
        self,
        stand: Carriers,
        groups: Sequence[Group],
        options: Sequence[Option],
        kind: IntArray,
        steps: Iterable[Sequence[Array] | None],
    ) -> Carriers:
        """Carriers with the steps of groups made, of those that have any."""
        own = {
            p: step
            for group, moves in zip(groups, steps, strict=True)
            if moves is not None
            for p, step in zip(group.panels.tolist(), moves, strict=True)
        }
        for k, option in enumerate(options):
            at = np.array([p for p in own if kind[p] == k], dtype=np.int64)
            if len(at):
                stand = scatter(stand, at, option.placed(at, np.stack([own[p] for p in at])))
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
