"""Tangents, rulings and strip normals of a strip model at given parameters.

Glossary
--------
t_i
    Unit tangent of edge curve p_i.
e_i
    Unit ruling of strip i from p_i to p_{i+1}; at an interior edge ``e+`` leads to p_{i+1} and
    ``e-`` to p_{i-1}: both leave the edge.
m
    Unit normal of a strip along a ruling, on the side of ``t x e``.
first, second
    The ends of a ruling: on p_i and on p_{i+1}.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fabgeo import spline
from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.errors import GeometryError

LEAST = 1e-60  # length in any unit, so that products of several are no zeros


class EdgeCurves(Protocol):
    """What the constructions ask of a model: `StripModel` and the exact models answer it."""

    @property
    def edges(self) -> int:
        """Number of edge curves."""
        ...

    @property
    def strips(self) -> int:
        """Number of strips."""
        ...

    @property
    def segments(self) -> int:
        """U runs over [0, segments]."""
        ...

    @property
    def closed_u(self) -> bool:
        """Whether edge curves are closed."""
        ...

    @property
    def closed_i(self) -> bool:
        """Whether the last edge is joined to the first by a strip."""
        ...

    def points(self, u: Array, derivative: int = 0) -> Array:
        """Points or u-derivatives (edges, k, 3)."""
        ...

    def parameters(self, per_segment: int = 4) -> Array:
        """Evenly spaced parameters."""
        ...


@dataclass(frozen=True)
class Frames:
    """Everything first-order about a model at parameters u (k,).

    Attributes
    ----------
    u : (k,) array
    p, dp : (edges, k, 3) arrays
        Points and u-derivatives.
    t : (edges, k, 3) array
        Unit tangents.
    e : (strips, k, 3) array
        Unit rulings.
    length : (strips, k) array
        Lengths of the rulings.
    m_first, m_second : (strips, k, 3) arrays
        Unit normals of the strip at both ends of the ruling; equal where it is developable.
    m : (strips, k, 3) array
        The strip's normal, symmetric in both ends.
    closed_i : bool
    """

    u: Array
    p: Array
    dp: Array
    t: Array
    e: Array
    length: Array
    m_first: Array
    m_second: Array
    m: Array
    closed_i: bool

    def sides(self, values: Array) -> tuple[Array, Array]:
        """Values per edge as the two sides of every strip."""
        return two_sides(values, self.closed_i)

    def at_edges(self, values: Array) -> tuple[Array, Array]:
        """Values per strip as those before and after every interior edge.

        A model closed in i has no other edges: all `edges` of them, beginning with edge 0; an
        open one has the edges 1 to n - 1.
        """
        if self.closed_i:
            return np.roll(values, 1, axis=0), values
        return values[:-1], values[1:]

    @property
    def interior(self) -> range:
        """Indices of the edges that `at_edges` speaks of."""
        return range(len(self.p)) if self.closed_i else range(1, len(self.p) - 1)


@dataclass(frozen=True)
class Rows:
    """Some consecutive edges of a model as a model of their own: cheap to evaluate.

    Attributes
    ----------
    model : EdgeCurves
    rows : tuple of int
        Edge indices in order; of a model closed in i they may pass its seam.
    """

    model: EdgeCurves
    rows: tuple[int, ...]
    closed_i: bool = False

    @property
    def edges(self) -> int:
        """Number of edges."""
        return len(self.rows)

    @property
    def strips(self) -> int:
        """Number of strips between them."""
        return len(self.rows) - 1

    @property
    def segments(self) -> int:
        """U runs over [0, segments]."""
        return self.model.segments

    @property
    def closed_u(self) -> bool:
        """Whether edge curves are closed."""
        return self.model.closed_u

    def points(self, u: Array, derivative: int = 0) -> Array:
        """Points or u-derivatives (rows, k, 3)."""
        control = getattr(self.model, "control", None)
        if control is None:
            return self.model.points(u, derivative)[list(self.rows)]
        return spline.evaluate(control[list(self.rows)], u, self.closed_u, derivative)

    def parameters(self, per_segment: int = 4) -> Array:
        """Evenly spaced parameters."""
        return self.model.parameters(per_segment)


def around(model: EdgeCurves, first: int, last: int) -> tuple[Rows, int]:
    """Edges `first` to `last` as far as the model has them, and the row of edge `first` + 1.

    For ``around(model, i - 1, i + 1)`` the second value is the row of edge i.
    """
    if model.closed_i:
        rows = tuple(i % model.edges for i in range(first, last + 1))
        return Rows(model, rows), 1
    low, high = max(first, 0), min(last, model.edges - 1)
    return Rows(model, tuple(range(low, high + 1))), first + 1 - low


def two_sides(values: Array, closed_i: bool) -> tuple[Array, Array]:
    """Values per edge (edges, ...) as the two sides of every strip, each (strips, ...)."""
    if closed_i:
        return values, np.roll(values, -1, axis=0)
    return values[:-1], values[1:]


def frames(model: EdgeCurves, u: Array) -> Frames:
    """Tangents, rulings and normals at parameters u (k,)."""
    u = np.atleast_1d(np.asarray(u, dtype=np.float64))
    p, dp = model.points(u), model.points(u, 1)
    t = unit(dp)
    p0, p1 = two_sides(p, model.closed_i)
    t0, t1 = two_sides(t, model.closed_i)
    e = unit(p1 - p0)
    return Frames(
        u=u,
        p=p,
        dp=dp,
        t=t,
        e=e,
        length=np.linalg.norm(p1 - p0, axis=-1),
        m_first=unit(cross(t0, e)),
        m_second=unit(cross(t1, e)),
        m=unit(cross(t0 + t1, e)),
        closed_i=model.closed_i,
    )


def check_lengths(name: str, f: Frames) -> None:
    """Refuse strips that have no normal somewhere.

    Raises
    ------
    GeometryError
        If a ruling, a tangent or a normal has no length; names the place.
    """
    sizes = {
        "strip {} at u = {:.6g}: the ruling": f.length,
        "edge {} at u = {:.6g}: the tangent": np.linalg.norm(f.dp, axis=-1),
        "strip {} at u = {:.6g}: the normal": np.abs(f.m_first).max(axis=-1)
        + np.abs(f.m_second).max(axis=-1),
    }
    for what, length in sizes.items():
        row, k = np.unravel_index(int(np.argmin(length)), length.shape)
        if not length[row, k] > LEAST:
            where = f"{name}, {what.format(row, f.u[k])}"
            raise GeometryError(where, "has no length", "move control points apart")


@dataclass(frozen=True)
class NormalChange:
    """How a strip's normal turns along u, from second derivatives.

    Attributes
    ----------
    e : (strips, k, 3) array
        u-derivative of the unit ruling.
    m_first, m_second : (strips, k, 3) arrays
        u-derivatives of the normals at both ends.
    """

    e: Array
    m_first: Array
    m_second: Array


def normal_change(model: EdgeCurves, f: Frames) -> NormalChange:
    """u-derivatives of rulings and strip normals at the parameters of `f`."""
    ddp = model.points(f.u, 2)
    d0, d1 = f.sides(f.dp)
    dd0, dd1 = f.sides(ddp)
    chord = d1 - d0
    de = (chord - dot(chord, f.e)[..., None] * f.e) / f.length[..., None]
    return NormalChange(
        de,
        _unit_change(cross(d0, f.e), cross(dd0, f.e) + cross(d0, de)),
        _unit_change(cross(d1, f.e), cross(dd1, f.e) + cross(d1, de)),
    )


def _unit_change(w: Array, dw: Array) -> Array:
    """Derivative of w / |w|."""
    length = np.linalg.norm(w, axis=-1, keepdims=True)
    n = w / np.where(length > 0.0, length, 1.0)
    return (dw - dot(dw, n)[..., None] * n) / np.where(length > 0.0, length, 1.0)
