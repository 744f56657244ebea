"""Prisms become valid solids of the right volume, or are refused with their name."""

from __future__ import annotations

import numpy as np
import pytest
from cad_helpers import (
    PROFILE,
    plate,
    quadrature_volume,
    revolution,
    revolution_volume,
    square_hole,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from fabgeo.cad import kernel
from fabgeo.cad.measure import check_solid
from fabgeo.cad.plates import drill, plate_solid
from fabgeo.cad.solids import PLANAR_TOLERANCE, prism_solid
from fabgeo.errors import PartError
from fabgeo.structures.parts import Hole, Prism


@pytest.mark.parametrize("order", [1, -1])
def test_cell_is_valid_closed_and_of_exact_volume(order):
    """Either handedness gives a solid oriented outwards; volume by Guldin's rule."""
    prism = revolution(spans=8)
    report = check_solid(prism_solid(Prism("C-01-02", prism.knots, prism.poles[::order])))
    assert report.sound
    assert report.tolerance <= 1e-7
    assert report.surfaces == {"bspline": 4, "plane": 2}
    # Cubics follow their circles to 1e-9: both volumes must agree so far.
    assert report.volume == pytest.approx(revolution_volume(), rel=1e-8)
    assert report.volume == pytest.approx(quadrature_volume(prism), rel=1e-10)


def test_centre_of_mass_lies_in_the_mirror_plane():
    centre = check_solid(prism_solid(revolution())).centre
    assert np.arctan2(centre[1], centre[0]) == pytest.approx(0.25, abs=1e-9)


def test_a_solid_in_its_place_has_its_centre_there():
    place = np.eye(4)
    place[:3, :3] = [[0.0, -0.6, 0.8], [1.0, 0.0, 0.0], [0.0, 0.8, 0.6]]
    place[:3, 3] = [1e4, -2e4, 3e3]
    solid = prism_solid(revolution())
    here, there = check_solid(solid), check_solid(solid.Moved(kernel.to_location(place)))
    assert there.sound
    assert there.volume == here.volume
    np.testing.assert_allclose(there.centre, place[:3, :3] @ here.centre + place[:3, 3], rtol=1e-12)


def test_beam_of_twelve_sides():
    """An I-section in one piece, volume by formula."""
    half = np.array([100, 100, 8, 8, 100, 100, -100, -100, -8, -8, -100, -100.0])
    level = np.array([0, 20, 20, 280, 280, 300, 300, 280, 280, 20, 20, 0.0])
    profile = (5000.0 + half, level)
    report = check_solid(prism_solid(revolution("B-01-1", profile, spans=12)))
    assert report.sound
    assert report.surfaces == {"bspline": 12, "plane": 2}
    assert report.volume == pytest.approx(revolution_volume(profile), rel=1e-8)


def test_neighbouring_cells_share_their_faces_to_the_last_digit():
    """The wall between two cells has the same corners, bit for bit."""
    first = kernel.faces(prism_solid(revolution(start=0.1, end=0.4)))
    second = kernel.faces(prism_solid(revolution(start=0.4, end=0.7)))
    ends = [
        {tuple(np.array([p.X(), p.Y(), p.Z()])) for p in (_point(v) for v in kernel.vertices(face))}
        for face in (first[5], second[4])
    ]
    assert len(ends[0]) == 4
    for corner in ends[0]:
        assert min(np.linalg.norm(np.subtract(corner, c)) for c in ends[1]) < 1e-9


def _point(vertex):
    from OCP.BRep import BRep_Tool

    return BRep_Tool.Pnt_s(vertex)


@pytest.mark.parametrize("off", [1e-5, 4e-4])
def test_end_nearly_plane_is_a_plane_whose_tolerance_tells(off):
    prism = revolution()
    poles = _twisted(prism, off)
    report = check_solid(prism_solid(Prism("C", prism.knots, poles)))
    assert report.sound
    assert report.surfaces["plane"] == 2
    assert off / 2 < report.tolerance < 1e-3


def test_end_off_plane_is_closed_by_a_bilinear_face():
    prism = revolution()
    moved = Prism("C", prism.knots, _twisted(prism, 0.1))
    report = check_solid(prism_solid(moved))
    assert report.sound
    assert report.surfaces == {"bspline": 5, "plane": 1}
    assert report.tolerance <= 1e-7
    assert report.volume == pytest.approx(quadrature_volume(moved), rel=1e-9)


def test_end_off_plane_of_a_polygon_is_refused_by_name():
    profile = (5000.0 + np.array([0, 100, 100, 50, 0.0]), np.array([0, 0, 100, 150, 100.0]))
    prism = revolution("B-07-1", profile)
    with pytest.raises(PartError, match=r"B-07-1.*off its plane"):
        prism_solid(Prism("B-07-1", prism.knots, _twisted(prism, 0.1)))


def _twisted(prism: Prism, off: float):
    """The last section's corners moved alternately out of their plane by `off`."""
    poles = np.array(prism.poles)
    tangent = np.array([-np.sin(0.4), np.cos(0.4), 0.0])
    sign = np.where(np.arange(len(poles)) % 2 == 0, 1.0, -1.0)
    poles[:, -1] += off * sign[:, None] * tangent
    return poles


@settings(max_examples=25, deadline=None)
@given(st.just(0.0) | st.floats(1e-3, 2.0))
def test_offset_beyond_the_radius_is_never_a_solid(fraction):
    """Inner edge at radius 1 - fraction: empty at 0, cusped at 1, folded beyond, else sound."""
    inner = 3000.0 * (1.0 - fraction)
    profile = (np.array([3000.0, 3000.0, inner, inner]), np.array([0.0, 500.0, 520.0, -20.0]))
    if fraction == 0.0 or fraction > 0.999:
        with pytest.raises(PartError, match="C-00-00"):
            prism_solid(revolution(profile=profile))
    else:
        report = check_solid(prism_solid(revolution(profile=profile)))
        assert report.sound
        assert report.volume == pytest.approx(
            quadrature_volume(revolution(profile=profile)), rel=1e-8
        )


@pytest.mark.parametrize(
    ("radii", "heights"),
    [
        ([3000.0, 3000.0, 3000.001, 3000.001], [0.0, 500.0, 500.0, 0.0]),  # too thin
        ([3000.0, 3000.001, 2900.0, 2900.0], [0.0, 0.0, 0.0, 500.0]),  # too short a side
    ],
)
def test_slivers_are_refused(radii, heights):
    with pytest.raises(PartError, match=r"C-00-00.*sliver"):
        prism_solid(revolution(profile=(np.array(radii), np.array(heights))))


def test_crossed_section_is_refused():
    r, z = PROFILE
    order = [0, 2, 1, 3]
    with pytest.raises(PartError, match="C-00-00"):
        prism_solid(revolution(profile=(r[order] + [0, 300, 0, 0], z[order])))


@pytest.mark.parametrize("slot", [0.0, 30.0])
def test_bored_plate(slot):
    """Holes square to the plate take off their section times the thickness."""
    mid = plate().mid
    holes = [
        square_hole(mid, u, v, 20.0, slot) for u, v in ((0.15, 0.2), (0.2501, 0.5), (0.35, 0.9))
    ]
    whole, bored = (check_solid(plate_solid(plate(holes=h))) for h in ((), holes))
    assert bored.sound
    assert bored.tolerance < 1e-5
    section = 3 * (np.pi * 100.0 + 20.0 * slot)
    # The wall bulges over the bent plate: second order in diameter / radius (4e-3).
    assert whole.volume - bored.volume == pytest.approx(8.0 * section, rel=1e-4)
    assert bored.surfaces["cylinder"] == 6


def test_boring_agrees_with_the_boolean_cut():
    mid = plate().mid
    holes = [square_hole(mid, 0.2, 0.3, 22.0, 15.0)]
    cut = check_solid(drill(plate_solid(plate(), holes=False), holes, 8.0, limit=1e-2))
    bored = check_solid(plate_solid(plate(holes=holes)))
    assert cut.volume == pytest.approx(bored.volume, rel=1e-6)


@pytest.mark.parametrize(
    ("hole", "message"),
    [
        (lambda mid: square_hole(mid, 0.1005, 0.5), "breaks out"),
        (lambda mid: square_hole(mid, 0.25, 0.004), "breaks out"),
        (
            lambda mid: Hole(mid.points(np.array([0.25]), np.array([0.5]))[0], [0, 0, 1.0], 20.0),
            "45",
        ),
    ],
)
def test_bad_holes_are_refused_by_name(hole, message):
    with pytest.raises(PartError, match=rf"P-00-00.*{message}"):
        plate_solid(plate(holes=[hole(plate().mid)]))


def test_touching_holes_are_refused():
    mid = plate().mid
    holes = [square_hole(mid, 0.25, v) for v in (0.5, 0.51)]
    with pytest.raises(PartError, match="touch"):
        plate_solid(plate(holes=holes))


def test_bytes_carry_a_solid_between_processes():
    solid = prism_solid(revolution())
    back = kernel.from_bytes(kernel.to_bytes(solid))
    assert check_solid(back).volume == pytest.approx(check_solid(solid).volume, rel=1e-14)


def test_planar_tolerance_keeps_below_the_written_limit():
    assert PLANAR_TOLERANCE * 1.01 < 1e-3
