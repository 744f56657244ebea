"""Geodesic strips as planks: their developments, the rectangle each needs, and congruent edges.

Glossary
--------
plank
    The smallest rectangle around a developed strip: what it can be cut from.
bow
    How far the developed strip's middle line leaves the straight line between its ends.
opposite congruence
    Neighbouring strips develop their common edge to curves that are mirror images of each other:
    the property of geodesic models (paper, Fig. 4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from fabgeo.arrays import Array, cross
from fabgeo.strips.model import StripModel


@dataclass(frozen=True)
class Plank:
    """The smallest rectangle of a developed strip, and its bow, in the model's unit."""

    strip: int
    length: float
    width: float
    bow: float


def developed(model: StripModel, strip: int, per_segment: int = 16) -> Array:
    """Both edges of a strip in the plane, (2, k, 2), ruling by ruling.

    The quads between close rulings are laid out as pairs of triangles; of a developable strip the
    error falls with the square of the spacing.
    """
    u = np.linspace(0.0, model.segments, model.segments * per_segment + 1)
    a, b = model.edge(strip, u), model.edge(strip + 1, u)
    flat = np.zeros((2, len(u), 2))
    flat[1, 0, 1] = np.linalg.norm(b[0] - a[0])
    for k in range(len(u) - 1):
        flat[0, k + 1] = _third(flat[0, k], flat[1, k], a[k], b[k], a[k + 1])
        flat[1, k + 1] = _third(flat[0, k + 1], flat[1, k], a[k + 1], b[k], b[k + 1])
    return flat


def planks(model: StripModel) -> list[Plank]:
    """The smallest rectangle that each developed strip needs."""
    found = []
    for strip in range(model.strips):
        flat = developed(model, strip)
        length, width = _smallest_rectangle(flat.reshape(-1, 2))
        middle = flat.mean(axis=0)
        chord = middle[-1] - middle[0]
        normal = np.array([-chord[1], chord[0]]) / max(float(np.linalg.norm(chord)), 1e-300)
        found.append(
            Plank(strip, length, width, float(np.abs((middle - middle[0]) @ normal).max()))
        )
    return found


def opposite_congruence(model: StripModel) -> Array:
    """Largest distance between the developments of each common edge over its length: (e,).

    The edge as the second of one strip is compared with its mirror image as the first of the next,
    after the rigid motion that fits them best.
    """
    flats = [developed(model, s) for s in range(model.strips)]
    neighbours = [(s, s + 1) for s in range(model.strips - 1)]
    if model.closed_i:
        neighbours.append((model.strips - 1, 0))
    return np.array([_unlike(flats[i][1], flats[j][0]) for i, j in neighbours])


def _unlike(one: Array, other: Array) -> float:
    """Distance of two point rows of which one is mirrored, over their length."""
    a = one - one.mean(axis=0)
    b = (other - other.mean(axis=0)) * np.array([1.0, -1.0])
    turn = np.arctan2(np.sum(b[:, 0] * a[:, 1] - b[:, 1] * a[:, 0]), np.sum(a * b))
    c, s = np.cos(turn), np.sin(turn)
    moved = b @ np.array([[c, s], [-s, c]])
    length = float(np.linalg.norm(np.diff(a, axis=0), axis=1).sum())
    return float(np.linalg.norm(moved - a, axis=1).max()) / length


def _third(p: Array, q: Array, a: Array, b: Array, c: Array) -> Array:
    """The plane point at the distances of c from a and b, on the right of p -> q."""
    e = b - a
    size = np.linalg.norm(e)
    x = float(e @ (c - a)) / size
    y = float(np.linalg.norm(cross(e, c - a))) / size
    d = (q - p) / size
    return p + x * d + y * np.array([d[1], -d[0]])


def _smallest_rectangle(points: Array) -> tuple[float, float]:
    """Length and width of the rectangle of least area: one side lies on a side of the hull."""
    hull = points[ConvexHull(points).vertices]
    side = np.roll(hull, -1, axis=0) - hull
    side = side / np.linalg.norm(side, axis=1)[:, None]
    along, across = hull @ side.T, hull @ np.stack([-side[:, 1], side[:, 0]])
    sizes = np.stack([np.ptp(along, axis=0), np.ptp(across, axis=0)])
    best = sizes[:, int(np.argmin(sizes.prod(axis=0)))]
    return float(best.max()), float(best.min())
