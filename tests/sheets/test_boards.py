"""Planks: what a strip is cut from, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from fabgeo import spline
from fabgeo.panels.flat import FlatPart
from fabgeo.panels.unfold import unfold
from fabgeo.sheets.boards import congruence, plank
from fabgeo.strips.ruled import RuledPatch

R, SLANT = 4000.0, 0.3


def strip(low: float, high: float, turn: float) -> FlatPart:
    """A strip on a cone of slope `SLANT` (0: a cylinder) between two heights along the slant."""
    knots = spline.clamped_knots(0.0, 1.0, 64)
    u = spline.greville(knots)
    c, s = np.cos(turn), np.sin(turn)

    def ring(v: float) -> np.ndarray:
        r = R + s * v
        return np.stack([r * np.cos(0.5 * u), r * np.sin(0.5 * u), np.full_like(u, c * v)], axis=-1)

    return unfold(RuledPatch.through(knots, u, ring(low), ring(high)), "P", "larch", 24.0)


def test_strip_of_a_cylinder_is_its_own_plank() -> None:
    found = plank(strip(0.0, 200.0, 0.0))
    assert (found.length, found.width) == pytest.approx((0.5 * R, 200.0), abs=1e-4)
    assert found.sag == pytest.approx(0.0, abs=1e-5)
    assert found.yield_ == pytest.approx(1.0, abs=1e-6)


def test_strip_of_a_cone_bends_by_its_ring_sector() -> None:
    found = plank(strip(0.0, 200.0, SLANT))
    # The development is a sector of the circle of the slant radius, turned by 0.5 sin(slope).
    radius, turn = R / np.sin(SLANT) + 100.0, 0.5 * np.sin(SLANT)
    assert found.sag == pytest.approx(radius * (1.0 - np.cos(turn / 2.0)), rel=1e-4)


def test_neighbours_on_one_cone_fit_edge_to_edge_and_on_two_do_not() -> None:
    lower, upper = strip(0.0, 200.0, SLANT), strip(200.0, 400.0, SLANT)
    second = next(e for e in lower.outline if e.name == "second")
    first = next(e for e in upper.outline if e.name == "first")
    assert congruence(second, first) < 1e-3
    other = next(e for e in strip(0.0, 200.0, 0.0).outline if e.name == "first")
    assert congruence(second, other) > 10.0
