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


def test_the_two_sides_of_a_thin_fin_do_not_meet() -> None:
    # A fin 50 mm thick and 400 mm high on a roof of 60 m: its sides are near, but share no edge.
    roof = [
        plane([-3e4, 0.0, 0.0], [3e4, 0.0, 0.0], [0.0, 6e4, 0.0], "left"),
        plane([0.0, 0.0, 0.0], [0.0, 0.0, 400.0], [0.0, 6e4, 0.0], "side"),
        plane([0.0, 0.0, 400.0], [50.0, 0.0, 0.0], [0.0, 6e4, 0.0], "top"),
        plane([50.0, 0.0, 400.0], [0.0, 0.0, -400.0], [0.0, 6e4, 0.0], "other side"),
        plane([50.0, 0.0, 0.0], [3e4, 0.0, 0.0], [0.0, 6e4, 0.0], "right"),
    ]
    surface = NurbsSurface(roof, "fin")
    crease = sharpest(surface)
    assert crease is not None
    assert crease.degrees == pytest.approx(90.0, abs=1e-6)
    assert len(surface.loops) == 1


def test_an_edge_is_shared_however_finely_each_face_cuts_it() -> None:
    # A half disc trimmed by 1,000 short chords on a flat face, a cylinder's wall along its arc.
    t = np.linspace(0.0, np.pi, 1001)
    arc = np.stack([1e3 * np.cos(t), 1e3 * np.sin(t)], axis=1)
    poles = np.array([[[-2e3, -1e3, 0], [-2e3, 2e3, 0]], [[2e3, -1e3, 0], [2e3, 2e3, 0]]], float)
    disc = NurbsFace(
        poles,
        None,
        np.array([-2e3, -2e3, 2e3, 2e3]),
        np.array([-1e3, -1e3, 2e3, 2e3]),
        1,
        1,
        (arc,),
    )
    quarter = np.sqrt(0.5)
    ring = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0]]) * 1e3
    wall = np.stack([np.column_stack([ring, np.full(5, z)]) for z in (0.0, 3e3)], axis=1)
    weights = np.repeat([[1.0], [quarter], [1.0], [quarter], [1.0]], 2, axis=1)
    knots = np.array([0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0])
    surface = NurbsSurface([disc, NurbsFace(wall, weights, knots, KNOTS, 2, 1)], "apse", 0.5)
    crease = sharpest(surface)
    assert crease is not None
    assert crease.degrees == pytest.approx(90.0, abs=0.2)
    (loop,) = surface.loops  # the disc's diameter, two sides of the wall, its upper arc
    length = np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1).sum()
    assert length == pytest.approx(2e3 + 2 * 3e3 + np.pi * 1e3, rel=1e-3)
