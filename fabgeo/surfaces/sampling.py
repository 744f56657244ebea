"""Samples of parametric faces: where foot points start from, areas, points spread evenly."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from fabgeo.arrays import Array, IntArray, cross
from fabgeo.errors import InputError
from fabgeo.surfaces.border import Border
from fabgeo.surfaces.chart import Chart, inside
from fabgeo.surfaces.trims import Trim


class Starts:
    """Samples of one face: which queries may be closest to it, and where to start from.

    Attributes
    ----------
    uv, point : (k, 2) and (k, 3) arrays
    spacing : float
        No point of the face is farther than this from a sample.
    """

    def __init__(
        self, face: int, chart: Chart, uv: Array, point: Array, border: Border | None
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
        steps = (chart.domain[:, 1] - chart.domain[:, 0]) / np.array(_counts(chart))
        lengths = [
            np.linalg.norm(x, axis=1).max() * s for x, s in zip((d.u, d.v), steps, strict=True)
        ]
        self.spacing = float(np.hypot(*lengths))
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


def samples_of(chart: Chart, trim: Trim | None) -> tuple[Array, Array]:
    """Starting parameters (k, 2) and points (k, 3) of a chart, inside its trims."""
    nu, nv = _counts(chart)
    (u0, u1), (v0, v1) = chart.domain
    if trim is not None:
        (u0, v0), (u1, v1) = trim.bounds
    u, v = np.meshgrid(np.linspace(u0, u1, nu + 1), np.linspace(v0, v1, nv + 1), indexing="ij")
    uv = np.stack([u.ravel(), v.ravel()], axis=1)
    if trim is not None:
        uv = np.concatenate([uv[trim.contains(uv)], *trim.loops])
    return uv, chart.evaluate(*inside(chart, uv[:, 0], uv[:, 1])).point


def cell_areas(chart: Chart) -> Array:
    """Areas (nu, nv) of a chart's sample cells, at their middles."""
    nu, nv = _counts(chart)
    (u0, u1), (v0, v1) = chart.domain
    u = u0 + (np.arange(nu) + 0.5) * (u1 - u0) / nu
    v = v0 + (np.arange(nv) + 0.5) * (v1 - v0) / nv
    uu, vv = np.meshgrid(u, v, indexing="ij")
    d = chart.evaluate(uu.ravel(), vv.ravel())
    area = np.linalg.norm(cross(d.u, d.v), axis=1).reshape(nu, nv)
    return area * ((u1 - u0) / nu) * ((v1 - v0) / nv)


def kept_shares(chart: Chart, trim: Trim | None) -> Array | float:
    """Which part of every sample cell (nu, nv) is inside the trims, by 6 x 6 points in it."""
    if trim is None:
        return 1.0
    nu, nv = _counts(chart)
    (u0, u1), (v0, v1) = chart.domain
    u = u0 + (np.arange(6 * nu) + 0.5) * (u1 - u0) / (6 * nu)
    v = v0 + (np.arange(6 * nv) + 0.5) * (v1 - v0) / (6 * nv)
    uv = np.stack([a.ravel() for a in np.meshgrid(u, v, indexing="ij")], axis=1)
    kept = trim.contains(trim.local(chart, uv)).reshape(nu, 6, nv, 6)
    return kept.mean(axis=(1, 3), dtype=np.float64)


def evenly(chart: Chart, area: Array, wanted: float) -> Array:
    """About `wanted` parameters (k, 2), evenly spread by area: the R2 sequence, warped.

    The first coordinate goes through the inverse of the distribution of area over u, the second
    through that of the row it falls in.
    Source: Roberts, The unreasonable effectiveness of quasirandom sequences (2018).
    """
    count = max(round(wanted), 1)
    k = np.arange(1, count + 1)[:, None]
    s, t = (np.mod(0.5 + k * np.array([0.7548776662466927, 0.5698402909980532]), 1.0)).T
    nu, nv = area.shape
    area = area + 1e-12 * area.max()
    along = np.concatenate([[0.0], np.cumsum(area.sum(axis=1))])
    x = np.interp(s, along / along[-1], np.arange(nu + 1) / nu)
    row = np.minimum((x * nu).astype(np.int64), nu - 1)
    up = np.concatenate([np.zeros((nu, 1)), np.cumsum(area, axis=1)], axis=1)
    up = up / up[:, -1:] + np.arange(nu)[:, None]
    grid = np.arange(nu)[:, None] + np.linspace(0.0, 1.0, nv + 1)[None]
    y = np.interp(t * (1.0 - 1e-12) + row, up.ravel(), grid.ravel()) - row
    (u0, u1), (v0, v1) = chart.domain
    return np.stack([u0 + x * (u1 - u0), v0 + np.clip(y, 0, 1) * (v1 - v0)], axis=1)
