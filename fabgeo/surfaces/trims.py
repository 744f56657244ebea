"""Trimming loops of a face in its parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from fabgeo.arrays import Array, BoolArray, IntArray, checked
from fabgeo.errors import InputError
from fabgeo.surfaces.chart import Chart, inside

SAG = 3e-4  # of the longest segment of a border: how far segments may leave its curve


@dataclass(frozen=True)
class Trim:
    """The part of a chart that belongs to the surface, bounded by polylines in (u, v).

    Attributes
    ----------
    loops : tuple of (k, 2) arrays
        Closed polylines, the first point not repeated; whatever an odd number of them surrounds
        is kept. On construction they are turned so that the kept side is on their left.
    """

    loops: tuple[Array, ...]
    _cache: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    def __post_init__(self) -> None:
        loops = [checked("trim loop", loop, (None, 2)) for loop in self.loops]
        loops = [loop[:-1] if np.allclose(loop[0], loop[-1], 0, 0) else loop for loop in loops]
        if not loops or any(len(loop) < 3 for loop in loops):
            raise InputError("trim", "expected loops of three points or more")
        turned = []
        for i, loop in enumerate(loops):
            others = [o for k, o in enumerate(loops) if k != i]
            depth = sum(int(_surrounds(o, loop[0])) for o in others)
            counterclockwise = _signed_area(loop) > 0.0
            turned.append(loop if counterclockwise == (depth % 2 == 0) else loop[::-1].copy())
        object.__setattr__(self, "loops", tuple(turned))

    def __getstate__(self) -> dict[str, Any]:
        return {"loops": self.loops}

    def __setstate__(self, state: dict[str, Any]) -> None:
        object.__setattr__(self, "loops", state["loops"])
        object.__setattr__(self, "_cache", {})

    @property
    def area(self) -> float:
        """Kept area in parameters."""
        return float(sum(_signed_area(loop) for loop in self.loops))

    @cached_property
    def bounds(self) -> Array:
        """(2, 2): lower and upper corner in parameters."""
        points = np.concatenate(self.loops)
        return np.stack([points.min(axis=0), points.max(axis=0)])

    def contains(self, uv: Array) -> BoolArray:
        """Whether parameters (k, 2) are kept."""
        import shapely

        region = self._cache.get("region")
        if region is None:
            region = shapely.Polygon()
            for loop in self.loops:
                region = region.symmetric_difference(shapely.make_valid(shapely.Polygon(loop)))
            shapely.prepare(region)
            self._cache["region"] = region
        return shapely.intersects_xy(region, uv[:, 0], uv[:, 1])

    def local(self, chart: Chart, uv: Array) -> Array:
        """Periodic parameters moved by whole periods into the range of the loops."""
        moved = uv.copy()
        for axis in (0, 1):
            if chart.closed[axis]:
                period = chart.domain[axis, 1] - chart.domain[axis, 0]
                low = self.bounds[0, axis] - 1e-9 * period
                moved[:, axis] = low + np.mod(uv[:, axis] - low, period)
        return moved

    def is_whole(self, chart: Chart) -> bool:
        """Whether the loops only go round the chart's rectangle."""
        (u0, u1), (v0, v1) = chart.domain
        return len(self.loops) == 1 and self.area > (1.0 - 1e-6) * (u1 - u0) * (v1 - v0)


def box_trim(chart: Chart) -> Trim:
    """The rectangle of a chart as a trim: 4 k points, k on each side, in the order of `SIDES`."""
    (u0, u1), (v0, v1) = chart.domain
    k = int(np.clip(8 * max(chart.spans), 64, 512))
    t = np.arange(k) / k
    zero = np.zeros(k)
    sides = [
        np.stack([u0 + t * (u1 - u0), zero + v0], axis=1),
        np.stack([zero + u1, v0 + t * (v1 - v0)], axis=1),
        np.stack([u1 + t * (u0 - u1), zero + v1], axis=1),
        np.stack([zero + u0, v1 + t * (v0 - v1)], axis=1),
    ]
    return Trim((np.concatenate(sides),))


