"""Two plane faces that meet at a known angle, and faces that join smoothly."""

from __future__ import annotations

import numpy as np
import pytest

from fabgeo.surfaces.creases import sharpest
from fabgeo.surfaces.inspect import inspect
from fabgeo.surfaces.nurbs import NurbsFace, NurbsSurface

KNOTS = np.array([0.0, 0.0, 1.0, 1.0])


def plane(corner: list[float], u: list[float], v: list[float], name: str) -> NurbsFace:
    a, b, c = (np.array(x) for x in (corner, u, v))
    poles = np.array([[a, a + c], [a + b, a + b + c]])
    return NurbsFace(poles, None, KNOTS, KNOTS, 1, 1, name=name)


def hinge(degrees: float) -> NurbsSurface:
    """Two squares of 4 m along the y axis; the second rises by an angle."""
    rise = np.radians(degrees)
    first = plane([-4e3, 0.0, 0.0], [4e3, 0.0, 0.0], [0.0, 4e3, 0.0], "low")
    up = [4e3 * float(np.cos(rise)), 0.0, 4e3 * float(np.sin(rise))]
    return NurbsSurface([first, plane([0.0, 0.0, 0.0], up, [0.0, 4e3, 0.0], "high")], "hinge")


@pytest.mark.parametrize("degrees", [12.0, 60.0, 120.0])
def test_the_angle_and_the_place_are_found(degrees: float) -> None:
    crease = sharpest(hinge(degrees))
    assert crease is not None
    assert crease.degrees == pytest.approx(degrees, abs=1e-6)
    assert sorted(crease.faces) == [0, 1]
    assert crease.point[0] == pytest.approx(0.0, abs=1e-6)
    assert crease.point[2] == pytest.approx(0.0, abs=1e-6)


def test_faces_that_join_smoothly_have_none() -> None:
    assert sharpest(hinge(0.0)) is None


def test_inspection_tells_faces_and_creases() -> None:
    found = inspect(hinge(30.0))
    assert [face.name for face in found.faces] == ["low", "high"]
    assert [face.area_m2 for face in found.faces] == pytest.approx([16.0, 16.0])
    assert any("faces 0 and 1 meet at 30 degrees" in note for note in found.notes)
