"""Every kind of surface file through the one interface, its unit, and what is refused."""

import json

import numpy as np
import pytest

from fabgeo.cad.read_surface import read_surface
from fabgeo.errors import InputError
from fabgeo.surfaces.base import DesignSurface, size_of
from fabgeo.surfaces.inspect import inspect
from fabgeo.surfaces.quadgrid import GridSurface

PLATE = "v 0 0 0\nv 4 0 0\nv 4 3 0.2\nv 0 3 0\nf 1 2 3 4\n"


def test_canopy(fixtures):
    surface = read_surface(fixtures / "canopy" / "canopy.step")
    assert isinstance(surface, DesignSurface)
    assert surface.unit.name == "mm"
    low, high = surface.bounds
    assert (high - low)[:2] == pytest.approx([18000.0, 9162.0], abs=1.0)
    found = inspect(surface)
    # As promised in fixtures/README.md: distinct principal curvatures from 1/60 to 1/12 per metre.
    assert found.synclastic_share == 1.0
    assert found.umbilic_share == 0.0
    for low, high in (found.curvature_larger_per_mm, found.curvature_smaller_per_mm):
        assert 1 / 60e3 < min(-low, -high) <= max(-low, -high) < 1 / 12e3
    assert max(found.curvature_larger_per_mm) < min(found.curvature_smaller_per_mm) - 1 / 60e3
    json.dumps(found.as_dict())


def test_canopy_is_what_its_script_makes(fixtures):
    """Two routes: the rise in closed form at the grid points, and the STEP face read back."""
    import sys

    sys.path.insert(0, str(fixtures / "canopy"))
    try:
        import make
    finally:
        sys.path.pop(0)
    grid = make.grid().reshape(-1, 3)
    surface = read_surface(fixtures / "canopy" / "canopy.step")
    assert np.abs(surface.closest(grid).point - grid).max() < 1e-6


def write_step(path, shape, unit):
    from OCP.Interface import Interface_Static
    from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer

    writer = STEPControl_Writer()
    Interface_Static.SetCVal_s("write.step.unit", unit)
    writer.Transfer(shape, STEPControl_AsIs)
    writer.Write(str(path))
    Interface_Static.SetCVal_s("write.step.unit", "MM")


@pytest.mark.parametrize(("unit", "word"), [("MM", "mm"), ("M", "m"), ("INCH", "in")])
def test_step_states_its_unit(tmp_path, unit, word):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder

    path = tmp_path / "drum.step"
    write_step(path, BRepPrimAPI_MakeCylinder(1000.0, 3000.0).Shape(), unit)
    surface = read_surface(path)
    assert surface.unit.name == word
    assert surface.unit.reason == "stated in the file"
    assert surface.loops == ()
    assert surface.bounds == pytest.approx(np.array([[-1e3, -1e3, 0], [1e3, 1e3, 3e3]]), abs=1e-3)
    assert surface.area == pytest.approx(2 * np.pi * 1e6 * 4, rel=5e-3)
    with pytest.raises(InputError, match=f"said to be in ft, but the file itself says {word}"):
        read_surface(path, unit="ft")
    wall = read_surface(path, faces=[0])
    assert len(wall.charts) == 1
    assert wall.sample(50).principal()[0][:, 0] == pytest.approx(-1e-3)
    assert len(wall.loops) == 2
    with pytest.raises(InputError, match="has no face 7; it holds 3"):
        read_surface(path, faces=[7])


def test_iges(tmp_path):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere
    from OCP.IGESControl import IGESControl_Writer

    writer = IGESControl_Writer("MM", 1)
    writer.AddShape(BRepPrimAPI_MakeSphere(2000.0).Shape())
    writer.Write(str(tmp_path / "ball.igs"))
    surface = read_surface(tmp_path / "ball.igs")
    assert np.linalg.norm(surface.sample(500).point, axis=1) == pytest.approx(2000.0)
    assert surface.loops == ()


def test_trimmed_step_face_keeps_its_hole(tmp_path):
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    box = BRepPrimAPI_MakeBox(4000.0, 4000.0, 100.0).Shape()
    drill = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(2000, 2000, -1), gp_Dir(0, 0, 1)), 700.0, 200.0)
    write_step(tmp_path / "plate.step", BRepAlgoAPI_Cut(box, drill.Shape()).Shape(), "MM")
    surface = read_surface(tmp_path / "plate.step")
    assert surface.loops == ()
    at = surface.closest(np.array([[2100.0, 2000.0, 50.0], [1000.0, 2000.0, 150.0]]))
    assert at.point == pytest.approx(np.array([[2700.0, 2000, 50], [1000, 2000, 100]]), abs=0.1)
    assert not at.on_boundary.any()


