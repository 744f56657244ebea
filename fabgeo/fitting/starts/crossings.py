"""Where the curves of two families cross: the nodes of a net."""

from __future__ import annotations

import numpy as np

from fabgeo import spline
from fabgeo.arrays import Array, IntArray, dot
from fabgeo.fitting.starts.net import interpolate


def crossings(rows: Array, columns: Array, steps: int = 8) -> Array:
    """Nodes (R, C, 3) where rows (R, a, 3) and columns (C, b, 3) cross; nan where they don't.

    The nearest pair of points of two curves is refined by Gauss-Newton on the splines through them.
    Curves cross if they come closer than a tenth of their point spacing, not at their ends.
    """
    place, other = _nearest(rows, columns)
    first, second = interpolate(rows, False), interpolate(columns, False)
    a, b = place.astype(np.float64), other.astype(np.float64)
    for _ in range(steps):
        p, dp = _at(first, a, 0), _at(first, a, 0, 1)
        q, dq = _at(second, b, 1), _at(second, b, 1, 1)
        r = p - q
        e, f, g = dot(dp, dp), -dot(dp, dq), dot(dq, dq)
        x, y = dot(dp, r), -dot(dq, r)
        det = np.maximum(e * g - f * f, 1e-12 * e * g)
        a = np.clip(a - np.clip((g * x - f * y) / det, -2.0, 2.0), 0.0, rows.shape[1] - 1.0)
        b = np.clip(b - np.clip((e * y - f * x) / det, -2.0, 2.0), 0.0, columns.shape[1] - 1.0)
    p, q = _at(first, a, 0), _at(second, b, 1)
    spacing = np.linalg.norm(_at(first, a, 0, 1), axis=-1)
    far = np.linalg.norm(p - q, axis=-1) > 0.1 * spacing
    return np.where(far[..., None], np.nan, (p + q) / 2.0)


def _nearest(rows: Array, columns: Array) -> tuple[IntArray, IntArray]:
    """Indices of the nearest points of every row and column: (R, C) each."""
    place = np.empty((len(rows), len(columns)), dtype=np.int64)
    other = np.empty_like(place)
    for i, row in enumerate(rows):
        for j, column in enumerate(columns):
            square = np.sum((row[:, None] - column[None]) ** 2, axis=-1)
            place[i, j], other[i, j] = np.unravel_index(int(np.argmin(square)), square.shape)
    return place, other


def _at(control: Array, u: Array, axis: int, derivative: int = 0) -> Array:
    """Curve i (axis 0) or j (axis 1) at its parameter u[i, j]: (R, C, 3)."""
    index, value = spline.basis(u, control.shape[1] - 3, False, derivative)
    curve = np.arange(len(control))
    curve = curve[:, None, None] if axis == 0 else curve[None, :, None]
    return np.einsum("rcak,rca->rck", control[curve, index], value)
