"""Samples of parametric faces: where foot points start from, areas, points spread evenly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from fabgeo.arrays import Array, IntArray, cross
from fabgeo.errors import InputError
from fabgeo.surfaces.border import Border
from fabgeo.surfaces.chart import Chart, inside
from fabgeo.surfaces.trims import Trim

IN_A_CELL = 4  # points along each side by which a cell's area is measured


class Starts:
    """Samples of one face: which queries may be closest to it, and where to start from.

    Attributes
    ----------
    uv, point : (k, 2) and (k, 3) arrays
    spacing : float
        No point of the face is farther than this from a sample.
    """

    def __init__(
        self,
        face: int,
        chart: Chart,
        uv: Array,
        point: Array,
        spacing: float,
        border: Border | None,
    ) -> None:
        if border is not None:
            rows = border.face == face
            uv = np.concatenate([uv, border.uv[rows]])
            point = np.concatenate([point, border.point[rows]])
        d = chart.evaluate(*inside(chart, uv[:, 0], uv[:, 1]))
        # At a pole, where x_u x x_v vanishes, no step knows where to go: don't start there.
        area = np.linalg.norm(cross(d.u, d.v), axis=1)
        regular = area > 1e-6 * area.mean()
        if not regular.any():
            raise InputError(f"face {face}", "has no area: its parameter lines all coincide")
        self.uv, self.point = uv[regular], point[regular]
        self.spacing = spacing
        self._corners = np.stack([self.point.min(axis=0), self.point.max(axis=0)])
        self._tree = KDTree(self.point)
        self._coarse = KDTree(self.point[:: max(len(self.point) // 32, 1)])

    def farthest(self, x: Array) -> Array:
        """A distance (k,) within which the face surely has a point: that of a coarse sample."""
        return self._coarse.query(x)[0]

    def of(self, x: Array, reach: Array) -> tuple[IntArray, Array]:
        """Rows of queries that may have their closest point here, and their starts (k, 2)."""
        beyond = np.maximum(np.maximum(self._corners[0] - x, x - self._corners[1]), 0.0)
        near = np.linalg.norm(beyond, axis=1) <= reach + self.spacing
        rows = np.flatnonzero(near)
        distance, sample = self._tree.query(x[rows])
        kept = distance <= reach[rows] + self.spacing
        return rows[kept], self.uv[sample[kept]]


def area_scale(chart: Chart) -> float:
    """Typical |x_u x x_v| of a chart."""
    (u0, u1), (v0, v1) = chart.domain
    t = np.array([0.21, 0.5, 0.77])
    u, v = (a.ravel() for a in np.meshgrid(u0 + t * (u1 - u0), v0 + t * (v1 - v0)))
    d = chart.evaluate(u, v)
    return float(np.linalg.norm(cross(d.u, d.v), axis=1).mean())


def _counts(chart: Chart) -> tuple[int, int]:
    along_u, along_v = chart.spans
    return int(np.clip(4 * along_u, 12, 160)), int(np.clip(4 * along_v, 12, 160))


def breaks(chart: Chart, trim: Trim | None) -> tuple[Array, Array]:
    """Parameters (nu + 1,) and (nv + 1,) between the sample cells, inside the trims' bounds.

    At every knot, and else half even in parameters, half in length along the line u or v that is
    longest there: parameters of imported faces may be anything but even.
    """
    box = chart.domain if trim is None else trim.bounds.T
    found = []
    for axis, count in enumerate(_counts(chart)):
        low, high = box[axis]
        knots = np.asarray(getattr(chart, "knots", ((), ()))[axis])
        knots = np.unique(knots[(knots > low) & (knots < high)])
        fine = np.union1d(np.linspace(low, high, 8 * count + 1), knots)
        across = box[1 - axis, 0] + np.ptp(box[1 - axis]) * np.linspace(0.02, 0.98, 7)
        grid = np.meshgrid((fine[1:] + fine[:-1]) / 2.0, across, indexing="ij")
        u, v = (a.ravel() for a in (grid if axis == 0 else grid[::-1]))
        d = chart.evaluate(*inside(chart, u, v))
        speed = np.linalg.norm(d.u if axis == 0 else d.v, axis=1).reshape(len(fine) - 1, -1)
        length = speed.max(axis=1) * np.diff(fine)
        way = length / length.sum() + np.diff(fine) / (high - low)
        way = np.concatenate([[0.0], np.cumsum(way)])
        even = np.interp(np.linspace(0.0, way[-1], count + 1), way, fine)
        even = np.concatenate([[low], even[1:-1], [high]])
        found.append(np.union1d(even, knots))
    return found[0], found[1]


def samples_of(chart: Chart, trim: Trim | None) -> tuple[Array, Array, float]:
    """Starting parameters (k, 2) and points (k, 3) of a chart, inside its trims, and spacing.

    No point of the chart within the trims is farther from a sample than the spacing.
    """
    u, v = np.meshgrid(*breaks(chart, trim), indexing="ij")
    uv = np.stack([u.ravel(), v.ravel()], axis=1)
    point = chart.evaluate(*inside(chart, uv[:, 0], uv[:, 1])).point
    grid = point.reshape(*u.shape, 3)
    longest = [np.linalg.norm(np.diff(grid, axis=k), axis=-1).max() for k in (0, 1)]
    if trim is not None:
        kept = trim.contains(uv)
        loops = np.concatenate(trim.loops)
        uv = np.concatenate([uv[kept], loops])
        at = chart.evaluate(*inside(chart, loops[:, 0], loops[:, 1])).point
        point = np.concatenate([point[kept], at])
    return uv, point, float(np.hypot(longest[0], longest[1]))


@dataclass(frozen=True)
class Cells:
    """Sample cells of a chart: what lies between `u` (nu + 1,) and `v` (nv + 1,).

    `area` (nu, nv) is that of each whole cell, `kept` the part of it that is inside the trims.
    """

    u: Array
    v: Array
    area: Array
    kept: Array

    @classmethod
    def of(cls, chart: Chart, trim: Trim | None) -> Cells:
        """Areas by the same points in each cell."""
        u, v = breaks(chart, trim)
        points = _within(u, v)
        d = chart.evaluate(*inside(chart, points[:, 0], points[:, 1]))
        density = np.linalg.norm(cross(d.u, d.v), axis=1)
        size = np.diff(u)[:, None] * np.diff(v)
        area = _means(density, len(u) - 1) * size
        if trim is None:
            return cls(u, v, area, area)
        held = trim.contains(trim.local(chart, points))
        return cls(u, v, area, _means(density * held, len(u) - 1) * size)


def _within(u: Array, v: Array) -> Array:
    """Parameters (k, 2) of `IN_A_CELL` squared even points in every cell."""
    t = (np.arange(IN_A_CELL) + 0.5) / IN_A_CELL
    lines = ((x[:-1, None] + np.diff(x)[:, None] * t).ravel() for x in (u, v))
    return np.stack([a.ravel() for a in np.meshgrid(*lines, indexing="ij")], axis=1)


def _means(values: Array, rows: int) -> Array:
    """Means (nu, nv) over the points of `_within` in each cell."""
    return values.reshape(rows, IN_A_CELL, -1, IN_A_CELL).mean(axis=(1, 3))


def evenly(cells: Cells, wanted: float) -> Array:
    """About `wanted` parameters (k, 2), evenly spread by area: the R2 sequence, warped.

    The first coordinate goes through the inverse of the distribution of area over u, the second
    through that of the row it falls in.
    Source: Roberts, The unreasonable effectiveness of quasirandom sequences (2018).
    """
    count = max(round(wanted), 1)
    k = np.arange(1, count + 1)[:, None]
    s, t = (np.mod(0.5 + k * np.array([0.7548776662466927, 0.5698402909980532]), 1.0)).T
    nu, nv = cells.area.shape
    area = cells.area + 1e-12 * cells.area.max()
    along = np.concatenate([[0.0], np.cumsum(area.sum(axis=1))])
    x = np.interp(s, along / along[-1], np.arange(nu + 1))
    row = np.minimum(x.astype(np.int64), nu - 1)
    up = np.concatenate([np.zeros((nu, 1)), np.cumsum(area, axis=1)], axis=1)
    up = up / up[:, -1:] + np.arange(nu)[:, None]
    grid = np.arange(nu)[:, None] * nv + np.arange(nv + 1)[None]
    y = np.interp(t * (1.0 - 1e-12) + row, up.ravel(), grid.ravel()) - row * nv
    u = np.interp(x, np.arange(nu + 1), cells.u)
    return np.stack([u, np.interp(y, np.arange(nv + 1), cells.v)], axis=1)
