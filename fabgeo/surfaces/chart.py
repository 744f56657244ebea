"""Charts: one parametric patch x(u, v) with exact derivatives, and its foot points.

Glossary
--------
chart
    A map from a rectangle of parameters to space, evaluated with first and second derivatives.
foot point
    The parameters (u, v) at which the chart is closest to a query point.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fabgeo.arrays import Array, BoolArray, IntArray, cross, dot, unit


@dataclass(frozen=True, slots=True, eq=False)
class Derivatives:
    """A chart's points and derivatives at k parameters, each (k, 3)."""

    point: Array
    u: Array
    v: Array
    uu: Array
    uv: Array
    vv: Array

    def __getitem__(self, index: BoolArray | IntArray) -> Derivatives:
        return Derivatives(*(a[index] for a in self.arrays()))

    def arrays(self) -> tuple[Array, ...]:
        """The six arrays in order."""
        return self.point, self.u, self.v, self.uu, self.uv, self.vv

    def put(self, index: IntArray, other: Derivatives) -> None:
        """Overwrite the rows `index`."""
        for mine, theirs in zip(self.arrays(), other.arrays(), strict=True):
            mine[index] = theirs


class Chart(Protocol):
    """What a parametric patch answers."""

    @property
    def domain(self) -> Array:
        """Parameter rectangle (2, 2): [[u0, u1], [v0, v1]]."""
        ...

    # Whether the chart is periodic in u, in v; set once the sides were compared.
    closed: tuple[bool, bool]

    @property
    def spans(self) -> tuple[int, int]:
        """How many pieces of simple shape it has in u and v: how densely to sample it."""
        ...

    def evaluate(self, u: Array, v: Array) -> Derivatives:
        """Points and derivatives at parameters u, v (k,)."""
        ...


def normals(d: Derivatives) -> Array:
    """Unit normals (k, 3) of x_u x x_v."""
    return unit(cross(d.u, d.v))


def shape_tensors(d: Derivatives, normal: Array) -> Array:
    """Shape tensors (k, 3, 3) from the two fundamental forms.

    With the dual tangents a^i (a^i . x_j = delta_ij) the tensor is sum h_ij a^i a^j, where
    h_ij = x_ij . n: its quadratic form in a unit tangent is the normal curvature.
    Source: do Carmo, Differential Geometry of Curves and Surfaces, section 3.3.
    """
    e, f, g = dot(d.u, d.u), dot(d.u, d.v), dot(d.v, d.v)
    det = np.maximum(e * g - f * f, 1e-300)[:, None]
    dual_u = (g[:, None] * d.u - f[:, None] * d.v) / det
    dual_v = (e[:, None] * d.v - f[:, None] * d.u) / det
    huu, huv, hvv = dot(d.uu, normal), dot(d.uv, normal), dot(d.vv, normal)
    mixed = huv[:, None, None] * dual_u[:, :, None] * dual_v[:, None, :]
    return (
        huu[:, None, None] * dual_u[:, :, None] * dual_u[:, None, :]
        + hvv[:, None, None] * dual_v[:, :, None] * dual_v[:, None, :]
        + mixed
        + np.swapaxes(mixed, 1, 2)
    )


def inside(chart: Chart, u: Array, v: Array) -> tuple[Array, Array]:
    """Parameters brought into the domain: wrapped where periodic, clamped where not."""
    brought = []
    for value, (low, high), closed in zip((u, v), chart.domain, chart.closed, strict=True):
        if closed:
            brought.append(low + np.mod(value - low, high - low))
        else:
            brought.append(np.clip(value, low, high))
    return brought[0], brought[1]


def at_sides(chart: Chart, u: Array, v: Array) -> BoolArray:
    """Whether parameters lie on a side of the domain that is not periodic."""
    found = np.zeros(len(u), dtype=bool)
    for value, (low, high), closed in zip((u, v), chart.domain, chart.closed, strict=True):
        if not closed:
            found |= (value <= low) | (value >= high)
    return found


