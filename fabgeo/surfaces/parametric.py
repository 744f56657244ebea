"""Design surfaces made of parametric charts, each trimmed or whole: closest points, boundary.

The way to a closest point: the nearest of many samples (KD-tree) gives chart and start, Newton
steps give the foot point; where that leaves the trimmed region, the nearest point of the trim
curves takes its place.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from fabgeo.arrays import Array, BoolArray, IntArray, checked, cross, dot, unit
from fabgeo.errors import InputError
from fabgeo.surfaces.base import SurfacePoints
from fabgeo.surfaces.border import Border
from fabgeo.surfaces.chart import Chart, Derivatives, foot_points, inside, normals, shape_tensors
from fabgeo.surfaces.trims import Trim, box_trim, checked_closed
from fabgeo.surfaces.units import Unit

CHUNK = 20000


class ParametricSurface:
    """A design surface of one or many charts (protocol `DesignSurface`).

    Parameters
    ----------
    name : str
        For messages.
    charts : sequence of Chart
        The faces.
    trims : sequence of Trim or None, optional
        Trimming loops of each face in its parameters; None: the whole rectangle.
    tolerance : float, optional
        Faces whose borders are closer than this share an edge; default 1e-5 of the size.
    """

    # The unit of the file it was read from; None if it wasn't.
    unit: Unit | None = None

    def __init__(
        self,
        name: str,
        charts: Sequence[Chart],
        trims: Sequence[Trim | None] | None = None,
        tolerance: float | None = None,
    ) -> None:
        self._name = name
        if not charts:
            raise InputError(name, "holds no face")
        self.charts = tuple(charts)
        self.trims = tuple(trims) if trims is not None else (None,) * len(charts)
        samples = [_samples(c, t) for c, t in zip(self.charts, self.trims, strict=True)]
        points = np.concatenate([point for _, point in samples])
        self.size = float(np.linalg.norm(np.ptp(points, axis=0)))
        if not self.size > 0.0:
            raise InputError(name, "the surface is a single point")
        self.tolerance = 1e-5 * self.size if tolerance is None else tolerance
        for chart in self.charts:
            chart.closed = checked_closed(name, chart, self.tolerance)
        loops = [t or box_trim(c) for c, t in zip(self.charts, self.trims, strict=True)]
        self.border = Border.of(self.charts, loops, self.size, self.tolerance)
        self._starts = [
            Starts(i, chart, *sample, self.border if self.trims[i] else None)
            for i, (chart, sample) in enumerate(zip(self.charts, samples, strict=True))
        ]
        self._area_scale = np.array([_area_scale(c) for c in self.charts])
        self._sides = [self._free_sides(i) for i in range(len(self.charts))]
        self.sign = self.border.sign * self._turn()

    @property
    def name(self) -> str:
        """How messages call it."""
        return self._name

    @property
    def bounds(self) -> Array:
        """Bounding box (2, 3) of dense samples and the border."""
        return self._bounds

    @cached_property
    def _bounds(self) -> Array:
        points = np.concatenate([*(s.point for s in self._starts), self.border.point])
        return np.stack([points.min(axis=0), points.max(axis=0)])

    @cached_property
    def area(self) -> float:
        """Area of the trimmed faces, by the midpoint rule over the sample cells."""
        return sum(
            float((_cell_areas(c) * _kept(c, t)).sum())
            for c, t in zip(self.charts, self.trims, strict=True)
        )

    @property
    def loops(self) -> tuple[Array, ...]:
        """Free boundary loops; edges that two faces share are not boundary."""
        return self.border.loops

    @cached_property
    def fingerprint(self) -> str:
        """Hash of the content: equal for equal surfaces."""
        digest = hashlib.sha256()
        for array in (*(s.point for s in self._starts), self.border.point):
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()

    def closest(self, points: Array) -> SurfacePoints:
        """Closest points of `points` (k, 3) with normal, shape tensor and boundary flag."""
        face, u, v, d, edge = self._closest(checked("points", points, (None, 3)))
        return self._surface_points(face, u, v, d, edge)

    def parameters(self, points: Array) -> tuple[IntArray, Array]:
        """Face index (k,) and parameters (k, 2) of the closest points."""
        face, u, v, _, _ = self._closest(checked("points", points, (None, 3)))
        return face, np.stack([u, v], axis=1)

    def evaluate(self, u: Array, v: Array, face: int = 0) -> SurfacePoints:
        """The surface at parameters (k,) of one face, whether trimmed away or not."""
        chart = self.charts[face]
        u, v = inside(chart, *np.broadcast_arrays(*(np.atleast_1d(a) for a in (u, v))))
        which = np.full(len(u), face)
        none = np.zeros(len(u), dtype=bool)
        return self._surface_points(which, u, v, chart.evaluate(u, v), none)

    def sample(self, count: int) -> SurfacePoints:
        """About `count` points spread evenly by area over the trimmed faces."""
        weights = [_cell_areas(c) for c in self.charts]
        total = sum(float(w.sum()) * self._share(i) for i, w in enumerate(weights))
        faces, uvs = [], []
        for i, (chart, weight) in enumerate(zip(self.charts, weights, strict=True)):
            wanted = max(count * float(weight.sum()) / total, 4.0)
            uv = _even(chart, weight, wanted)
            trim = self.trims[i]
            if trim is not None:
                uv = uv[trim.contains(trim.local(chart, uv))]
            faces.append(np.full(len(uv), i))
            uvs.append(uv)
        face, uv = np.concatenate(faces), np.concatenate(uvs)
        d = self._derivatives(face, uv[:, 0], uv[:, 1])
        none = np.zeros(len(face), dtype=bool)
        return self._surface_points(face, uv[:, 0], uv[:, 1], d, none)

    def _free_sides(self, face: int) -> BoolArray:
        """Whether the sides u0, u1, v0, v1 of an untrimmed face are free boundary."""
        rows = np.flatnonzero((self.border.face == face) & self.border.free)
        if self.trims[face] is not None or not len(rows):
            return np.zeros(4, dtype=bool)
        middle = (self.border.uv[rows] + self.border.uv_end[rows]) / 2.0
        domain = self.charts[face].domain
        reach = 1e-9 * (domain[:, 1] - domain[:, 0])
        near = np.abs(middle[:, :, None] - domain) <= reach[:, None]
        return near.any(axis=0).ravel()

    def _on_side(self, face: int, u: Array, v: Array) -> BoolArray:
        """Whether parameters of an untrimmed face lie on a free side."""
        (u0, u1), (v0, v1) = self.charts[face].domain
        at = np.stack([u <= u0, u >= u1, v <= v0, v >= v1])
        return (at & self._sides[face][:, None]).any(axis=0)

    def _turn(self) -> float:
        """+1 or -1: so that normals point up in the mean, or outwards where that says nothing."""
        self.sign = self.border.sign
        at = self.sample(1000)
        up = float(at.normal[:, 2].mean())
        out = float(dot(at.normal, unit(at.point - at.point.mean(axis=0))).mean())
        return float(np.sign(up if abs(up) > 0.1 else out) or 1.0)

    def _share(self, face: int) -> float:
        """Roughly which part of the face's rectangle is inside its trims."""
        trim = self.trims[face]
        if trim is None:
            return 1.0
        rectangle = np.prod(self.charts[face].domain[:, 1] - self.charts[face].domain[:, 0])
        return max(trim.area / float(rectangle), 1e-6)

    def _closest(self, x: Array) -> tuple[IntArray, Array, Array, Derivatives, BoolArray]:
        parts = [self._closest_chunk(x[i : i + CHUNK]) for i in range(0, max(len(x), 1), CHUNK)]
        if len(parts) == 1:
            return parts[0]
        face, u, v, d, edge = zip(*parts, strict=True)
        joined = Derivatives(
            *(np.concatenate(a) for a in zip(*(p.arrays() for p in d), strict=True))
        )
        cat = np.concatenate
        return cat(face), cat(u), cat(v), joined, cat(edge)

    def _closest_chunk(self, x: Array) -> tuple[IntArray, Array, Array, Derivatives, BoolArray]:
        count = len(x)
        best = np.full(count, np.inf)
        face, u, v = np.zeros(count, dtype=np.int64), np.zeros(count), np.zeros(count)
        edge = np.zeros(count, dtype=bool)
        d = Derivatives(*(np.zeros((count, 3)) for _ in range(6)))
        reach = np.full(count, np.inf)
        for starts in self._starts:
            reach = np.minimum(reach, starts.farthest(x))
        for i, chart in enumerate(self.charts):
            rows, start = self._starts[i].of(x, reach)
            if not len(rows):
                continue
            fu, fv, fd = foot_points(chart, x[rows], start[:, 0], start[:, 1])
            distance = dot(fd.point - x[rows], fd.point - x[rows])
            trim = self.trims[i]
            valid = np.ones(len(rows), dtype=bool)
            if trim is not None:
                valid = trim.contains(trim.local(chart, np.stack([fu, fv], axis=1)))
            better = valid & (distance < best[rows])
            to = rows[better]
            best[to], face[to], u[to], v[to] = distance[better], i, fu[better], fv[better]
            edge[to] = self._on_side(i, fu[better], fv[better])
            d.put(to, fd[better])
        if any(t is not None for t in self.trims):
            self._snap_to_border(x, best, face, u, v, d, edge)
        return face, u, v, d, edge

    def _snap_to_border(
        self,
        x: Array,
        best: Array,
        face: IntArray,
        u: Array,
        v: Array,
        d: Derivatives,
        edge: BoolArray,
    ) -> None:
        """Take the nearest border point where it is nearer than any foot point inside."""
        owner, uv, distance, free = self.border.nearest(x)
        # A foot point on the very border may count as inside: it is the border's all the same.
        rows = np.flatnonzero(distance**2 <= best + (1e-7 * self.size) ** 2)
        if not len(rows):
            return
        face[rows], u[rows], v[rows], edge[rows] = owner[rows], uv[rows, 0], uv[rows, 1], free[rows]
        d.put(rows, self._derivatives(face[rows], u[rows], v[rows]))

    def _derivatives(self, face: IntArray, u: Array, v: Array) -> Derivatives:
        d = Derivatives(*(np.zeros((len(u), 3)) for _ in range(6)))
        for i, chart in enumerate(self.charts):
            rows = np.flatnonzero(face == i)
            if len(rows):
                d.put(rows, chart.evaluate(u[rows], v[rows]))
        return d

    def _surface_points(
        self, face: IntArray, u: Array, v: Array, d: Derivatives, edge: BoolArray
    ) -> SurfacePoints:
        bent = self._off_poles(face, u, v, d)
        sign = self.sign[face]
        normal = normals(bent) * sign[:, None]
        return SurfacePoints(d.point, normal, shape_tensors(bent, normal), edge)

    def _off_poles(self, face: IntArray, u: Array, v: Array, d: Derivatives) -> Derivatives:
        """Derivatives for normal and curvature: beside a pole, where x_u x x_v vanishes."""
        area = np.linalg.norm(cross(d.u, d.v), axis=1)
        scale = self._area_scale[face]
        rows = np.flatnonzero(area < 1e-7 * scale)
        if not len(rows):
            return d
        bent = replace(
            d, **{k: getattr(d, k).copy() for k in ("point", "u", "v", "uu", "uv", "vv")}
        )
        domains = np.stack([c.domain for c in self.charts])[face[rows]]
        middle = domains.mean(axis=2)
        uv = np.stack([u[rows], v[rows]], axis=1)
        uv = uv + 1e-4 * (middle - uv)
        beside = self._derivatives(face[rows], uv[:, 0], uv[:, 1])
        bent.put(rows, beside)
        return bent


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