@pytest.mark.parametrize(
    "content", ["", "ISO-10303-21;\nnonsense", "ISO-10303-21;\nHEADER;\nENDSEC;\n"]
)
def test_unreadable_step(tmp_path, content):
    (tmp_path / "bad.step").write_text(content)
    with pytest.raises(InputError, match=r"bad\.step"):
        read_surface(tmp_path / "bad.step")


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        (r"CARTESIAN_POINT\('',\(1\.E\+03", "CARTESIAN_POINT('',('x'", "CartesianPoint, entity"),
        (r"PLANE\('',#\d+\)", "PLANE('',#1)", "Plane, entity"),  # else a drum without its lid
        (r"EDGE_LOOP\('',\(#\d+", "EDGE_LOOP('',(#1", ""),  # kills the kernel
        (r"CIRCLE\('',#\d+", "CIRCLE('',#1", "Circle, entity"),  # else a lid without its border
    ],
)
def test_geometry_lost_on_the_way_is_refused(tmp_path, old, new, what):
    """The kernel puts zeros for what is no number and leaves out faces and trims, silently."""
    import re

    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder

    path = tmp_path / "drum.step"
    write_step(path, BRepPrimAPI_MakeCylinder(1000.0, 3000.0).Shape(), "MM")
    text, count = re.subn(old, new, path.read_text(), count=1)
    assert count == 1
    path.write_text(text)
    words = f"holds damaged STEP geometry: {what}" if what else "(is|holds) damaged"
    with pytest.raises(InputError, match=rf"drum\.step: {words}"):
        read_surface(path)


def test_step_without_faces(tmp_path):
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    from OCP.gp import gp_Pnt

    edge = BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(1000, 0, 0)).Edge()
    write_step(tmp_path / "wire.step", edge, "MM")
    with pytest.raises(InputError, match="holds no face"):
        read_surface(tmp_path / "wire.step")


def rhino_file(path, add, unit="Meters"):
    rhino3dm = pytest.importorskip("rhino3dm")
    model = rhino3dm.File3dm()
    model.Settings.ModelUnitSystem = getattr(rhino3dm.UnitSystem, unit)
    add(model, rhino3dm)
    model.Write(str(path), 7)
    return path


def test_rhino_sphere_and_trimmed_disc(tmp_path):
    def ball(model, r):
        model.Objects.AddBrep(r.Brep.CreateFromSphere(r.Sphere(r.Point3d(0, 0, 0), 3.0)))

    def disc(model, r):
        circle = r.Circle(r.Point3d(0, 0, 0), 3.0).ToNurbsCurve()
        model.Objects.AddBrep(r.Brep.CreateTrimmedPlane(r.Plane.WorldXY(), circle))

    sphere = read_surface(rhino_file(tmp_path / "ball.3dm", ball))
    assert sphere.unit.name == "m"
    assert np.linalg.norm(sphere.sample(300).point, axis=1) == pytest.approx(3000.0)
    flat = read_surface(rhino_file(tmp_path / "disc.3dm", disc))
    assert len(flat.loops) == 1
    assert np.linalg.norm(flat.loops[0], axis=1) == pytest.approx(3000.0, abs=0.1)


def test_rhino_without_surfaces(tmp_path):
    path = rhino_file(tmp_path / "dot.3dm", lambda m, r: m.Objects.AddPoint(1.0, 2.0, 3.0))
    with pytest.raises(InputError, match="neither a surface nor a mesh"):
        read_surface(path)


def test_dxf_sections(tmp_path):
    import ezdxf

    document = ezdxf.new(units=6)
    for z in (0.0, 4.0, 8.0):
        document.modelspace().add_circle((0, 0, z), 10.0 + 0.1 * z, dxfattribs={"layer": "SLAB"})
    document.modelspace().add_lwpolyline([(0, 0), (50, 0)], dxfattribs={"layer": "AXIS"})
    document.saveas(tmp_path / "slabs.dxf")
    surface = read_surface(tmp_path / "slabs.dxf", layer="SLAB")
    assert surface.unit.name == "m"
    at = surface.sample(200).point
    assert np.hypot(at[:, 0], at[:, 1]) == pytest.approx(10000.0 + 0.1 * at[:, 2], abs=0.5)
    with pytest.raises(InputError, match="on layer 'NONE'"):
        read_surface(tmp_path / "slabs.dxf", layer="NONE")


