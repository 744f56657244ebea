"""The development of a developable ruled patch: its rulings laid into the plane.

Glossary
--------
ruling frame
    E = (cos theta, sin theta), the image of the unit ruling e, and P, E turned by -90 degrees,
    the image of the direction of growing u at right angles to the ruling.
side speeds
    |a'_perp|, |b'_perp|: the edge curves' speeds at right angles to the ruling.

A development keeps the speed of both edge curves and their angle to the rulings. Both are given by
the components along e and at right angles to it, so in the plane

    A' = (a' . e) E + |a'_perp| P,    B' = (b' . e) E + |b'_perp| P,    B - A = L E,

and B' - A' = L' E + L E' leaves theta' = (|a'_perp| - |b'_perp|) / L: the rulings' rotation is
integrated once, then the position. Edges, rulings and the angles between them are exact even where
the patch is slightly twisted; the stretch then lies between the edges (about twist^2 / 8).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, dot
from fabgeo.errors import GeometryError
from fabgeo.panels.unfold_quadrature import Quadrature, pieces
from fabgeo.strips.ruled import RuledPatch

LEAST_PIECES, MAX_PIECES = 8, 1024


@dataclass(frozen=True)
class Development:
    """A patch in the plane at break points, seen from the side of x_u cross x_v.

    Attributes
    ----------
    rule : Quadrature
        Its break points are those of the arrays below.
    edges : (2, k, 2) array
        Images A, B of both edge curves.
    tangents : (2, k, 2) array
        Their unit tangents.
    arcs : (2, k) array
        Their arc lengths from the first ruling.
    theta : (k,) array
        Direction of the rulings.
    """

    rule: Quadrature
    edges: Array
    tangents: Array
    arcs: Array
    theta: Array


@dataclass(frozen=True)
class _Rates:
    """What the patch does at parameters u of any shape."""

    length: Array
    along: Array  # (2, ...) a' . e and b' . e
    across: Array  # (2, ...) side speeds

    @property
    def turn(self) -> Array:
        return (self.across[0] - self.across[1]) / self.length

    @property
    def speed(self) -> Array:
        return np.hypot(self.along, self.across)


def rates(mid: RuledPatch, u: Array, mark: str = "patch") -> _Rates:
    """Ruling length and edge speeds along and across the ruling at u.

    Raises
    ------
    GeometryError
        If a ruling has no length or the rulings cross inside the patch.
    """
    shape = u.shape
    a, b = mid.edges(u.ravel())
    velocity = mid.edges(u.ravel(), 1)
    ruling = b - a
    length = np.linalg.norm(ruling, axis=-1)
    if length.min() < 1e-9 * max(1.0, float(length.max())):
        raise GeometryError(mark, "a ruling has no length", "trim the patch before its tip")
    e = ruling / length[:, None]
    along = dot(velocity, e)
    perp = velocity - along[..., None] * e
    # One direction of growing u serves both edges; a sign change is a fold.
    sense = perp[0] + perp[1]
    sign = np.where(dot(perp, sense) < 0.0, -1.0, 1.0)
    across = sign * np.linalg.norm(perp, axis=-1)
    if across.min() < -1e-9 * np.abs(across).max():
        raise GeometryError(
            mark, "the rulings cross inside the patch, it can't be laid flat", "trim or refit it"
        )
    return _Rates(length.reshape(shape), along.reshape(2, *shape), across.reshape(2, *shape))


def develop(mid: RuledPatch, mark: str = "patch", tolerance: float = 1e-4) -> Development:
    """Lay the patch into the plane; pieces are halved until each meets the stated tolerance.

    Parameters
    ----------
    tolerance : float
        Largest distance, in mm, of the outline as cubic Hermite curves over its break points from
        the integrated curve, and largest error of the quadrature.
    """
    rule = Quadrature(pieces(mid.knots, LEAST_PIECES))
    while True:
        flat, errors = _integrated(mid, rule, mark)
        coarse = errors > tolerance
        if not coarse.any():
            return flat
        if len(errors) >= MAX_PIECES:
            raise GeometryError(
                mark,
                f"the development is exact to {errors.max():.2g} mm only, expected {tolerance:.2g}",
            )
        rule = rule.halved(coarse)


def _integrated(mid: RuledPatch, rule: Quadrature, mark: str) -> tuple[Development, Array]:
    """The development by one rule, and the error (p,) of each of its pieces."""
    inside, ends = rates(mid, rule.nodes, mark), rates(mid, rule.breaks, mark)
    theta_nodes, theta = rule.cumulative(inside.turn)
    theta_nodes, theta = theta_nodes + np.pi / 2.0, theta + np.pi / 2.0
    ruling, across = _frame(theta_nodes)
    velocity = inside.along[0, ..., None] * ruling + inside.across[0, ..., None] * across
    first_nodes, first = rule.cumulative(velocity)
    edge_nodes = np.stack([first_nodes, first_nodes + inside.length[..., None] * ruling])
    ruling, across = _frame(theta)
    edges = np.stack([first, first + ends.length[:, None] * ruling])
    speed = np.where(ends.speed > 0.0, ends.speed, 1.0)
    tangents = (ends.along[..., None] * ruling + ends.across[..., None] * across) / speed[..., None]
    arc_pairs = [rule.cumulative(s) for s in inside.speed]
    arcs = np.stack([pair[1] for pair in arc_pairs])
    errors = rule.tail(velocity) + rule.tail(inside.turn) * float(arcs.max())
    for k in range(2):
        seen = hermite(arcs[k], edges[k], tangents[k], arc_pairs[k][0])
        errors = np.maximum(errors, np.linalg.norm(seen - edge_nodes[k], axis=-1).max(axis=1))
    return Development(rule, edges, tangents, arcs, theta), errors


def _frame(theta: Array) -> tuple[Array, Array]:
    c, s = np.cos(theta), np.sin(theta)
    return np.stack([c, s], axis=-1), np.stack([s, -c], axis=-1)


def hermite(arc: Array, points: Array, tangents: Array, at: Array) -> Array:
    """Points of the cubic Hermite curves over arc lengths (k,), at lengths `at` (k - 1, n)."""
    step = np.diff(arc)[:, None]
    safe = np.where(step > 0.0, step, 1.0)
    t = ((at - arc[:-1, None]) / safe)[..., None]
    h = step[..., None]
    p, q = points[:-1, None], points[1:, None]
    v, w = tangents[:-1, None], tangents[1:, None]
    return (
        (2.0 * t**3 - 3.0 * t**2 + 1.0) * p
        + (t**3 - 2.0 * t**2 + t) * h * v
        + (-2.0 * t**3 + 3.0 * t**2) * q
        + (t**3 - t**2) * h * w
    )
