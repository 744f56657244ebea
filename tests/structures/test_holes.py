"""What holes take off plates: closed forms and the solids' own volumes."""

from __future__ import annotations

import numpy as np
import pytest
from cad_helpers import plate, square_hole
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepTools import BRepTools
from OCP.GeomAbs import GeomAbs_SurfaceType

from fabgeo.cad import kernel
from fabgeo.cad.assembly import Node
from fabgeo.cad.measure import check_solid
from fabgeo.cad.plates import plate_solid
from fabgeo.cad.readback import read_package_step
from fabgeo.cad.step import write_step
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.holes import bored_volume, section_sites
from fabgeo.structures.parts import Hole, Plate
from fabgeo.structures.prisms import plate_prism, prism_volume


@pytest.mark.parametrize("slot", [0.0, 12.0])
def test_section_has_the_area_and_moments_of_a_stadium(slot: float) -> None:
    hole = Hole(np.zeros(3), np.array([0.0, 0.0, 1.0]), 10.0, slot)
    sites, weights = section_sites(hole)
    assert weights.sum() == pytest.approx(np.pi * 25.0 + 10.0 * slot, rel=1e-13)
    assert weights @ sites == pytest.approx(np.zeros(2), abs=1e-9)
    across = 5.0**4 * np.pi / 4.0 + slot * 10.0**3 / 12.0
    assert weights @ sites[:, 1] ** 2 == pytest.approx(across, rel=1e-12)


@pytest.mark.parametrize("tilt", [0.0, 0.3])
@pytest.mark.parametrize("slot", [0.0, 12.0])
def test_flat_plate_loses_section_times_slant(tilt: float, slot: float) -> None:
    corners = np.array([[[0.0, 0, 0], [300, 0, 0]], [[0.0, 200, 0], [300, 200, 0]]])
    s = np.linspace(0.0, 1.0, 4)[:, None]
    poles = np.stack([a + s * (b - a) for a, b in corners])
    mid = RuledPatch(np.array([0.0] * 4 + [1.0] * 4), poles)
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    hole = Hole(np.array([150.0, 100.0, 0.0]), axis, 14.0, slot)
    made = Plate("P-00-00", "P-00-00", "panel", mid, 6.0, "steel", (hole,))
    section = np.pi * 49.0 + 14.0 * slot
    expected = section * 6.0 / np.cos(tilt)
    assert bored_volume(plate_prism(made), made.holes) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("slot", [0.0, 30.0])
def test_solid_with_holes_has_the_volume_of_the_formula(slot: float) -> None:
    mid = plate().mid
    holes = [square_hole(mid, u, v, 20.0, slot) for u, v in ((0.15, 0.2), (0.25, 0.5))]
    made = plate(holes=holes)
    prism = plate_prism(made)
    expected = prism_volume(prism) - bored_volume(prism, holes)
    report = check_solid(plate_solid(made), 1e-6)
    assert report.sound
    assert report.volume == pytest.approx(expected, rel=1e-9)


def test_seams_of_a_holes_cylinders_lie_in_the_void(tmp_path):
    """No rim begins on a seam, where a reader may take the start of its angles for their end."""
    mid = plate().mid
    made = plate(holes=[square_hole(mid, 0.2, 0.4, 20.0, 30.0)])
    written = write_step(tmp_path / "plate.step", Node("plate", plate_solid(made)))
    (part,) = read_package_step(written)
    assert part.report.sound
    cylinder = GeomAbs_SurfaceType.GeomAbs_Cylinder
    faces = kernel.faces(part.shape)
    rounds = [face for face in faces if BRepAdaptor_Surface(face).GetType() == cylinder]
    assert len(rounds) == 2
    for face in rounds:
        u0, u1, _, _ = BRepTools.UVBounds_s(face)
        assert (u0, u1) == pytest.approx((0.5 * np.pi, 1.5 * np.pi), abs=1e-6)
