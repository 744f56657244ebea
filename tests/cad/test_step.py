"""What is written to STEP is read again alike: by the kernel, and from the text without it."""

from __future__ import annotations

import numpy as np
import pytest
from cad_helpers import plate, quadrature_volume, revolution, square_hole

from fabgeo.cad.assembly import Node
from fabgeo.cad.connectors import fixing_product, place_connectors
from fabgeo.cad.plates import plate_solid
from fabgeo.cad.readback import read_package_step
from fabgeo.cad.solids import prism_solid
from fabgeo.cad.step import write_step
from fabgeo.cad.steptext import read_step_text
from fabgeo.errors import InputError
from fabgeo.structures.fixing import Fixing, LocalHole
from fabgeo.structures.parts import Connector

NAME = "Dach über Hof, 屋根 𝛼 it's \\ here"


def placed(x: float, angle: float = 0.0):
    matrix = np.eye(4)
    c, s = np.cos(angle), np.sin(angle)
    matrix[:2, :2] = [[c, -s], [s, c]]
    matrix[0, 3] = x
    return matrix


@pytest.fixture(scope="module")
def roof():
    cells = [
        Node(
            f"C-00-{i:02d}",
            prism_solid(revolution(start=0.3 * i, end=0.3 * i + 0.3)),
            colour=(0.87, 0.8, 0.62),
            layer="Zellen ß",
        )
        for i in range(3)
    ]
    mid = plate().mid
    holes = [square_hole(mid, 0.2, 0.3), square_hole(mid, 0.3, 0.6, 18.0, 12.0)]
    panel = Node("P-00-00", plate_solid(plate(holes=holes)), colour=(0.1, 0.5, 0.9), layer="panels")
    fixing = fixing_product(
        Fixing(name="FIX", flange_holes=(LocalHole(slot=10.0),)), flange=12.0, panel=8.0
    )
    connectors = [
        Connector(f"K-00-00-{i}", "FIX-25", placed(500.0 * i, 0.3), "P-00-00", "B-00-1")
        for i in range(3)
    ]
    return Node(
        NAME,
        children=(
            Node("cells", children=tuple(cells)),
            Node("panels", children=(panel,)),
            Node("connectors", children=tuple(place_connectors(connectors, {"FIX-25": fixing}))),
        ),
    )


@pytest.fixture(scope="module")
def written(roof, tmp_path_factory):
    return write_step(tmp_path_factory.mktemp("step") / "facade.step", roof)


@pytest.fixture(scope="module")
def parts(written):
    return read_package_step(written)


@pytest.fixture(scope="module")
def text(written):
    return read_step_text(written)


def test_names_tree_layers_and_colours_survive(parts):
    assert len(parts) == 3 + 1 + 3 * 7
    first = parts[0]
    assert first.path == (NAME, "cells", "C-00-00")
    assert first.layers == ("Zellen ß",)
    assert first.colour == pytest.approx((0.87, 0.8, 0.62), abs=1e-6)
    panel = next(p for p in parts if p.name == "P-00-00")
    assert panel.layers == ("panels",)
    assert panel.colour == pytest.approx((0.1, 0.5, 0.9), abs=1e-6)
    marks = {p.path[2] for p in parts if p.path[1] == "connectors"}
    assert marks == {"K-00-00-0", "K-00-00-1", "K-00-00-2"}


def test_holes_are_read_back_without_any_tolerance_of_their_own(parts):
    """Rims lie on wall and skin within the kernel's own 1e-7 mm: no reader has to widen them."""
    panel = next(p for p in parts if p.name == "P-00-00")
    assert panel.report.surfaces["cylinder"] == 4
    assert panel.report.tolerance == pytest.approx(1e-7, rel=1e-6)


