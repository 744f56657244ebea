"""The design surface as the fit sees it: scaled to the strips' own length unit, with its boundary.

Glossary
--------
unit
    The mean ruling length of the start. Inside the fit all lengths are multiples of it, so that
    one set of weights serves a canopy and a stadium.
side
    A smooth piece of a boundary loop between two corners (or a whole loop without corners).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from fabgeo.arrays import Array, IntArray, dot, unit
from fabgeo.surfaces.base import DesignSurface
from fabgeo.surfaces.trace_extension import Extended, ExtendedPoints

CORNER = np.cos(np.radians(30.0))  # a boundary that turns more than this has a corner


NEAR = 0.05  # in the fit's unit: how far a closest point is carried on by its curvature


@dataclass(frozen=True)
class Foot:
    """Closest points in the fit's unit.

    Attributes
    ----------
    point, normal : (..., 3) arrays
    beyond : (...) array
        How far beyond the boundary of a continued surface the points lie; 0 on the surface.
    """

    point: Array
    normal: Array
    beyond: Array


class Reference:
    """A design surface in the fit's unit of length."""

    def __init__(self, surface: DesignSurface, length: float) -> None:
        self.surface, self.length = surface, length

    @property
    def continued(self) -> bool:
        """Whether it goes on beyond its boundary."""
        return isinstance(self.surface, Extended)

    def tracker(self) -> Tracker:
        """Closest points that are carried along while points move little."""
        return Tracker(self.surface, self.length)

    def outwards(self, points: Array) -> Array:
        """From the boundary to (..., 3) points that lie beyond it, along the surface; else 0."""
        if not isinstance(self.surface, Extended):  # as `continued`, told to the type checker
            return np.zeros_like(points)
        x = points.reshape(-1, 3)
        at = self.surface.inner.closest(x * self.length)
        away = x - at.point / self.length
        away = away - dot(away, at.normal)[:, None] * at.normal
        return np.where(at.on_boundary[:, None], away, 0.0).reshape(points.shape)

    def sides(self) -> list[Side]:
        """Smooth boundary pieces, in the fit's unit."""
        return [s for loop in self.surface.loops for s in split(loop / self.length)]


class Tracker:
    """Closest points of points that move little from one call to the next.

    Within `NEAR` of the foot found last, the surface is its osculating paraboloid there: with S
    the shape tensor and s the tangential way, the foot moves to y + s + n (s . S s) / 2 and the
    normal to n - S s. What is neglected is of third order, about 1e-7 of a ruling's length.
    """

    def __init__(self, surface: DesignSurface, length: float) -> None:
        self._surface, self._length = surface, length
        self._point = self._normal = np.empty((0, 3))
        self._shape, self._beyond = np.empty((0, 3, 3)), np.empty(0)

    def feet(self, points: Array) -> Foot:
        """Closest points of (..., 3) points, always the same number in the same order."""
        x = points.reshape(-1, 3)
        if len(x) != len(self._point):
            self._point, self._normal = np.empty_like(x), np.empty_like(x)
            self._shape, self._beyond = np.empty((len(x), 3, 3)), np.zeros(len(x))
            self._find(x, np.arange(len(x)))
        way = self._tangential(x)
        moved = np.flatnonzero(dot(way, way) > NEAR**2)
        if len(moved):
            self._find(x, moved)
            way[moved] = self._tangential(x)[moved]
        bend = np.einsum("kij,kj->ki", self._shape, way)
        rise = 0.5 * dot(way, bend)[:, None]
        normal = unit(self._normal - bend)
        foot = self._point + way + rise * self._normal
        beyond = self._beyond.reshape(points.shape[:-1])
        return Foot(foot.reshape(points.shape), normal.reshape(points.shape), beyond)

    def _tangential(self, x: Array) -> Array:
        away = x - self._point
        return away - dot(away, self._normal)[:, None] * self._normal

    def _find(self, x: Array, which: IntArray) -> None:
        found = self._surface.closest(x[which] * self._length)
        self._point[which], self._normal[which] = found.point / self._length, found.normal
        self._shape[which] = found.shape * self._length
        if isinstance(found, ExtendedPoints):
            self._beyond[which] = found.beyond / self._length
        # Beside the surface its tangent plane goes on: no curvature to follow.
        self._shape[which[found.on_boundary]] = 0.0


class Side:
    """A smooth boundary curve as a dense polyline with tangents.

    Parameters
    ----------
    points : (k, 3) array
        A closed curve does not repeat its first point.
    closed : bool
    """

    def __init__(self, points: Array, closed: bool = False) -> None:
        ring = np.concatenate([points, points[:1]]) if closed else points
        self.points, self.closed = points, closed
        self._start, self._vector = ring[:-1], np.diff(ring, axis=0)
        middle = unit(self._vector)
        before = np.roll(middle, 1, axis=0) if closed else np.concatenate([middle[:1], middle])
        after = middle if closed else np.concatenate([middle, middle[-1:]])
        tangent = unit(before + after)
        self._tangent = np.concatenate([tangent, tangent[:1]]) if closed else tangent
        self._tree = KDTree(points)

    @property
    def length(self) -> float:
        """Length of the polyline."""
        return float(np.linalg.norm(self._vector, axis=1).sum())

    def closest(self, query: Array) -> tuple[Array, Array]:
        """Closest points and unit tangents there for (..., 3) points.

        Beyond its ends an open side goes on straight.
        """
        flat = query.reshape(-1, 3)
        _, near = self._tree.query(flat)
        count = len(self._vector)
        best_point, best_tangent = np.empty_like(flat), np.empty_like(flat)
        best = np.full(len(flat), np.inf)
        for offset in (-1, 0):
            k = near + offset
            k = k % count if self.closed else np.clip(k, 0, count - 1)
            v = self._vector[k]
            t = dot(flat - self._start[k], v) / np.maximum(dot(v, v), 1e-300)
            low = np.where((k == 0) & (not self.closed), -np.inf, 0.0)
            high = np.where((k == count - 1) & (not self.closed), np.inf, 1.0)
            t = np.clip(t, low, high)
            point = self._start[k] + t[:, None] * v
            distance = np.linalg.norm(flat - point, axis=1)
            closer = distance < best
            share = np.clip(t, 0.0, 1.0)[:, None]
            tangent = unit((1.0 - share) * self._tangent[k] + share * self._tangent[k + 1])
            best_point[closer], best_tangent[closer] = point[closer], tangent[closer]
            best[closer] = distance[closer]
        return best_point.reshape(query.shape), best_tangent.reshape(query.shape)


def split(loop: Array) -> list[Side]:
    """The smooth sides of a closed loop (k, 3), cut at its corners."""
    points = loop[:-1] if np.allclose(loop[0], loop[-1]) else loop
    out = unit(np.roll(points, -1, axis=0) - points)
    corner = np.flatnonzero(dot(out, np.roll(out, 1, axis=0)) < CORNER)
    if len(corner) == 0:
        return [Side(points, closed=True)]
    ends = np.append(corner[1:], corner[0] + len(points))
    pieces = [np.arange(a, b + 1) % len(points) for a, b in zip(corner, ends, strict=True)]
    return [Side(points[piece]) for piece in pieces]
