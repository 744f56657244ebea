"""Curve nets: grids of points on a surface from which initial strip models are drawn.

Glossary
--------
net
    Points P[s, t]: rows run across the strips (s), columns along the edges (t).
edges
    Lines s = const; rulings follow the lines t = const, or are made conjugate (see conjugate.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from fabgeo import spline
from fabgeo.arrays import Array, set_frozen
from fabgeo.errors import InputError
from fabgeo.strips.model import StripModel


@dataclass(frozen=True)
class Net:
    """A grid of points, smooth between them: a tensor product of uniform cubic splines.

    Attributes
    ----------
    points : (S, T, 3) array
        Rows are candidate edge curves.
    closed_s, closed_t : bool
        Whether the last row is followed by the first, the last column by the first (no point is
        given twice).
    """

    points: Array
    closed_s: bool = False
    closed_t: bool = False

    def __post_init__(self) -> None:
        set_frozen(self, "points", ("S", "T", 3))
        rows, columns, _ = self.points.shape
        if rows < (3 if self.closed_s else 2) or columns < (3 if self.closed_t else 2):
            raise InputError("Net.points", f"too few points for a net: {rows} x {columns}")

    @property
    def turned(self) -> Net:
        """The same net with rows and columns exchanged: edges along the other family."""
        return Net(np.swapaxes(self.points, 0, 1), self.closed_t, self.closed_s)

    def evaluate(self, s: npt.ArrayLike, t: npt.ArrayLike, ds: int = 0, dt: int = 0) -> Array:
        """Points or derivatives by (s, t), both in [0, 1], of equal shape: (..., 3)."""
        control = self._control
        rows, columns = (
            _count(n, c) for n, c in zip(self.points.shape, self._closed, strict=False)
        )
        i, a = spline.basis(np.asarray(s) * rows, rows, self.closed_s, ds)
        j, b = spline.basis(np.asarray(t) * columns, columns, self.closed_t, dt)
        corner = control[i[..., :, None], j[..., None, :]]
        scale = float(rows) ** ds * float(columns) ** dt
        return scale * np.einsum("...abk,...a,...b->...k", corner, a, b)

    @property
    def _closed(self) -> tuple[bool, bool]:
        return self.closed_s, self.closed_t

    @cached_property
    def _control(self) -> Array:
        along = interpolate(self.points, self.closed_t)
        return np.swapaxes(interpolate(np.swapaxes(along, 0, 1), self.closed_s), 0, 1)

    def places(self, strips: int) -> Array:
        """Values of s of `strips` + 1 edges (closed in s: `strips`) of about equal spacing.

        Edges are placed by the mean length of the lines t = const, so that strips are of even
        mean width.
        """
        s = np.linspace(0.0, 1.0, 201)
        t = (np.arange(24) + 0.5) / 24.0
        grid = self.evaluate(*np.meshgrid(s, t, indexing="ij"))
        length = np.linalg.norm(np.diff(grid, axis=0), axis=-1).mean(axis=1)
        return _even(s, length, strips, self.closed_s)

    def stations(self, segments: int) -> Array:
        """Values of t of `segments` + 1 points (closed in t: `segments`), of even mean spacing."""
        return self.turned.places(segments)

    def sampled(self, s: Array, t: Array) -> Array:
        """Points at s (E,) and t (E, M) or (M,): (E, M, 3)."""
        t = np.broadcast_to(t, (len(s), np.shape(t)[-1]))
        return self.evaluate(np.broadcast_to(s[:, None], t.shape), t)


def interpolate(points: Array, closed: bool) -> Array:
    """`spline.interpolate` also for two or three points (a straight line, a parabola)."""
    count = points.shape[-2]
    if closed or count >= 4:
        return spline.interpolate(points, closed)
    b = np.concatenate([points[..., :1, :], points, points[..., -1:, :]], axis=-2)
    if count == 2:
        b[..., 0, :] = 2.0 * points[..., 0, :] - points[..., 1, :]
        b[..., -1, :] = 2.0 * points[..., 1, :] - points[..., 0, :]
        return b
    # Three points: the parabola x(u) = p1 + d (u - 1) + c (u - 1)^2 has control points
    # x at the Greville places less c / 3.
    c = (points[..., 2, :] - 2.0 * points[..., 1, :] + points[..., 0, :]) / 2.0
    d = (points[..., 2, :] - points[..., 0, :]) / 2.0
    u = np.arange(-2.0, 3.0)[:, None]
    return points[..., 1:2, :] + d[..., None, :] * u + c[..., None, :] * (u**2 - 1.0 / 3.0)


def model_through(points: Array, closed_u: bool, closed_i: bool) -> StripModel:
    """The model whose edge curves pass points (edges, m + 1, 3), closed in u: (edges, m, 3)."""
    return StripModel(interpolate(points, closed_u), closed_u, closed_i)


def _count(points: int, closed: bool) -> int:
    return points if closed else points - 1


def _even(s: Array, length: Array, count: int, closed: bool) -> Array:
    arc = np.concatenate([[0.0], np.cumsum(length)])
    wanted = np.linspace(0.0, arc[-1], count + 1)
    places = np.interp(wanted, arc, s)
    return places[:-1] if closed else places