def test_equal_connectors_share_one_product(parts, text):
    rods = [p for p in parts if p.name == "bolt M12 x 75"]
    assert len(rods) == 3
    assert rods[0].shape.IsPartner(rods[1].shape)
    assert sum(1 for s in text.solids if s.product == "bolt M12 x 75") == 1
    for k, rod in enumerate(rods):
        np.testing.assert_allclose(
            rod.location[:2, 3], [500.0 * k, 0.0], atol=1e-9
        )  # the rod stands on the connector's axis
        np.testing.assert_allclose(rod.location[0, 0], np.cos(0.3), atol=1e-12)


def test_every_solid_is_sound_by_both_judges(parts, text):
    placed_solids = text.parts()
    assert len(placed_solids) == len(parts)
    for part, (place, solid) in zip(parts, placed_solids, strict=True):
        assert place.path == part.path
        np.testing.assert_allclose(place.matrix, part.location, atol=1e-9)
        assert part.report.sound
        assert part.report.tolerance <= 1e-3
        assert solid.sound
        assert solid.gap < 1e-5
        assert solid.volume == pytest.approx(part.report.volume, rel=1e-9)


def test_volumes_are_the_formulas(text):
    cells = [s for s in text.solids if s.product.startswith("C-")]
    for i, solid in enumerate(cells):
        expected = quadrature_volume(revolution(start=0.3 * i, end=0.3 * i + 0.3))
        assert solid.volume == pytest.approx(expected, rel=1e-9)


def test_euler_counts_the_holes(text):
    genus = {s.product: s.genus for s in text.solids}
    assert genus["C-00-00"] == 0
    assert genus["P-00-00"] == 2
    assert genus["base plate"] == 1
    assert genus["bolt M12 x 75"] == 0
    assert genus["washer M12"] == 1


def test_schema_is_ap242(text):
    assert text.schema.startswith("AP242_MANAGED_MODEL_BASED_3D_ENGINEERING")


