"""Parameter curves that a file leaves to its reader: they lie where their edges do."""

from __future__ import annotations

import re
from dataclasses import replace

import build123d as b3d
import numpy as np
import pytest
from cad_helpers import plate, revolution, square_hole
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopoDS import TopoDS

from fabgeo.cad import kernel, measure, readback
from fabgeo.cad.assembly import Node
from fabgeo.cad.laid import lay
from fabgeo.cad.plates import plate_solid
from fabgeo.cad.readback import read_package_step
from fabgeo.cad.solids import prism_solid
from fabgeo.cad.step import write_step


@pytest.fixture
def drilled():
    mid = plate(spans=6).mid
    holes = [square_hole(mid, u, v, 11.0, s) for u, v, s in ((0.15, 0.2, 20.0), (0.25, 0.5, 0.0))]
    return plate_solid(plate(holes=holes, spans=6))


def bare(path):
    """The parts of a file without what its reader has to find."""
    return readback._read(path, (*readback._REPAIRS, "FixSolidMode"))


def test_curves_in_the_parameter_plane_are_the_edges_in_space(drilled, tmp_path):
    (part,) = bare(write_step(tmp_path / "plate.step", Node("plate", drilled)))
    assert not measure.is_valid(part.shape)
    assert lay(part.shape)
    assert measure.is_valid(part.shape)
    assert measure.max_tolerance(part.shape) == pytest.approx(1e-7)
    count, worst = 0, 0.0
    for face in kernel.faces(part.shape):
        surface = BRepAdaptor_Surface(face)
        if measure.surface_kind(surface) == "plane":
            continue
        for shape in kernel.explore(face, TopAbs_ShapeEnum.TopAbs_EDGE):
            edge = TopoDS.Edge_s(shape)
            first, last = BRep_Tool.Range_s(edge)
            curve = BRep_Tool.Curve_s(edge, 0.0, 0.0)
            flat = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0)
            for t in np.linspace(first, last, 41).tolist():  # at other places than it was made for
                uv = flat.Value(t)
                worst = max(worst, surface.Value(uv.X(), uv.Y()).Distance(curve.Value(t)))
            count += 1
    assert count == 4 * 4 + 2 * (4 + 2) + 4 * 4  # sides and outlines, rims on skins, half cylinders
    assert worst < 1e-7


def test_a_solid_measures_the_same_by_the_kernels_own_curves(drilled, tmp_path):
    path = write_step(tmp_path / "plate.step", Node("plate", drilled))
    (laid,) = read_package_step(path)
    (own,) = readback._read(path, readback._REPAIRS)
    assert laid.report.sound
    assert own.report.sound
    # The kernel's curves on half cylinders are cubics through 23 points.
    assert laid.report.volume == pytest.approx(own.report.volume, rel=1e-8)
    assert laid.report.volume == pytest.approx(measure.volume(drilled)[0], rel=1e-11)


def test_an_edge_off_its_face_is_not_laid_and_not_called_valid(drilled, tmp_path):
    path = write_step(tmp_path / "plate.step", Node("plate", drilled))
    text = path.read_text()
    # A pole of the first rim, of degree 11, is moved by 0.5 mm.
    rim = re.search(r"B_SPLINE_CURVE_WITH_KNOTS\('',11,\(#\d+,#\d+,#\d+,#(\d+)", text)
    point = re.search(rf"#{rim[1]} = CARTESIAN_POINT\('',\(([^,]+),", text)
    moved = point[0].replace(point[1], f"{float(point[1]) + 0.5!r}")
    path.write_text(text.replace(point[0], moved))
    assert not lay(bare(path)[0].shape)


def test_faces_all_around_are_left_to_the_kernel(tmp_path):
    pipe = b3d.Cylinder(10.0, 30.0) - b3d.Cylinder(8.0, 30.0)
    path = write_step(tmp_path / "pipe.step", Node("pipe", pipe.solid().wrapped))
    assert not lay(bare(path)[0].shape)
    (part,) = read_package_step(path)
    assert part.report.sound
    assert part.report.volume == pytest.approx(np.pi * 36.0 * 30.0, rel=1e-12)


@pytest.mark.parametrize(("off", "laid"), [(4e-4, True), (2e-2, False)])
def test_edges_off_a_plane_state_how_far(tmp_path, off, laid):
    straight = revolution()
    poles = straight.poles.copy()
    end = poles[1, -1] - poles[1, -2]
    poles[1, -1] += off * end / np.linalg.norm(end)
    solid = prism_solid(replace(straight, poles=poles), planar_tolerance=1.0)
    (part,) = bare(write_step(tmp_path / "prism.step", Node("prism", solid)))
    assert lay(part.shape) is laid
    if laid:
        assert measure.is_valid(part.shape)
        # Two corners share what one is off; both solids state a hundredth more than the distance.
        assert off / 5 < measure.max_tolerance(part.shape) < off
        assert measure.max_tolerance(part.shape) <= 1.01 * measure.max_tolerance(solid)
