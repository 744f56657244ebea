"""Arcs and lines within a tolerance: tangent-continuous biarcs, as few as possible.

Glossary
--------
biarc
    Two arcs from a point and tangent to another point and tangent that share their tangent where
    they meet (Bolton 1975): here with equal tangent lengths d, the joint half-way between the
    inner control points p + d t and q - d s.
tube
    All points within the tolerance of the curve. No arc leaves it: checked at dense samples.

An edge that one line or one arc follows within the tolerance becomes that one piece: its tangents
at the corners are free. Otherwise biarcs as long as the tube allows, or a chain of arcs with free
tangents where that takes fewer; all joints lie on the curve.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from fabgeo.arrays import Array, unit
from fabgeo.errors import GeometryError
from fabgeo.panels.flat import FlatEdge, FlatPart
from fabgeo.sheets.contour import Contour

SAMPLES = 6  # dense samples between two points of a flat edge
BETWEEN = 0.985  # of the tolerance is used at the samples; what lies between may go on to it
TRIALS = (1.0, 0.75, 1.3, 0.4, 0.0)  # of the even tangent


def part_contour(part: FlatPart, tolerance: float = 0.05) -> Contour:
    """Outer contour of a part: lines and arcs within `tolerance` mm, corners kept to the bit."""
    pieces = [edge_arcs(edge, tolerance, part.mark) for edge in part.outline]
    return Contour(np.concatenate(pieces))


def edge_arcs(edge: FlatEdge, tolerance: float = 0.05, mark: str = "edge") -> Array:
    """Vertices (n, 3) x, y, bulge of one edge, its last point left out.

    Raises
    ------
    GeometryError
        If the edge turns too fast between its own points to be followed.
    """
    if len(edge.points) == 2:
        return np.array([[*edge.points[0], 0.0]])
    points, tangents = dense(edge)
    tolerance = BETWEEN * tolerance
    single = _single(points, tolerance)
    if single is not None:
        return np.array([[*points[0], single]])
    best = _biarcs(points, tangents, tolerance, mark)
    # Two pieces can't be bettered: one was tried.
    return best if len(best) <= 2 else _shortest_chain(points, tangents, tolerance, best)


def dense(edge: FlatEdge, samples: int = SAMPLES) -> tuple[Array, Array]:
    """Points and unit tangents of the edge's Hermite curves, `samples` to a piece."""
    t = (np.arange(samples) / samples)[None, :, None]
    h = np.diff(edge.arc)[:, None, None]
    p, q = edge.points[:-1, None], edge.points[1:, None]
    v, w = h * edge.tangents[:-1, None], h * edge.tangents[1:, None]
    at = (2 * t**3 - 3 * t**2 + 1) * p + (t**3 - 2 * t**2 + t) * v
    at = at + (3 * t**2 - 2 * t**3) * q + (t**3 - t**2) * w
    way = (6 * t**2 - 6 * t) * (p - q) + (3 * t**2 - 4 * t + 1) * v + (3 * t**2 - 2 * t) * w
    points = np.concatenate([at.reshape(-1, 2), edge.points[-1:]])
    return points, np.concatenate([unit(way).reshape(-1, 2), edge.tangents[-1:]])


def arc_distance(start: Array, tangent: Array, curvature: float | Array, points: Array) -> Array:
    """Signed distance of points from circles through `start` with `tangent`; lines at curvature 0.

    With w = x - start and n the left normal: A / (1 + sqrt(1 + k A)), A = k w.w - 2 n.w, which is
    stable for any curvature.
    """
    w = points - start
    side = tangent[..., 0] * w[..., 1] - tangent[..., 1] * w[..., 0]
    a = curvature * np.einsum("...k,...k->...", w, w) - 2.0 * side
    return a / (1.0 + np.sqrt(np.maximum(1.0 + curvature * a, 0.0)))


