"""What all panels cost at least, by the programmes of strips: to first order, and proven."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array, BoolArray, IntArray
from fabgeo.panels.certify import deviation
from fabgeo.panels.enclosure import Enclosed, enclose
from fabgeo.panels.highs import all_solved
from fabgeo.panels.programme import choosing
from fabgeo.panels.proof import bounding_all
from fabgeo.panels.ranged import Meeting
from fabgeo.panels.stripwise import Stripwise

_WIDE = 1.03  # of the limits to first order: more than what linear features are off
_HOPELESS = 1.2  # times the limit: closest shapes farther off are out of reach
_ENCLOSED = 600  # panels whose boxes are worked out at most


def first_order(strips: Stripwise, jobs: int | None = None) -> Array:
    """What each strip costs at least to first order (g,), whatever its placements and neighbours.

    No less than the cheapest classes that the deviations of its panels allow.
    """
    search, bounds = strips.search, strips.summed(strips.search.floors)
    open_ = np.flatnonzero(strips.costs > bounds + 1e-6)
    asked = [
        choosing(
            strips.alone(strips.groups[g]),
            strips.options,
            search.joints,
            search.costs.by_kind,
            _WIDE,
        ).programme
        for g in open_
    ]
    for g, solution in zip(open_, all_solved(asked, jobs), strict=True):
        if np.isfinite(solution.bound):
            bounds[g] = max(bounds[g], solution.bound)
    return bounds


def proven(strips: Stripwise, jobs: int | None = None) -> float:
    """What all panels cost at least, proven for placements in their boxes (`enclosure`).

    Classes whose closest shape is off by more than `_HOPELESS` times the limit are left out.
    Strips that cost more than their panels must are looked at, up to `_ENCLOSED` panels.
    """
    search, limits, prices = strips.search, strips.search.tolerances, strips.search.costs.by_kind
    near = [
        deviation(search.samples, base)[0] <= _HOPELESS * limits.deviation_mm
        for base in search.own.fits
    ]
    least = np.full(len(search.samples), float(prices[-1]))
    for k, able in enumerate(near):
        least = np.where(able, np.minimum(least, prices[k]), least)
    looked = _dearest(strips, least)
    inside = np.zeros(len(least), dtype=bool)
    inside[[p for g in looked for p in strips.groups[g].tolist()]] = True
    meeting = Meeting.of(search.joints)
    options = _enclosed(strips, meeting, [able & inside for able in near])
    least[inside] = prices[-1]
    for option in options:
        least = np.where(option.able, np.minimum(least, prices[option.kind]), least)
    floors = strips.summed(least)
    if options:
        groups = [strips.alone(strips.groups[g]) for g in looked]
        asked = bounding_all(groups, options, search.joints, meeting, limits, prices)
        found = [solution.bound for solution in all_solved(asked, jobs)]
        floors[looked] = np.maximum(floors[looked], found)
    return float(floors.sum())


def _enclosed(strips: Stripwise, meeting: Meeting, able: list[BoolArray]) -> list[Enclosed]:
    """Classes that cost less than staying as fitted, over boxes of panels that may take them."""
    search, prices = strips.search, strips.search.costs.by_kind
    return [
        enclose(
            strips.option(k, base, able[k]),
            search.samples,
            search.joints,
            meeting,
            search.tolerances,
        )
        for k, base in enumerate(search.own.fits)
        if prices[k] < prices[-1] and able[k].any()
    ]


def _dearest(strips: Stripwise, least: Array) -> IntArray:
    """Strips that cost more than the least of their panels, by how much more, to a number."""
    floors, costs = strips.summed(least), strips.costs
    order = np.argsort(floors - costs, kind="stable")
    count = np.cumsum([len(strips.groups[g]) for g in order])
    return order[(costs[order] > floors[order] + 1e-6) & (count <= _ENCLOSED)]
