"""Arcs within a tolerance: tangent continuous, never outside, fewer than a polyline's pieces."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from sheet_parts import CURVES, edge_of, stack, wavy_part

from fabgeo.arrays import Array
from fabgeo.sheets.biarc import arc_distance, dense, edge_arcs, part_contour
from fabgeo.sheets.contour import Contour

TOLERANCE = 0.05


def coarsest_polyline(points: Array, tolerance: float, offsets: int = 9) -> int:
    """Fewest segments from end to end whose inner vertices lie anywhere in the tube.

    Breadth first over vertices at `offsets` distances beside every point: a segment is sound while
    its slope stays within what the tube's walls leave open.
    """
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    beside = np.linspace(-tolerance, tolerance, offsets)
    nodes = points[:, None] + beside[None, :, None] * normal[:, None]
    reached, done = np.zeros((2, len(points), offsets), dtype=bool)
    reached[0, offsets // 2] = True
    count = 0
    while not reached[-1, offsets // 2]:
        count += 1
        fresh = np.zeros_like(reached)
        for i, m in np.argwhere(reached & ~done):
            w = nodes[i + 1 :] - nodes[i, m]
            slopes = (w @ normal[i]) / (w @ along[i])
            most = np.minimum.accumulate(slopes[:, -1])
            least = np.maximum.accumulate(slopes[:, 0])
            shut = np.flatnonzero(least > most)
            k = int(shut[0]) if len(shut) else len(most)
            before = np.append(np.inf, most)[:k, None], np.append(-np.inf, least)[:k, None]
            seen = (slopes[:k] <= before[0]) & (slopes[:k] >= before[1])
            fresh[i + 1 : i + 1 + k] |= seen
        done |= reached
        reached |= fresh
    return count


@pytest.mark.parametrize("name", CURVES)
def test_arcs_stay_in_the_tube_and_are_few(name: str) -> None:
    curve, speed = CURVES[name]
    edge = edge_of(curve, speed)
    vertices = edge_arcs(edge, TOLERANCE)
    exact = curve(np.linspace(0.0, 1.0, 20001))
    ends = np.append(vertices[1:], [[*edge.points[-1], 0.0]], axis=0)
    path = open_points(vertices, ends)
    # Both ways: no point of the curve is far from the arcs, no point of the arcs from the curve.
    assert (
        shapely.hausdorff_distance(shapely.LineString(exact), shapely.LineString(path))
        <= TOLERANCE + 2e-4
    )
    assert 3 * len(vertices) <= coarsest_polyline(curve(np.linspace(0.0, 1.0, 801)), TOLERANCE)
    assert turns(vertices, ends) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("seed", range(6))
def test_random_curves_are_never_left(seed: int) -> None:
    random = np.random.default_rng(seed)
    length, degree = 10.0 ** random.uniform(1.5, 4.0), int(random.integers(2, 7))
    rise = random.normal(size=degree + 1) * length * 10.0 ** random.uniform(-3.0, -0.7)
    rise /= np.arange(1, degree + 2)
    slope = np.polynomial.chebyshev.chebder(rise)

    def curve(t: Array) -> Array:
        return stack(length * t, np.polynomial.chebyshev.chebval(2 * t - 1, rise))

    def speed(t: Array) -> Array:
        return stack(length, 2 * np.polynomial.chebyshev.chebval(2 * t - 1, slope))

    edge = edge_of(curve, speed, 65)
    vertices = edge_arcs(edge, TOLERANCE)
    ends = np.append(vertices[1:], [[*edge.points[-1], 0.0]], axis=0)
    path, exact = open_points(vertices, ends), dense(edge, 200)[0]
    away = shapely.hausdorff_distance(shapely.LineString(exact), shapely.LineString(path))
    assert away <= TOLERANCE + 2e-4
    assert turns(vertices, ends) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("tolerance", [0.5, 0.05, 0.005])
def test_no_arc_more_than_evenly_growing_curvature_asks_for(tolerance: float) -> None:
    # y = c x^3 is nearly a clothoid, k' = 6 c: arcs of length h leave k' h^3 / (72 sqrt 3).
    length, c = 2000.0, 100.0 / 2000.0**3
    edge = edge_of(
        lambda t: stack(length * t, c * (length * t) ** 3),
        lambda t: stack(length, 3 * c * length * (length * t) ** 2),
    )
    reach = (72.0 * np.sqrt(3.0) * tolerance / (6.0 * c)) ** (1 / 3)
    assert len(edge_arcs(edge, tolerance)) <= np.ceil(1.03 * length / reach)


def open_points(vertices: Array, ends: Array) -> Array:
    """Dense points of arcs that don't close."""
    closed = Contour(np.append(vertices, [[*ends[-1, :2], 0.0]], axis=0))
    points = closed.points(1e-4)
    return np.append(points, [ends[-1, :2]], axis=0)


def turns(vertices: Array, ends: Array) -> float:
    """Largest kink in degrees between neighbouring pieces."""
    chord = ends[:, :2] - vertices[:, :2]
    direction = np.arctan2(chord[:, 1], chord[:, 0])
    half = 2.0 * np.arctan(vertices[:, 2])
    kink = (direction - half)[1:] - (direction + half)[:-1]
    return float(np.degrees(np.abs(np.remainder(kink + np.pi, 2 * np.pi) - np.pi).max(initial=0.0)))


def test_circles_and_lines_are_one_piece() -> None:
    assert len(edge_arcs(edge_of(*CURVES["circle"]), 1e-3)) == 1
    bulge = edge_arcs(edge_of(*CURVES["circle"]), 1e-3)[0, 2]
    assert 4.0 * np.arctan(bulge) == pytest.approx(1.0, rel=1e-5)


def test_corners_stay_where_they_are_to_the_bit() -> None:
    part = wavy_part()
    vertices = part_contour(part).vertices[:, :2].tolist()
    for edge in part.outline:
        assert edge.points[0].tolist() in vertices
    assert part_contour(part, 0.001).area == pytest.approx(
        part.area + np.pi * (18.0**2 + 14.0**2) / 4 + 280.0, rel=1e-6
    )


def test_distance_from_circles_is_stable_when_they_are_flat() -> None:
    start, tangent = np.zeros(2), np.array([1.0, 0.0])
    points = np.array([[3.0, 4.0], [0.0, 2.0], [5.0, -1.0]])
    for curvature in (0.5, 1e-3):
        centre = np.array([0.0, 1.0 / curvature])
        expected = np.linalg.norm(points - centre, axis=-1) - 1.0 / curvature
        assert arc_distance(start, tangent, curvature, points) == pytest.approx(expected)
    assert arc_distance(start, tangent, 0.0, points) == pytest.approx(-points[:, 1])
