"""Curves traced on any design surface: principal curvature lines and geodesics, many at once.

Glossary
--------
field
    A line field: a tangent direction at every point, without a sense; the sense is carried on from
    where a curve comes from.

Curves are integrated by classical Runge-Kutta steps of equal arc length; a step is divided until
its error estimate is within tolerance. Every stage is brought to the surface by its closest point.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fabgeo.arrays import Array, BoolArray, checked, cross, dot, unit
from fabgeo.surfaces.base import DesignSurface, SurfacePoints
from fabgeo.surfaces.trace_extension import ExtendedPoints

DEEPEST = 3  # a step is divided at most into 2 ** DEEPEST
type Field = Callable[[SurfacePoints, Array], Array]


def principal_field(at: SurfacePoints, along: Array) -> Array:
    """The principal direction (k, 3) that is nearest to `along`, with its sense."""
    _, axes = at.principal()
    cosine = np.einsum("kai,ki->ka", axes, along)
    which = np.argmax(np.abs(cosine), axis=1)
    row = np.arange(len(which))
    return axes[row, which] * np.copysign(1.0, cosine[row, which])[:, None]


def conjugate_direction(at: SurfacePoints, along: Array) -> Array:
    """The direction (k, 3) conjugate to `along`: r . S along = 0."""
    bend = np.einsum("kij,kj->ki", at.shape, along)
    return unit(cross(at.normal, bend))


def trace_field(
    surface: DesignSurface,
    field: Field,
    points: Array,
    along: Array,
    step: float,
    count: int,
    tolerance: float = 1e-3,
) -> Array:
    """Integral curves of a line field from many points at once.

    Parameters
    ----------
    points, along : (N, 3) arrays
        Starting points and directions (the sense, and which of the field's branches).
    step : float
        Arc length between returned points.
    count : int
        Number of steps.
    tolerance : float
        Error estimate allowed in a step, as a share of its length.

    Returns
    -------
    (N, count + 1, 3) array
    """
    points, along = checked("points", points, ("n", 3)), checked("along", along, ("n", 3))

    def slope(x: Array, before: Array) -> tuple[Array, Array, BoolArray]:
        at = surface.closest(x)
        inside = at.beyond == 0.0 if isinstance(at, ExtendedPoints) else np.ones(len(x), bool)
        return at.point, field(at, before), inside

    x, d, _ = slope(points, unit(along))
    lines, lost = [x], np.zeros(len(x), dtype=bool)
    for _ in range(count):
        x, d, lost = _field_step(slope, x, d, lost, step, tolerance, 0)
        lines.append(x)
    return np.stack(lines, axis=1)


def _field_step(
    slope: Callable[[Array, Array], tuple[Array, Array, BoolArray]],
    x: Array,
    d: Array,
    lost: BoolArray,
    h: float,
    tolerance: float,
    depth: int,
) -> tuple[Array, Array, BoolArray]:
    """One Runge-Kutta step; curves whose error estimate is too large take two half steps.

    A curve that the shortest steps do not follow either has come where the field has no direction.
    It is `lost`: from there on it takes whole steps, as all do beyond a surface's boundary.
    """
    _, d2, _ = slope(x + 0.5 * h * d, d)
    _, d3, _ = slope(x + 0.5 * h * d2, d2)
    _, d4, _ = slope(x + h * d3, d3)
    new, last, inside = slope(x + h * (d + 2.0 * d2 + 2.0 * d3 + d4) / 6.0, d4)
    # The fourth stage against the slope at the step's end: zero for an exact step.
    error = np.linalg.norm(d4 - last, axis=1) / 6.0
    bad = (error > tolerance) & inside & ~lost
    if depth == DEEPEST:
        return new, last, lost | bad
    if bad.any():
        half = x[bad], d[bad], lost[bad]
        for _ in range(2):
            half = _field_step(slope, *half, 0.5 * h, tolerance, depth + 1)
        new, last, lost = new.copy(), last.copy(), lost.copy()
        new[bad], last[bad], lost[bad] = half
    return new, last, lost


def trace_principal(
    surface: DesignSurface,
    points: Array,
    along: Array,
    step: float,
    count: int,
    tolerance: float = 1e-3,
) -> Array:
    """Principal curvature lines (N, count + 1, 3) from points, in the family nearest to `along`."""
    return trace_field(surface, principal_field, points, along, step, count, tolerance)


def trace_geodesics(
    surface: DesignSurface, points: Array, along: Array, step: float, count: int
) -> tuple[Array, Array]:
    """Geodesics from many points at once: x'' = (x' . S x') n.

    Returns
    -------
    lines : (N, count + 1, 3) array
        At equal arc lengths.
    tangents : (N, count + 1, 3) array
    """
    points, along = checked("points", points, ("n", 3)), checked("along", along, ("n", 3))

    def bent(x: Array, t: Array) -> tuple[SurfacePoints, Array]:
        at = surface.closest(x)
        return at, np.einsum("ki,kij,kj->k", t, at.shape, t)[:, None] * at.normal

    at = surface.closest(points)
    x, t = at.point, _tangent(along, at.normal)
    lines, tangents = [x], [t]
    for _ in range(count):
        _, a1 = bent(x, t)
        t2 = t + 0.5 * step * a1
        _, a2 = bent(x + 0.5 * step * t, t2)
        t3 = t + 0.5 * step * a2
        _, a3 = bent(x + 0.5 * step * t2, t3)
        t4 = t + step * a3
        at, a4 = bent(x + step * t3, t4)
        at = surface.closest(x + step * (t + 2.0 * t2 + 2.0 * t3 + t4) / 6.0)
        x, t = at.point, _tangent(t + step * (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0, at.normal)
        lines.append(x)
        tangents.append(t)
    return np.stack(lines, axis=1), np.stack(tangents, axis=1)


def both_ways(
    trace: Callable[[Array, Array], Array], points: Array, along: Array
) -> tuple[Array, int]:
    """Curves traced forwards and backwards in one go, joined; and the index of their start."""
    lines = trace(np.concatenate([points, points]), np.concatenate([along, -along]))
    ahead, back = lines[: len(points)], lines[len(points) :]
    return np.concatenate([back[:, :0:-1], ahead], axis=1), back.shape[1] - 1


def _tangent(vectors: Array, normal: Array) -> Array:
    return unit(vectors - dot(vectors, normal)[:, None] * normal)