def test_units_of_meshes(tmp_path):
    path = tmp_path / "plate.obj"
    path.write_text(PLATE)
    guessed = read_surface(path)
    assert guessed.unit.name == "m"
    assert "guessed" in guessed.unit.reason
    assert size_of(guessed) == pytest.approx(1000.0 * np.sqrt(25.04))
    assert size_of(read_surface(path, unit="ft")) == pytest.approx(304.8 * np.sqrt(25.04))
    with pytest.raises(InputError, match=r"read in mm \(given\) .* 0.005004 m"):
        read_surface(path, unit="mm")
    with pytest.raises(InputError, match="unknown unit 'yd'"):
        read_surface(path, unit="yd")
    path.write_text(
        PLATE.replace("4", "0.01").replace("3", "0.01").replace("f 1 2 0.01 0.01", "f 1 2 3 4")
    )
    with pytest.raises(InputError, match="says no unit"):
        read_surface(path)


def test_unknown_and_missing_files(tmp_path):
    (tmp_path / "a.dwg").write_text("")
    with pytest.raises(InputError, match=r"no reader for '.dwg' files; known are .step"):
        read_surface(tmp_path / "a.dwg")
    with pytest.raises(InputError, match="no such file"):
        read_surface(tmp_path / "b.step")


def test_inspection_of_known_shapes(tmp_path):
    from shapes import cylinder, sphere, torus

    ball = inspect(sphere(3000.0))
    assert ball.area_m2 == pytest.approx(4 * np.pi * 9, rel=1e-3)
    assert ball.umbilic_share == 1.0
    assert ball.radius_min_mm == pytest.approx(3000.0)
    pipe = inspect(cylinder(2000.0, 5000.0))
    assert pipe.single_curved_share == 1.0
    assert pipe.suggestions[0].strips == 1  # straight rulings: one strip, exact
    assert pipe.boundary_loops_mm == pytest.approx([4000 * np.pi] * 2, rel=1e-4)
    ring = inspect(torus(5000.0, 2000.0))
    outer = 0.5 + 2.0 / (np.pi * 5.0)  # share of a torus' area beyond its centre circle
    assert ring.synclastic_share == pytest.approx(outer, abs=0.01)
    assert ring.anticlastic_share == pytest.approx(1 - outer, abs=0.01)


@pytest.mark.slow
def test_shared_half_hull(shared_data):
    surface = read_surface(shared_data / "surfaces" / "half-hull.step")
    assert len(surface.charts) == 12
    low, high = surface.bounds
    assert (high - low) / 1000 == pytest.approx([289, 23, 10], abs=0.5)
    x = surface.sample(600).point
    x = x + np.random.default_rng(0).normal(size=x.shape) * 100.0
    distance = np.linalg.norm(surface.closest(x).point - x, axis=1)
    dense = np.linalg.norm(x[:, None] - surface.sample(3000).point[None], axis=2).min(axis=1)
    assert (distance <= dense + 1.0).all()
    assert (distance < 600.0).all()


def test_shared_stearman(shared_data):
    pytest.importorskip("rhino3dm")
    surface = read_surface(shared_data / "surfaces" / "v2_Stearman.3dm")
    assert surface.charts[0].poles.shape == (11, 5, 3)
    assert surface.unit.name == "mm"


def test_shared_conical_mesh(shared_data):
    surface = read_surface(shared_data / "surfaces" / "conical1.obj")
    assert isinstance(surface, GridSurface)
    assert surface.grid.shape == (31, 37, 3)
    low, high = surface.bounds
    assert sorted((high - low) / 1000) == pytest.approx([16.2, 28.4, 30.0], abs=0.1)


def test_a_scale_enlarges_what_a_file_holds(fixtures, tmp_path):
    canopy = fixtures / "canopy" / "canopy.step"
    once, twice = read_surface(canopy), read_surface(canopy, scale=2.0)
    assert twice.bounds == pytest.approx(2.0 * once.bounds)
    (tmp_path / "plate.obj").write_text(PLATE)
    plate = read_surface(tmp_path / "plate.obj", unit="m", scale=50.0)
    assert np.ptp(plate.bounds, axis=0) == pytest.approx([200e3, 150e3, 10e3])


def test_inspection_for_people_has_units(fixtures):
    lines = inspect(read_surface(fixtures / "canopy" / "canopy.step")).lines()
    text = "\n".join(lines)
    assert "size       18 x 9.162 x 1.562 m" in text
    assert "-0.0777 to -0.05688 per m, radius from 12.87 m" in text
    assert 'start = "principal", direction = "larger", count = 10' in text
