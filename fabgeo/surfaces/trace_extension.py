"""A design surface continued smoothly beyond its boundary, so that models may overhang it.

Beyond the boundary point y the surface is continued by its osculating paraboloid at y,
y + d + (d . S d) / 2 n with d tangent, up to a reach; straight from there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import FARTHEST, Array, checked, dot, unit
from fabgeo.surfaces.base import DesignSurface, SurfacePoints, size_of


@dataclass(frozen=True)
class ExtendedPoints(SurfacePoints):
    """Closest points on a continued surface.

    Attributes
    ----------
    beyond : (k,) array
        How far beyond the boundary the queries lie, along the surface; 0 on the surface itself.
    """

    beyond: Array


class Extended:
    """The surface and its continuation (protocol `DesignSurface`); nothing is on its boundary.

    Parameters
    ----------
    surface : DesignSurface
    reach : float, optional
        How far the paraboloid is followed, a fifth of the size by default.
    """

    def __init__(self, surface: DesignSurface, reach: float | None = None) -> None:
        self.inner = surface
        self.reach = 0.2 * size_of(surface) if reach is None else reach

    @property
    def name(self) -> str:
        """The surface's own name."""
        return self.inner.name

    @property
    def bounds(self) -> Array:
        """The surface's own bounds, without the continuation."""
        return self.inner.bounds

    @property
    def loops(self) -> tuple[Array, ...]:
        """The surface's own boundary: where an overhanging model is trimmed."""
        return self.inner.loops

    def sample(self, count: int) -> SurfacePoints:
        """Points on the surface itself."""
        return self.inner.sample(count)

    def closest(self, points: Array) -> ExtendedPoints:
        """Closest points on the surface, or beside it on the continuation."""
        points = checked("points", points, (None, 3), most=FARTHEST)
        at = self.inner.closest(points)
        beyond = np.zeros(len(points))
        out = np.flatnonzero(at.on_boundary)
        if not len(out):
            return ExtendedPoints(at.point, at.normal, at.shape, at.on_boundary, beyond)
        y, n, shape = at.point[out], at.normal[out], at.shape[out]
        d = points[out] - y
        d = d - dot(d, n)[:, None] * n
        length = np.linalg.norm(d, axis=1)
        beyond[out] = length
        share = np.minimum(1.0, self.reach / np.maximum(length, 1e-300))
        bend = np.einsum("kij,kj->ki", shape, d)
        height = (share - share**2 / 2.0) * dot(d, bend)
        normal = unit(n - share[:, None] * bend)
        flat = np.eye(3) - normal[:, :, None] * normal[:, None, :]
        point, normals, shapes = at.point.copy(), at.normal.copy(), at.shape.copy()
        point[out] = y + d + height[:, None] * n
        normals[out] = normal
        shapes[out] = flat @ shape @ flat
        inside = np.zeros(len(points), dtype=bool)
        return ExtendedPoints(point, normals, shapes, inside, beyond)

    def beyond(self, points: Array) -> Array:
        """Distance (k,) from the surface's boundary, zero for points not beside the surface."""
        return self.closest(points).beyond
