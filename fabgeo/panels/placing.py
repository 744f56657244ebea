"""Strips placed by integer programmes, beside their neighbours as chosen: better placements."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from fabgeo.arrays import Array, IntArray
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.certify import deviation
from fabgeo.panels.firstorder import ENDS, Option
from fabgeo.panels.groups import colours_of, windows_of
from fabgeo.panels.highs import all_solved, divisor
from fabgeo.panels.joints import compare, made_boundary
from fabgeo.panels.pool import CLASSES
from fabgeo.panels.programme import Decision, Group, choosing
from fabgeo.panels.search import scatter
from fabgeo.panels.settling import Missed, settling
from fabgeo.panels.stripwise import Stripwise

_FITTED = len(CLASSES) - 1
_CYLINDER = CLASSES.index("cylinder")
_NARROW = 0.98  # of the limits in placements that are to keep them
_NARROWER = 0.92  # of three strips and more, which move farther
_SETTLE = 2  # linear programmes about the placements before


class StripPlacing:
    """Places strips whose pool of candidates grows by that.

    Parameters
    ----------
    strips : Stripwise
        Their search is who chooses.
    bounds : (g,) array
        What each strip costs at least: at that nothing is looked for.
    jobs : int, optional
        Threads that solve the programmes; None: this one alone.
    seconds : float, optional
        Limit by the clock of all of them together.
    """

    def __init__(
        self,
        strips: Stripwise,
        bounds: Array,
        jobs: int | None = None,
        seconds: float | None = None,
    ) -> None:
        self.strips, self.search = strips, strips.search
        self.bounds, self.jobs = bounds, jobs
        self.until = np.inf if seconds is None else time.perf_counter() + seconds
        self._tried: dict[bytes, bytes] = {}  # neighbours that strips were last placed against

    @property
    def late(self) -> bool:
        """Whether the time is used up."""
        return time.perf_counter() > self.until

    def improve(self) -> None:
        """Place strips that cost more than they must against their neighbours as chosen."""
        self._improve(self.strips.groups, self.bounds)

    def improve_windows(self, count: int, shift: int = 0) -> None:
        """The same of `count` neighbouring strips at once, looking at all features of joints."""
        windows = windows_of(self.strips.groups, self.search.joints, count, shift)
        panels = [np.concatenate([self.strips.groups[g] for g in window]) for window in windows]
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
            beside = [self.strips.beside(groups[g]) for g in some]
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
        prices, options, joints = self.search.costs.by_kind, self.strips.offered, self.search.joints
        least = divisor(prices)  # what a cheaper choice saves
        share = _NARROWER if wide > 2 else _NARROW
        asked = [
            choosing(group, options, joints, prices, share, cost - 0.99 * least, every=wide > 1)
            for group, cost in zip(groups, costs, strict=True)
        ]
        work = {"nodes": 25, "iterations": 20000} if wide > 1 else {}
        found = all_solved([replace(one.programme, dive=True, **work) for one in asked], self.jobs)
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
        stand = self._moved(search.own.fits[-1], groups, self.strips.offered, kind, steps)
        groups = [group for group in groups if np.any(kind[group.panels] != _FITTED)]
        for turn in range(turns):
            options = [
                self.strips.option(k, stand, kind == k, rolled=few and k == _CYLINDER)
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
        search, limits, boundaries = self.search, self.search.tolerances, self.strips.boundaries
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
