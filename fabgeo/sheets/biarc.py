"""Arcs and lines within a tolerance: tangent continuous, as few as possible.

Glossary
--------
tube
    All points within the tolerance of the curve. No arc leaves it: checked at dense samples.

An edge that one line or one arc follows within the tolerance becomes that one piece; otherwise the
fewest arcs of `fabgeo.sheets.arc_chain`: biarcs whose joints and directions are free.
"""

from __future__ import annotations

import numpy as np
import shapely

from fabgeo.arrays import Array, unit
from fabgeo.panels.flat import FlatEdge, FlatPart
from fabgeo.sheets.arc_chain import Index, fewest_arcs
from fabgeo.sheets.contour import Contour

SAMPLES = 6  # dense samples between two points of a flat edge
FINER = 4  # times as many where the arcs are checked
PER_ARC = 16  # samples that an arc spans in the mean: else more are taken
MOST = 6 * 4**3  # samples between two points of a flat edge
BETWEEN = 0.985  # of the tolerance is used at the samples; what lies between may go on to it


def part_contour(part: FlatPart, tolerance: float = 0.05) -> Contour:
    """Outer contour of a part: lines and arcs within `tolerance` mm, corners kept to the bit.

    A contour that the part brings along, as fine or finer, is taken as it is.
    """
    if part.contour is not None and part.contour_tolerance <= tolerance:
        return Contour(part.contour)
    pieces = [edge_arcs(edge, tolerance) for edge in part.outline]
    return Contour(np.concatenate(pieces))


def edge_arcs(edge: FlatEdge, tolerance: float = 0.05) -> Array:
    """Vertices (n, 3) x, y, bulge of one edge, its last point left out.

    An edge that turns too fast between its own points for any chain of arcs is followed by lines.
    """
    if len(edge.points) == 2:
        return np.array([[*edge.points[0], 0.0]])
    points, tangents = dense(edge)
    single = _single(points, BETWEEN * tolerance)
    if single is not None:
        return np.array([[*points[0], single]])
    samples, share = SAMPLES, BETWEEN
    while samples <= MOST:
        found = fewest_arcs(points, tangents, share * tolerance)
        if found is not None:
            vertices, joints = found
            fine = samples >= MOST or len(points) >= PER_ARC * len(vertices)
            if fine and _gap(edge, samples, vertices, joints) <= tolerance:
                return vertices
            share = BETWEEN**2 if fine else share
        samples *= FINER
        points, tangents = dense(edge, samples)
    return _lines(points, BETWEEN * tolerance)


def _lines(points: Array, tolerance: float) -> Array:
    """Vertices (n, 3) of the polyline of few of the points that is within the tolerance of all."""
    kept = shapely.get_coordinates(shapely.LineString(points).simplify(tolerance))[:-1]
    return np.column_stack([kept, np.zeros(len(kept))])


def _gap(edge: FlatEdge, samples: int, vertices: Array, joints: Index) -> float:
    """Largest distance of the edge from its arcs, between the samples they were made for."""
    points, _ = dense(edge, FINER * samples)
    at = np.arange(len(points))
    own = np.clip(np.searchsorted(FINER * joints, at, side="right") - 1, 0, len(vertices) - 1)
    start, end = points[FINER * joints[:-1]], points[FINER * joints[1:]]
    half = 2.0 * np.arctan(vertices[:, 2])
    chord = end - start
    size = np.hypot(chord[:, 0], chord[:, 1])
    c, s = np.cos(half), np.sin(half)
    u, v = chord[:, 0] / size, chord[:, 1] / size
    tangents = np.stack([c * u + s * v, c * v - s * u], axis=-1)
    curvature = 2.0 * s / size
    gap = arc_distance(start[own], tangents[own], curvature[own], points)
    return float(np.abs(gap).max())


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