def _single(points: Array, tolerance: float) -> float | None:
    """Bulge of the one line or arc from end to end within the tolerance, or None."""
    p, q = points[0], points[-1]
    chord = q - p
    size = float(np.hypot(*chord))
    if size <= 0.0:
        return None
    along = (points - p) @ chord / size
    height = (chord[0] * (points - p)[:, 1] - chord[1] * (points - p)[:, 0]) / size
    if np.any(np.diff(along) <= 0.0):
        return None
    if np.abs(height).max() <= tolerance / 50.0:
        return 0.0
    for height_of_arc in (_sagitta(along, height, size), 0.0):
        bulge = -2.0 * height_of_arc / size
        angle = 4.0 * np.arctan(bulge)
        if abs(angle) > np.pi:
            continue
        tangent = _turned(chord / size, -angle / 2.0)
        curvature = 2.0 * np.sin(angle / 2.0) / size
        gap = arc_distance(p, tangent, float(curvature), points)
        if np.abs(gap).max() <= tolerance:
            return float(bulge)
    return None


def _sagitta(along: Array, height: Array, size: float) -> float:
    """Sagitta of the arc over the chord that is fair to all points.

    Every point off the ends fixes one circle through both ends; the median of their sagittas.
    """
    inner = (along > 0.2 * size) & (along < 0.8 * size)
    x, y = along[inner], height[inner]
    product = x * (size - x)
    # Circle through (0, 0), (size, 0), (x, y): centre at height c, y^2 - 2 c y = product.
    safe = np.where(np.abs(y) > 1e-12, y, 1e-12)
    centre = (safe**2 - product) / (2.0 * safe)
    radius = np.hypot(centre, size / 2.0)
    sagittas = np.where(safe > 0.0, 1.0, -1.0) * (radius - np.abs(centre))
    return float(np.median(sagittas)) if len(sagittas) else 0.0


def _turned(v: Array, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * v[0] - s * v[1], s * v[0] + c * v[1]])


def _biarc(p: Array, t: Array, q: Array, s: Array) -> tuple[Array, Array] | None:
    """Joint and the two bulges of the biarc with equal tangent lengths."""
    v = q - p
    sum_, vv = t + s, float(v @ v)
    vs, den = float(v @ sum_), 2.0 * (1.0 - float(t @ s))
    if vs <= 0.0:
        return None
    d = vv / (2.0 * vs) if den < 1e-14 else (-vs + np.sqrt(vs * vs + den * vv)) / den
    joint = (p + q + d * (t - s)) / 2.0
    u = unit(joint - p)
    w = unit(q - joint)
    first = np.arctan2(t[0] * u[1] - t[1] * u[0], float(t @ u))
    second = np.arctan2(w[0] * s[1] - w[1] * s[0], float(w @ s))
    if max(abs(first), abs(second)) > np.pi / 2.0:
        return None
    return joint, np.tan(np.array([first, second]) / 2.0)


def _fits(points: Array, tangents: Array, i: int, j: int, tolerance: float) -> Array | None:
    """Vertices (2, 3) of the biarc from sample i to j if it stays in the tube."""
    p, t, q, s = points[i], tangents[i], points[j], tangents[j]
    made = _biarc(p, t, q, s)
    if made is None:
        return None
    joint, bulges = made
    a1, a2 = 4.0 * np.arctan(bulges)
    k1 = 2.0 * np.sin(a1 / 2.0) / max(float(np.hypot(*(joint - p))), 1e-300)
    k2 = 2.0 * np.sin(a2 / 2.0) / max(float(np.hypot(*(q - joint))), 1e-300)
    middle = _turned(t, float(a1))
    inner = points[i + 1 : j]
    before = (inner - joint) @ middle < 0.0
    gap = np.where(
        before,
        arc_distance(p, t, float(k1), inner),
        arc_distance(joint, middle, float(k2), inner),
    )
    if np.abs(gap).max(initial=0.0) > tolerance:
        return None
    return np.array([[*p, bulges[0]], [*joint, bulges[1]]])


def _biarcs(points: Array, tangents: Array, tolerance: float, mark: str) -> Array:
    """Biarcs with the curve's own tangents, each as long as the tube allows."""
    out: list[Array] = []
    i, last = 0, len(points) - 1
    while i < last:
        reach, made = _farthest(lambda j, i=i: _fits(points, tangents, i, j, tolerance), i, last)
        if made is None:
            raise GeometryError(mark, "an edge turns too fast for arcs", "unfold it more densely")
        out.append(made)
        i = reach
    return np.concatenate(out)