def foot_points(
    chart: Chart, x: Array, u: Array, v: Array, steps: int = 40, tolerance: float = 1e-11
) -> tuple[Array, Array, Derivatives]:
    """Foot points of `x` (k, 3) from starting parameters, by safeguarded Newton steps.

    A step is taken only if it brings the point closer; otherwise it is damped (Levenberg). Where
    the second derivatives make the matrix indefinite, the Gauss-Newton matrix takes its place.
    At an open border the step runs along the border. A point is done when a full step is shorter
    than `tolerance` times the chart's reach from it.

    Returns
    -------
    u, v : (k,) arrays
    derivatives : Derivatives
        At the foot points.
    """
    u, v = inside(chart, u.copy(), v.copy())
    at = chart.evaluate(u, v)
    damping = np.zeros(len(u))
    square = dot(at.point - x, at.point - x)
    todo = np.arange(len(u))
    for _ in range(steps):
        if not len(todo):
            break
        here = at[todo]
        du, dv, length = _step(chart, here, x[todo], u[todo], v[todo], damping[todo])
        reach = np.abs(here.point).max(axis=1) + np.sqrt(square[todo])
        going = length > tolerance * reach
        todo, du, dv = todo[going], du[going], dv[going]
        if not len(todo):
            break
        new_u, new_v = inside(chart, u[todo] + du, v[todo] + dv)
        new = chart.evaluate(new_u, new_v)
        new_square = dot(new.point - x[todo], new.point - x[todo])
        good = new_square <= square[todo] + 1e-14 * dot(new.point, new.point)  # rounding
        taken = todo[good]
        u[taken], v[taken], square[taken] = new_u[good], new_v[good], new_square[good]
        at.put(taken, new[good])
        damping[todo] = np.where(good, damping[todo] * 0.1, np.maximum(damping[todo] * 8.0, 0.05))
        todo = todo[damping[todo] < 1e6]
    return u, v, at


def _step(
    chart: Chart, d: Derivatives, x: Array, u: Array, v: Array, damping: Array
) -> tuple[Array, Array, Array]:
    """Newton step of the squared distance in parameters, and its length in space."""
    r = d.point - x
    gu, gv = dot(d.u, r), dot(d.v, r)
    e, f, g = dot(d.u, d.u), dot(d.u, d.v), dot(d.v, d.v)
    a, b, c = e + dot(d.uu, r), f + dot(d.uv, r), g + dot(d.vv, r)
    weak = (a < 1e-3 * e) | (c < 1e-3 * g) | (a * c - b * b < 1e-4 * (e * g - f * f))
    a, b, c = (np.where(weak, s, t) for s, t in ((e, a), (f, b), (g, c)))
    tiny = 1e-14 * (e + g) + 1e-300
    a, c = a + damping * e + tiny, c + damping * g + tiny
    (u0, u1), (v0, v1) = chart.domain
    held_u, held_v = (
        (not closed) & (((s <= low) & (slope > 0.0)) | ((s >= high) & (slope < 0.0)))
        for s, low, high, slope, closed in (
            (u, u0, u1, gu, chart.closed[0]),
            (v, v0, v1, gv, chart.closed[1]),
        )
    )
    det = np.maximum(a * c - b * b, 1e-14 * a * c)
    du, dv = (b * gv - c * gu) / det, (b * gu - a * gv) / det
    du, dv = np.where(held_v, -gu / a, du), np.where(held_u, -gv / c, dv)
    du, dv = np.where(held_u, 0.0, du), np.where(held_v, 0.0, dv)
    # No step longer than a fifth of the domain: the start is at most one sample away.
    du = np.clip(du, -0.2 * (u1 - u0), 0.2 * (u1 - u0))
    dv = np.clip(dv, -0.2 * (v1 - v0), 0.2 * (v1 - v0))
    # A step out of the domain is cut at the border; its length counts only inside.
    if not chart.closed[0]:
        du = np.clip(u + du, u0, u1) - u
    if not chart.closed[1]:
        dv = np.clip(v + dv, v0, v1) - v
    return du, dv, np.sqrt(np.maximum(e * du * du + 2.0 * f * du * dv + g * dv * dv, 0.0))
