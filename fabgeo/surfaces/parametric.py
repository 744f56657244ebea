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

from fabgeo.arrays import (
    FARTHEST,
    Array,
    BoolArray,
    IntArray,
    as_numbers,
    checked,
    checked_count,
    cross,
    dot,
    unit,
)
from fabgeo.errors import InputError
from fabgeo.surfaces.base import MOST_SAMPLES, SurfacePoints
from fabgeo.surfaces.border import Border
from fabgeo.surfaces.chart import (
    Chart,
    Derivatives,
    at_sides,
    foot_points,
    inside,
    normals,
    shape_tensors,
)
from fabgeo.surfaces.sampling import Cells, Starts, area_scale, evenly, samples_of
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
        samples = [samples_of(c, t) for c, t in zip(self.charts, self.trims, strict=True)]
        points = np.concatenate([point for _, point, _ in samples])
        self.size = float(np.linalg.norm(np.ptp(points, axis=0)))
        if not np.isfinite(self.size):
            raise InputError(name, "holds points that are not finite")
        if not self.size > 0.0:
            raise InputError(name, "the surface is a single point")
        self.tolerance = 1e-5 * self.size if tolerance is None else tolerance
        for chart in self.charts:
            chart.closed = checked_closed(name, chart, self.tolerance)
        loops = [t or box_trim(c) for c, t in zip(self.charts, self.trims, strict=True)]
        self.border = Border.of(self.charts, loops, self.size, self.tolerance, name)
        self._starts = [
            Starts(i, chart, *sample, self.border if self.trims[i] else None)
            for i, (chart, sample) in enumerate(zip(self.charts, samples, strict=True))
        ]
        self._area_scale = np.array([area_scale(c) for c in self.charts])
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
    def face_areas(self) -> tuple[float, ...]:
        """Areas of the trimmed faces, by the midpoint rule over the sample cells."""
        return tuple(float(cells.kept.sum()) for cells in self._cells)

    @cached_property
    def _cells(self) -> tuple[Cells, ...]:
        return tuple(Cells.of(c, t) for c, t in zip(self.charts, self.trims, strict=True))

    @property
    def area(self) -> float:
        """Area of all faces."""
        return sum(self.face_areas)

    def face_bounds(self, face: int) -> Array:
        """Bounding box (2, 3) of a trimmed face's samples."""
        checked_count("face", face, 0, len(self.charts) - 1)
        points = self._starts[face].point
        return np.stack([points.min(axis=0), points.max(axis=0)])

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
        face, u, v, d, edge = self._closest(checked("points", points, (None, 3), most=FARTHEST))
        return self._surface_points(face, u, v, d, edge)

    def parameters(self, points: Array) -> tuple[IntArray, Array]:
        """Face index (k,) and parameters (k, 2) of the closest points."""
        face, u, v, _, _ = self._closest(checked("points", points, (None, 3), most=FARTHEST))
        return face, np.stack([u, v], axis=1)

    def evaluate(self, u: Array, v: Array, face: int = 0) -> SurfacePoints:
        """The surface at parameters (k,) of one face, whether trimmed away or not.

        Parameters beyond the face's are brought to its sides, or go round where it is closed.
        """
        chart = self.charts[checked_count("face", face, 0, len(self.charts) - 1)]
        u, v = (np.atleast_1d(as_numbers(name, a)) for name, a in (("u", u), ("v", v)))
        sizes = {} if u.size > 1 and v.size > 1 else None  # one goes with many
        u, v = (checked("parameters", a, ("k",), sizes, FARTHEST) for a in (u, v))
        u, v = inside(chart, *np.broadcast_arrays(u, v))
        which = np.full(len(u), face)
        none = np.zeros(len(u), dtype=bool)
        return self._surface_points(which, u, v, chart.evaluate(u, v), none)

    def sample(self, count: int) -> SurfacePoints:
        """About `count` points spread evenly by area over the trimmed faces."""
        checked_count("samples", count, 1, MOST_SAMPLES)
        faces, uvs = [], []
        for i, (chart, cells) in enumerate(zip(self.charts, self._cells, strict=True)):
            wanted = max(count * float(cells.area.sum()) / self.area, 4.0)
            uv = evenly(cells, wanted)
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
                valid &= ~at_sides(chart, fu, fv)  # these are the border's: see _snap_to_border
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
        # A foot point on the very border may count as inside: it is the border's all the same. (Of
        # those on a side of the chart this can't be told from distances: the border is a polygon.)
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