def _farthest(
    fits: Callable[[int], Array | None], start: int, last: int, step: int = 1
) -> tuple[int, Array | None]:
    """Largest sample reached from `start` (galloping, then bisection), and what reaches it."""
    low, best, high = start, None, last + 1
    while low < last:
        to = min(low + step, last)
        made = fits(to)
        if made is None:
            high = to
            break
        best, low, step = made, to, 2 * step
    while high - low > 1:
        centre = (low + high) // 2
        made = fits(centre)
        if made is None:
            high = centre
        else:
            best, low = made, centre
    return low, best


def _shortest_chain(points: Array, tangents: Array, tolerance: float, best: Array) -> Array:
    """Chains of arcs with joints on the curve and free tangents, where they take fewer pieces.

    Where the curvature k changes evenly, arcs of length a that leave the curve's tangent by
    k' a^2 / 12 at every joint stay nearest to it: k' a^3 / 125 against k' a^3 / 40 of biarcs with
    the curve's tangents. One arc's end tangent fixes the next: only the first tangent is free. It
    is tried about the one that leaves the curve's tangent evenly at both ends of the first arc,
    from both ends of the curve.
    """
    for p, t, forward in ((points, tangents, True), (points[::-1], -tangents[::-1], False)):
        first = _even_tangent(p, t, tolerance)
        for share in TRIALS:
            tangent = _turned(t[0], share * first)
            chain = _chain(p, tangent, tolerance, len(best) - 1)
            if chain is not None:
                best = chain if forward else _reversed(chain, p[-1])
    return best


def _even_tangent(points: Array, tangents: Array, tolerance: float) -> float:
    """Angle off the curve's tangent that the longest first arc has at both of its ends."""
    off, last, step = 0.0, len(points) - 1, 1
    for _ in range(3):
        tangent = _turned(tangents[0], off)
        reach, _ = _farthest(
            lambda j, t=tangent: _arc_fits(points, 0, j, t, tolerance), 0, last, step
        )
        if reach == 0:
            break
        chord, step = points[reach] - points[0], max(1, reach // 2)
        leave = np.arctan2(_cross(tangents[0], chord), float(tangents[0] @ chord))
        arrive = np.arctan2(_cross(chord, tangents[reach]), float(chord @ tangents[reach]))
        off = float(leave - arrive) / 2.0
    return off


def _cross(a: Array, b: Array) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _chain(points: Array, tangent: Array, tolerance: float, most: int) -> Array | None:
    """Arcs from the first tangent on, each as long as the tube allows; None if over `most`."""
    out: list[Array] = []
    i, last, step = 0, len(points) - 1, 1
    while i < last:
        if len(out) == most:
            return None
        reach, made = _farthest(
            lambda j, i=i, t=tangent: _arc_fits(points, i, j, t, tolerance), i, last, step
        )
        if made is None:
            return None
        out.append(made)
        tangent = _turned(tangent, 4.0 * float(np.arctan(made[2])))
        step = max(1, 3 * (reach - i) // 4)
        i = reach
    return np.array(out)


def _arc_fits(points: Array, i: int, j: int, tangent: Array, tolerance: float) -> Array | None:
    """Vertex of the arc from sample i to j with the given tangent if it stays in the tube.

    With A of `arc_distance`, which grows with the distance d: A = 2 d + k d^2 at its limits.
    """
    (x, y), (x1, y1), (tx, ty) = points[i].tolist(), points[j].tolist(), tangent.tolist()
    dx, dy = x1 - x, y1 - y
    half = math.atan2(tx * dy - ty * dx, tx * dx + ty * dy)
    if abs(half) > math.pi / 2.0:
        return None
    k = 2.0 * math.sin(half) / math.hypot(dx, dy)
    if j > i + 1:
        wx, wy = points[i + 1 : j, 0] - x, points[i + 1 : j, 1] - y
        a = wx * (k * wx + 2.0 * ty)
        a += wy * (k * wy - 2.0 * tx)
        low, high = a.min(), a.max()
        if high > tolerance * (2.0 + k * tolerance) or low < tolerance * (k * tolerance - 2.0):
            return None
    return np.array([x, y, math.tan(half / 2.0)])


def _reversed(chain: Array, start: Array) -> Array:
    """The same arcs run the other way; `start` is the point where the chain ended."""
    points = np.concatenate([start[None], chain[::-1, :2]])[:-1]
    return np.column_stack([points, -chain[::-1, 2]])