def test_same_moment_gives_the_same_bytes(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    root = Node("roof", children=(Node("C-00-00", prism_solid(revolution()), colour=(1, 0, 0)),))
    files = []
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        files.append(write_step(tmp_path / folder / "x.step", root).read_bytes())
    assert files[0] == files[1]
    assert b"1970-01-02T00:00:00" in files[0]
    assert files[0].isascii()


def test_nothing_is_left_beside_the_file(written):
    assert [p.name for p in written.parent.iterdir()] == ["facade.step"]


def test_empty_assembly_is_refused(tmp_path):
    with pytest.raises(InputError, match="holds no part"):
        write_step(tmp_path / "x.step", Node("nothing", children=(Node("cells"),)))


def test_text_judge_sees_a_moved_vertex(written, tmp_path):
    """One coordinate altered by 0.01 mm shows as a gap at that solid alone."""
    lines = written.read_text().splitlines(keepends=True)
    at = next(i for i, line in enumerate(lines) if "VERTEX_POINT" in line)
    point = lines[at].split("#")[2].rstrip(");\n")
    k = next(i for i, line in enumerate(lines) if line.startswith(f"#{point} ="))
    end = next(i for i in range(k, k + 3) if lines[i].rstrip().endswith(";"))
    whole = "".join(lines[k : end + 1])
    head, _, rest = whole.partition("('',(")
    x, _, others = rest.partition(",")
    lines[k : end + 1] = [f"{head}('',({float(x) + 0.01!r},{others}"]
    altered = tmp_path / "altered.step"
    altered.write_text("".join(lines))
    bad = [s for s in read_step_text(altered).solids if not s.sound]
    assert len(bad) == 1
    assert bad[0].gap == pytest.approx(0.01, rel=0.01)


def test_text_judge_sees_an_open_shell(written, tmp_path):
    """A face taken out of a shell leaves unpaired edges."""
    text = written.read_text()
    head, _, rest = text.partition("CLOSED_SHELL('',(")
    first, _, tail = rest.partition(",")
    altered = tmp_path / "open.step"
    altered.write_text(f"{head}CLOSED_SHELL('',({tail}")
    assert first.startswith("#")
    assert [s.product for s in read_step_text(altered).solids if not s.paired] == ["C-00-00"]


def test_faces_and_edges_in_numbers(parts):
    """On a cone: one curvature vanishes, the other is cos(half angle) / r; normals point out."""
    cell = parts[0]
    inner, outer = cell.faces(3)[0], cell.faces(3)[2]
    for face in (inner, outer):
        radius = np.hypot(face.points[:, 0], face.points[:, 1])
        # Two cubic spans over 0.3 rad: second derivatives are off by h^2 / 12 = 2e-3 at knots.
        expected = np.cos(np.arctan2(100.0, 1500.0)) / radius
        np.testing.assert_allclose(np.abs(face.curvatures[:, 0]), expected, rtol=5e-3)
        np.testing.assert_allclose(face.curvatures[:, 1], 0.0, atol=1e-12)
    radial = np.einsum("kd,kd->k", inner.points[:, :2], inner.normals[:, :2])
    assert np.all(np.sign(radial) == np.sign(inner.curvatures[:, 0]))
    edges = cell.edges()
    assert len(edges) == 12
    assert all(len(edge.faces) == 2 for edge in edges)
    lengths = sorted(e.length for e in edges if e.kind == "bspline")
    np.testing.assert_allclose(lengths, sorted(0.3 * np.array([5000, 5100, 5400, 5300])), rtol=1e-6)


@pytest.mark.parametrize("holes", [(LocalHole(),), Fixing().flange_holes])
def test_fixing_clamps_without_overlap(holes):
    """Solids of one fixing touch but never share volume; nothing enters panel or flange."""
    from itertools import combinations

    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common

    from fabgeo.cad.kernel import to_location
    from fabgeo.cad.measure import bounding_box, volume

    fixing = Fixing(flange_holes=holes)
    product = fixing_product(fixing, flange=12.0, panel=8.0)
    shapes = {n.name: n.instance_of.shape.Moved(to_location(n.location)) for n in product.children}
    for (first, a), (second, b) in combinations(shapes.items(), 2):
        shared, _ = volume(BRepAlgoAPI_Common(a, b).Shape())
        in_thread = {"nut", "bolt"} <= {first.split()[0], second.split()[0]}
        assert abs(shared) < 1e-6 or in_thread, (first, second)
    low, high = bounding_box(shapes["disc"])
    assert (low[2], high[2]) == pytest.approx((33.0, 39.0))
    size, washer = (12, 2.5) if len(holes) == 1 else (10, 2.0)
    low, high = bounding_box(shapes[f"nut M{size}"])
    assert high[2] == pytest.approx(-12.0 - washer)


def test_a_user_s_own_connector(tmp_path):
    def bracket(fixing):
        import build123d as b3d

        part = b3d.Pos(0, 0, fixing.stand_off / 2) * b3d.Box(
            40, 40, fixing.stand_off
        ) - b3d.Cylinder(6.5, 100)
        part.label = "bracket"
        return part

    fixing = Fixing(name="OWN", maker=bracket)
    product = fixing_product(fixing, flange=12.0, panel=8.0)
    assert product.name == "OWN-25"
    frame = placed(100.0)
    nodes = place_connectors([Connector("K-1", "OWN", frame, "P", "B")], {"OWN": product})
    (part,) = read_package_step(write_step(tmp_path / "own.step", Node("x", children=tuple(nodes))))
    assert part.report.sound
    assert part.report.volume == pytest.approx(40 * 40 * 25 - np.pi * 6.5**2 * 25, rel=1e-9)
    with pytest.raises(InputError, match=r"K-2.*OTHER"):
        place_connectors([Connector("K-2", "OTHER", frame, "P", "B")], {"OWN": product})


def test_missing_and_foreign_files(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        read_package_step(tmp_path / "none.step")
    other = tmp_path / "other.step"
    other.write_text("solid nothing")
    with pytest.raises(InputError, match="no STEP file"):
        read_package_step(other)
    with pytest.raises(InputError, match="no STEP file"):
        read_step_text(other)
