"""Dense polylines: arc length, even points, tangents."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array, unit


def steps(line: Array) -> Array:
    """Lengths (k - 1,) of a polyline's pieces."""
    return np.linalg.norm(np.diff(line, axis=0), axis=1)


def spread(line: Array, weight: Array, count: int) -> Array:
    """`count` points on a polyline (k, 3) at even steps of a weight (k - 1,) of its pieces."""
    arc = np.concatenate([[0.0], np.cumsum(weight)])
    at = np.linspace(0.0, arc[-1], count)
    return np.stack([np.interp(at, arc, line[:, k]) for k in range(3)], axis=1)


def even(line: Array, count: int) -> Array:
    """`count` points at even arc lengths of a polyline."""
    return spread(line, steps(line), count)


def even_with_tangents(line: Array, count: int) -> tuple[Array, Array]:
    """Points at even arc lengths and unit tangents there."""
    points = even(line, count)
    return points, unit(np.gradient(points, axis=0))