def _area_scale(chart: Chart) -> float:
    """Typical |x_u x x_v| of a chart."""
    (u0, u1), (v0, v1) = chart.domain
    t = np.array([0.21, 0.5, 0.77])
    u, v = (a.ravel() for a in np.meshgrid(u0 + t * (u1 - u0), v0 + t * (v1 - v0)))
    d = chart.evaluate(u, v)
    return float(np.linalg.norm(cross(d.u, d.v), axis=1).mean())


def _counts(chart: Chart) -> tuple[int, int]:
    return tuple(int(np.clip(4 * s, 12, 160)) for s in chart.spans)  # type: ignore[return-value]


def _samples(chart: Chart, trim: Trim | None) -> tuple[Array, Array]:
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


def _cell_areas(chart: Chart) -> Array:
    """Areas (nu, nv) of a chart's sample cells, at their middles."""
    nu, nv = _counts(chart)
    (u0, u1), (v0, v1) = chart.domain
    u = u0 + (np.arange(nu) + 0.5) * (u1 - u0) / nu
    v = v0 + (np.arange(nv) + 0.5) * (v1 - v0) / nv
    uu, vv = np.meshgrid(u, v, indexing="ij")
    d = chart.evaluate(uu.ravel(), vv.ravel())
    area = np.linalg.norm(cross(d.u, d.v), axis=1).reshape(nu, nv)
    return area * ((u1 - u0) / nu) * ((v1 - v0) / nv)


def _kept(chart: Chart, trim: Trim | None) -> Array | float:
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


def _even(chart: Chart, area: Array, wanted: float) -> Array:
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
