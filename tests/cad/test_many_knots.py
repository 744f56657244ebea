"""Plates whose bending changes from knot to knot: holes across knots, edges as they are sampled."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from fabgeo.cad.measure import is_valid
from fabgeo.cad.plates import plate_solid
from fabgeo.cad.readback import ReadPart
from fabgeo.review.rails import ruling_radii
from fabgeo.review.solid_plate import SolidPlate, solid_plate
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Hole, Plate

SPANS, LENGTH, WIDTH = 40, 1600.0, 300.0
KNOTS = np.concatenate([[0.0] * 3, np.linspace(0.0, LENGTH, SPANS + 1), [LENGTH] * 3])


def bent() -> RuledPatch:
    """A cylinder over z(x), a cubic spline that bends between 1 / 2 m and 1 / 8 m."""
    rng = np.random.default_rng(7)
    curvature = rng.uniform(1.0 / 8000.0, 1.0 / 2000.0, SPANS + 1)
    knots = np.linspace(0.0, LENGTH, SPANS + 1)
    slope = np.append(0.0, np.cumsum((curvature[1:] + curvature[:-1]) / 2.0 * np.diff(knots)))
    slope -= slope.mean()
    steps = np.diff(knots)
    rise = slope[:-1] * steps + curvature[:-1] * steps**2 / 3.0 + curvature[1:] * steps**2 / 6.0
    ends: Any = ((2, curvature[0]), (2, curvature[-1]))  # scipy tells the type by the default
    z = CubicSpline(knots, np.append(0.0, np.cumsum(rise)), bc_type=ends)
    sites = np.array([KNOTS[k + 1 : k + 4].mean() for k in range(SPANS + 3)])
    first = np.column_stack([sites, np.zeros(len(sites)), z(sites)])
    return RuledPatch.through(KNOTS, sites, first, first + np.array([0.0, WIDTH, 0.0]))


def drilled(at: float) -> Plate:
    """A plate with 40 round holes from `at` on, knots through many of them."""
    mid, holes = bent(), []
    for k, x in enumerate(np.linspace(30.0, LENGTH - 60.0, 40) + at):
        (a, _), (d, _) = (mid.edges(np.array([x]), order)[:, 0] for order in (0, 1))
        along = d / np.linalg.norm(d)
        axis = np.array([-along[2], 0.0, along[0]])
        centre = a + np.array([0.0, 30.0 + 7.3 * k % 240.0, 0.0])
        holes.append(Hole(centre, axis, 11.0, 0.0, along))
    return Plate("P-00-00", "P-00-00", "panel", mid, 4.0, "aluminium", tuple(holes))


@pytest.mark.parametrize("at", [2.0, 10.0, 14.0, 16.0])
def test_rims_that_knots_of_the_skin_run_through_are_valid(at: float) -> None:
    assert is_valid(plate_solid(drilled(at)))


def test_two_samples_to_a_knot_span_give_the_radius_everywhere() -> None:
    """One to a span leaves the ends to be guessed."""
    mid = bent()

    def worst(count: int) -> float:
        x = np.linspace(0.0, LENGTH, count)
        first, second = mid.edges(x)
        speed, change = mid.edges(x, 1)[0], mid.edges(x, 2)[0]
        bent = np.abs(speed[:, 0] * change[:, 2] - speed[:, 2] * change[:, 0])
        exact = np.linalg.norm(speed, axis=1) ** 3 / bent
        return float(np.abs(ruling_radii((first, second)) / exact - 1.0).max())

    assert worst(2 * SPANS + 1) < 1e-6
    assert worst(SPANS + 1) > 0.05


def test_outlines_are_sampled_twice_a_knot_span() -> None:
    """Skins have two spans to one of the mid-surface."""
    plate = measured(plate_solid(drilled(0.0), holes=False))
    assert {len(edge) for edge in plate.edges} == {4 * SPANS + 1}


def test_rims_of_holes_run_round_on_their_cylinders() -> None:
    plate, solid = drilled(0.0), measured(plate_solid(drilled(0.0)))
    assert len(solid.openings) == len(plate.holes)
    for hole in plate.holes:
        middles = [rim.mean(axis=0) - hole.centre for rim in solid.openings]
        rim = solid.openings[int(np.linalg.norm(middles, axis=1).argmin())] - hole.centre
        x, y = rim @ hole.direction, rim @ np.cross(hole.axis, hole.direction)
        np.testing.assert_allclose(np.hypot(x, y), 5.5, atol=1e-3)
        assert np.diff(np.sort(np.arctan2(y, x))).max() < 0.3


def measured(solid: Any) -> SolidPlate:
    part = ReadPart("P", "P", ("P",), solid, None, (), (np.eye(4),))
    plate = solid_plate(part, 0.0, np.zeros(3))
    assert plate is not None
    return plate
