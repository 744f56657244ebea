"""Curves of a drawing as the check reads them: areas of arcs in closed form."""

from __future__ import annotations

from math import pi, tan

import numpy as np
import pytest

from fabgeo.review.dxf_text import Curve
from fabgeo.review.solid_plate import shape_area


def test_a_circle_of_arcs_has_a_circles_area() -> None:
    """Any number of arcs, running either way."""
    for count, sense in ((2, 1.0), (3, -1.0), (400, 1.0)):
        turn = sense * 2.0 * pi * np.arange(count) / count
        bulge = np.full(count, sense * tan(pi / 2.0 / count))
        rows = np.column_stack([7.0 + 30.0 * np.cos(turn), 30.0 * np.sin(turn), bulge])
        assert Curve("", rows, closed=True).area == pytest.approx(pi * 900.0, rel=1e-12)


def part(rise: float) -> Curve:
    """A part of 1,000 x 80 mm, one of its long edges an arc that rises outwards."""
    rows = [[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0], [1000.0, 80.0, rise / 500.0], [0.0, 80.0, 0.0]]
    return Curve("", np.array(rows), closed=True)


@pytest.mark.parametrize("rise", [60.0, 3.0, -0.3])
def test_chords_leave_out_no_more_than_their_sagitta(rise: float) -> None:
    """Of every segment two thirds of its chord times its height."""
    curve = part(rise)
    for sagitta in (1e-2, 1e-3, 1e-4):
        left_out = (curve.area - shape_area(curve.points(sagitta))) * np.sign(rise)
        assert 0.0 < left_out < 2.0 / 3.0 * sagitta * 1020.0


@pytest.mark.parametrize("rise", [0.3, -1e-3, 1e-6])
def test_a_flat_arc_has_a_parabolas_area(rise: float) -> None:
    assert part(rise).area - 80_000.0 == pytest.approx(rise * 2000.0 / 3.0, rel=2e-5)
