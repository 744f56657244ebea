"""Contours of lines and arcs against closed forms of circles, slots and moved shapes."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from fabgeo.panels.flat import FlatHole
from fabgeo.sheets.contour import Contour, hole_contour


def test_circle_and_slot_have_their_closed_forms() -> None:
    circle = hole_contour(FlatHole(np.array([10.0, 20.0]), 18.0))
    assert circle.area == pytest.approx(np.pi * 81.0, rel=1e-14)
    assert circle.length == pytest.approx(np.pi * 18.0, rel=1e-14)
    assert circle.bounds() == pytest.approx((1.0, 11.0, 19.0, 29.0))
    slot = hole_contour(FlatHole(np.array([0.0, 0.0]), 14.0, 20.0, 0.7))
    assert slot.area == pytest.approx(np.pi * 49.0 + 280.0, rel=1e-14)
    assert slot.length == pytest.approx(np.pi * 14.0 + 40.0, rel=1e-14)
    x = 10.0 * np.cos(0.7) + 7.0
    assert slot.bounds() == pytest.approx((-x, -10 * np.sin(0.7) - 7, x, 10 * np.sin(0.7) + 7))


@pytest.mark.parametrize("bulge", [0.02, 0.4, -0.3])
def test_polygons_keep_to_their_side_of_the_arcs(bulge: float) -> None:
    shape = Contour(np.array([[0, 0, bulge], [1000, 0, 0], [1000, 600, 0], [0, 600, 0.0]]))
    fine = shapely.Polygon(shape.points(1e-5))
    outside = shapely.Polygon(shape.points(0.5, outside=True))
    assert shapely.contains(outside.buffer(1e-4), fine)
    assert shapely.hausdorff_distance(outside, fine) < 0.52
    assert fine.area == pytest.approx(shape.area, rel=1e-7)
    assert fine.length == pytest.approx(shape.length, rel=1e-6)


def test_moving_keeps_area_length_and_distances() -> None:
    shape = Contour(np.array([[0, 0, 0.2], [1000, 0, 0], [1000, 600, -0.1], [0, 600, 0.0]]))
    moved = shape.moved(120.0, -30.0, 1.1)
    assert moved.area == pytest.approx(shape.area, rel=1e-12)
    assert moved.length == pytest.approx(shape.length, rel=1e-12)
    back = moved.moved(0.0, 0.0, -1.1)
    shift = back.vertices[:, :2] - shape.vertices[:, :2]
    assert np.ptp(shift, axis=0) == pytest.approx([0.0, 0.0], abs=1e-9)