def closes(chart: Chart, tolerance: float) -> tuple[bool, bool]:
    """Whether opposite sides of a chart are the same curve with the same tangents across."""
    found = []
    for axis in (0, 1):
        t = np.linspace(0.0, 1.0, 23)
        low, high = chart.domain[1 - axis]
        along = low + t * (high - low)
        first, second = (_side(chart, axis, end, along) for end in chart.domain[axis])
        gap = np.linalg.norm(first[0] - second[0], axis=1).max()
        extent = np.linalg.norm(first[0] - _side(chart, axis, chart.domain[axis].mean(), along)[0])
        bend = np.linalg.norm(first[1] - second[1], axis=1).max()
        speed = np.linalg.norm(first[1], axis=1).max()
        found.append(bool(gap < tolerance and extent > tolerance and bend < 1e-3 * speed))
    return found[0], found[1]


def checked_closed(name: str, chart: Chart, tolerance: float) -> tuple[bool, bool]:
    """Closedness as stated or found.

    Raises
    ------
    InputError
        If a direction is said to close and its two sides are apart.
    """
    stated = chart.closed
    for axis in (0, 1):
        if not stated[axis]:
            continue
        low, high = chart.domain[1 - axis]
        along = np.linspace(low, high, 23)
        period = chart.domain[axis]
        first = _side(chart, axis, period[0], along)[0]
        second = _side(chart, axis, period[1], along)[0]
        gap = float(np.linalg.norm(first - second, axis=1).max())
        if gap > tolerance:
            word = "uv"[axis]
            raise InputError(
                name,
                f"is said to close in {word}, but its sides {word} = {period[0]:.6g} and "
                f"{word} = {period[1]:.6g} are {gap:.4g} apart",
                f"correct the domain or drop closed_{word}",
            )
    found = closes(chart, tolerance)
    return stated[0] or found[0], stated[1] or found[1]


def _side(chart: Chart, axis: int, at: float, along: Array) -> tuple[Array, Array]:
    """Points of a side and derivatives across it."""
    across = np.full(len(along), at)
    uv = (across, along) if axis == 0 else (along, across)
    d = chart.evaluate(*uv)
    return d.point, (d.u if axis == 0 else d.v)


def _signed_area(loop: Array) -> float:
    x, y = (loop - loop[0]).T
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def _surrounds(loop: Array, point: Array) -> bool:
    """Even-odd test of one point."""
    a, b = loop, np.roll(loop, -1, axis=0)
    crosses = (a[:, 1] > point[1]) != (b[:, 1] > point[1])
    rise = np.where(crosses, b[:, 1] - a[:, 1], 1.0)
    x = a[:, 0] + (point[1] - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
    return bool(np.count_nonzero(crosses & (x > point[0])) % 2)


def resampled(chart: Chart, loop: Array, longest: float) -> Array:
    """A loop (k, 2) with points added until its segments are no longer than `longest` in space.

    Nor may they leave the curve by more than `SAG` of that, for segments straight in (u, v).
    """
    points = chart.evaluate(*inside(chart, loop[:, 0], loop[:, 1])).point
    step = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    middle = (loop + np.roll(loop, -1, axis=0)) / 2.0
    middles = chart.evaluate(*inside(chart, middle[:, 0], middle[:, 1])).point
    step = np.maximum(step, 2.0 * np.linalg.norm(middles - points, axis=1))
    sag = np.linalg.norm(middles - (points + np.roll(points, -1, axis=0)) / 2.0, axis=1)
    pieces = np.maximum(step / longest, np.sqrt(sag / (SAG * longest)))
    pieces = np.clip(np.ceil(pieces), 1, 200).astype(np.int64)
    start = np.repeat(np.arange(len(loop)), pieces)
    t = (np.arange(len(start)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[start]
    return loop[start] + t[:, None] * (np.roll(loop, -1, axis=0)[start] - loop[start])


def chords(charts: Sequence[Chart], which: IntArray, uv: Array) -> Array:
    """Points (k, 3) of parameters (k, 2) on the charts `which` (k,)."""
    points = np.empty((len(uv), 3))
    for i, chart in enumerate(charts):
        rows = np.flatnonzero(which == i)
        if len(rows):
            points[rows] = chart.evaluate(*inside(chart, uv[rows, 0], uv[rows, 1])).point
    return points
