"""Holes and bend lines carried from a patch into its development.

Glossary
--------
image
    Plane point of the surface point (u, v): exact along the rulings, by arc length along the edges.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import GeometryError
from fabgeo.panels.flat import FlatHole
from fabgeo.panels.unfold_develop import Development
from fabgeo.strips.pierce import pierce
from fabgeo.strips.ruled import RuledPatch

_NODES, _WEIGHTS = (np.asarray(x, dtype=np.float64) for x in np.polynomial.legendre.leggauss(6))
MISSED = 1e-6  # mm between an axis and the point found for it


class HoleLike(Protocol):
    """What is needed of a hole: see `fabgeo.structures.parts.Hole`."""

    @property
    def centre(self) -> Array:
        """Centre (3,) on the mid-surface, in mm."""
        ...

    @property
    def axis(self) -> Array:
        """Unit direction (3,) of drilling."""
        ...

    @property
    def diameter(self) -> float:
        """Diameter in mm."""
        ...

    @property
    def slot(self) -> float:
        """Length in mm between the centres of a slot's ends; 0 for a round hole."""
        ...

    @property
    def direction(self) -> Array:
        """Direction (3,) of a slot."""
        ...


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
    half = (end - start) / 2.0
    u = start[..., None] + half[..., None] * (_NODES + 1.0)
    speed = np.linalg.norm(mid.edges(u.ravel(), 1)[edge], axis=-1).reshape(u.shape)
    return half * (speed @ _WEIGHTS)


def flat_holes(
    mid: RuledPatch, flat: Development, holes: Sequence[HoleLike], mark: str
) -> tuple[FlatHole, ...]:
    """Follow the holes' axes to the mid-surface, then their (u, v) into the plane.

    Raises
    ------
    GeometryError
        If an axis misses the patch.
    """
    if not holes:
        return ()
    axes = np.array([hole.axis for hole in holes])
    u, v = _met(mid, np.array([hole.centre for hole in holes]), axes, mark)
    centres = images(mid, flat, u, v)
    angles = _slot_angles(mid, flat, u, v, axes, np.array([hole.direction for hole in holes]))
    return tuple(
        FlatHole(centre, hole.diameter, hole.slot, float(angle))
        if hole.slot > 0.0
        else FlatHole(centre, hole.diameter)
        for hole, centre, angle in zip(holes, centres, angles, strict=True)
    )


def _slot_angles(
    mid: RuledPatch, flat: Development, u: Array, v: Array, axes: Array, directions: Array
) -> Array:
    """Angles (k,) of slots in the plane: d = du x_u + dv x_v + s axis, then du and dv there."""
    a, b = mid.edges(u)
    da, db = mid.edges(u, 1)
    x_u = da + v[:, None] * (db - da)
    frame = np.stack([x_u, b - a, axes], axis=-1)
    du, dv, _ = np.linalg.solve(frame, directions[..., None])[..., 0].T
    step = 1e-4 * (mid.u1 - mid.u0)
    low, high = np.maximum(u - step, mid.u0), np.minimum(u + step, mid.u1)
    along = (images(mid, flat, high, v) - images(mid, flat, low, v)) / (high - low)[:, None]
    across = images(mid, flat, u, np.ones_like(u)) - images(mid, flat, u, np.zeros_like(u))
    flat_direction = du[:, None] * along + dv[:, None] * across
    return np.arctan2(flat_direction[:, 1], flat_direction[:, 0]) % np.pi


def _met(mid: RuledPatch, centres: Array, axes: Array, mark: str) -> tuple[Array, Array]:
    """Parameters u, v (k,) where the lines centre + s axis meet the patch."""
    grid = mid.parameters(4)
    a, b = mid.edges(grid)
    to_middle = (a + b) / 2.0 - centres[:, None, :]
    away = to_middle - np.sum(to_middle * axes[:, None], axis=-1, keepdims=True) * axes[:, None]
    guess = grid[np.argmin(np.linalg.norm(away, axis=-1), axis=1)]
    u, v, s = pierce(mid, centres, axes, guess)
    room = 1e-12 * (mid.u1 - mid.u0)
    inside = (mid.u0 - room <= u) & (u <= mid.u1 + room) & (v >= 0.0) & (v <= 1.0)
    u = np.clip(u, mid.u0, mid.u1)
    missed = np.linalg.norm(mid.points(u, v) - centres - s[:, None] * axes, axis=-1)
    if not np.all(inside & (missed < MISSED)):
        k = int(np.argmin(inside & (missed < MISSED)))
        raise GeometryError(
            mark,
            f"the axis of its hole at {np.round(centres[k], 1).tolist()} misses the part",
            "move the hole inside the part",
        )
    return u, v
