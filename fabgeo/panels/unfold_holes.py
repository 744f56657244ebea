"""Holes and bend lines carried from a patch into its development.

Glossary
--------
image
    Plane point of the surface point (u, v): exact along the rulings, by arc length along the edges.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import GeometryError
from fabgeo.panels.flat import FlatHole
from fabgeo.panels.unfold_develop import Development
from fabgeo.strips.ruled import RuledPatch


class HoleLike(Protocol):
    """What is needed of a hole: see `fabgeo.structures.parts.Hole`."""

    @property
    def centre(self) -> Array: ...  # noqa: D102 - a protocol's members are documented there
    @property
    def axis(self) -> Array: ...  # noqa: D102
    @property
    def diameter(self) -> float: ...  # noqa: D102
    @property
    def slot(self) -> float: ...  # noqa: D102
    @property
    def direction(self) -> Array: ...  # noqa: D102


def hole_area(hole: FlatHole) -> float:
    """Area of a round hole or slot in mm2."""
    return float(np.pi * hole.diameter**2 / 4.0 + hole.slot * hole.diameter)


def images(mid: RuledPatch, flat: Development, u: Array, v: Array) -> Array:
    """Plane points of (u, v): exact along the rulings, Hermite along the edges."""
    k = np.clip(np.searchsorted(flat.rule.breaks, u, side="right") - 1, 0, len(flat.theta) - 2)
    sides = []
    for j in range(2):
        arc, points, tangents = flat.arcs[j], flat.edges[j], flat.tangents[j]
        at = arc[k] + _arc_between(mid, j, flat.rule.breaks[k], u)
        h = np.where(arc[k + 1] > arc[k], arc[k + 1] - arc[k], 1.0)
        t, h = ((at - arc[k]) / h)[..., None], h[..., None]
        sides.append(
            (2 * t**3 - 3 * t**2 + 1) * points[k]
            + (t**3 - 2 * t**2 + t) * h * tangents[k]
            + (-2 * t**3 + 3 * t**2) * points[k + 1]
            + (t**3 - t**2) * h * tangents[k + 1]
        )
    v = np.broadcast_to(v, u.shape)[..., None]
    return (1.0 - v) * sides[0] + v * sides[1]


def _arc_between(mid: RuledPatch, edge: int, start: Array, end: Array) -> Array:
    x, w = np.polynomial.legendre.leggauss(6)
    half = (end - start) / 2.0
    u = start[..., None] + half[..., None] * (x + 1.0)
    speed = np.linalg.norm(mid.edges(u.ravel(), 1)[edge], axis=-1).reshape(u.shape)
    return half * (speed @ w)


def flat_hole(mid: RuledPatch, flat: Development, hole: HoleLike, mark: str) -> FlatHole:
    """Follow the hole's axis to the mid-surface, then its (u, v) into the plane."""
    u, v = _meet(mid, hole.centre, hole.axis, mark)
    here = images(mid, flat, np.array([u]), np.array([v]))[0]
    if hole.slot <= 0.0:
        return FlatHole(here, hole.diameter)
    a, b = mid.edges(np.array([u]))[:, 0]
    velocity = mid.edges(np.array([u]), 1)[:, 0]
    x_u, x_v = (1.0 - v) * velocity[0] + v * velocity[1], b - a
    # The slot's direction along the axis into the tangent plane: d = du x_u + dv x_v + s axis.
    du, dv, _ = np.linalg.solve(np.stack([x_u, x_v, hole.axis], axis=-1), hole.direction)
    ends = images(mid, flat, np.array([u, u]), np.array([0.0, 1.0]))
    step = 1e-4 * (mid.u1 - mid.u0)
    low, high = max(u - step, mid.u0), min(u + step, mid.u1)
    pair = images(mid, flat, np.array([low, high]), np.array([v, v]))
    direction = du * (pair[1] - pair[0]) / (high - low) + dv * (ends[1] - ends[0])
    angle = float(np.arctan2(direction[1], direction[0])) % np.pi
    return FlatHole(here, hole.diameter, hole.slot, angle)


def _meet(mid: RuledPatch, centre: Array, axis: Array, mark: str) -> tuple[float, float]:
    """Parameters where the line centre + s axis meets the patch, by Newton's method."""
    grid = mid.parameters(4)
    a, b = mid.edges(grid)
    middle = (a + b) / 2.0 - centre
    away = middle - (middle @ axis)[:, None] * axis
    u, v, s = float(grid[np.argmin(np.linalg.norm(away, axis=-1))]), 0.5, 0.0
    for _ in range(50):
        a, b = mid.edges(np.array([u]))[:, 0]
        da, db = mid.edges(np.array([u]), 1)[:, 0]
        gap = (1.0 - v) * a + v * b - centre - s * axis
        jacobian = np.stack([(1.0 - v) * da + v * db, b - a, -axis], axis=-1)
        step = np.linalg.solve(jacobian, -gap)
        u = float(np.clip(u + step[0], mid.u0, mid.u1))
        v, s = v + float(step[1]), s + float(step[2])
        if np.linalg.norm(gap) < 1e-9:
            break
    else:
        raise GeometryError(mark, "a hole's axis misses the patch", "move the hole inside the part")
    if not 0.0 <= v <= 1.0:
        raise GeometryError(mark, "a hole lies outside the patch", "move the hole inside the part")
    return u, v
