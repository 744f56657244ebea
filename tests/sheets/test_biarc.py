"""Arcs within a tolerance: tangent continuous, never outside, fewer than a polyline's pieces."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from sheet_parts import CURVES, edge_of, wavy_part

from fabgeo.arrays import Array
from fabgeo.sheets.biarc import arc_distance, edge_arcs, part_contour
from fabgeo.sheets.contour import Contour

TOLERANCE = 0.05


def coarsest_polyline(points: Array, tolerance: float) -> int:
    """Fewest segments between points of the curve that stay within the tolerance of it."""
    start, count = 0, 0
    while start < len(points) - 1:
        low, high = start + 1, len(points) - 1
        while low < high:
            to = (low + high + 1) // 2
            chord = points[to] - points[start]
            off = points[start : to + 1] - points[start]
            gap = np.abs(chord[0] * off[:, 1] - chord[1] * off[:, 0]).max() / np.hypot(*chord)
            low, high = (to, high) if gap <= tolerance else (low, to - 1)
        start, count = low, count + 1
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
    assert 3 * len(vertices) <= max(3, coarsest_polyline(exact, TOLERANCE))
    assert turns(vertices, ends) == pytest.approx(0.0, abs=0.01)


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
