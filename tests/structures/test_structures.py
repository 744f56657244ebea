"""Cells, panels, walls, beams and fixings on exact conical models."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import BSpline

from fabgeo.arrays import cross, dot, unit
from fabgeo.cad.measure import check_solid
from fabgeo.cad.plates import plate_solid
from fabgeo.errors import GeometryError, InputError
from fabgeo.strips import exact
from fabgeo.strips.axes import axes
from fabgeo.strips.circular import conical_curves
from fabgeo.strips.model import StripModel
from fabgeo.strips.offset import offset
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.beams import BeamRule, Section, beams, plate_radii
from fabgeo.structures.boxes import oriented_box
from fabgeo.structures.cells import cells
from fabgeo.structures.clashes import clashes, clear_distance
from fabgeo.structures.connectors import connect
from fabgeo.structures.crossed import crossed
from fabgeo.structures.fixing import Fixing
from fabgeo.structures.masses import DENSITIES, plate_mass, together
from fabgeo.structures.mixed import admits, attach, mesh_beams, strips_on_mesh
from fabgeo.structures.panels import Joint, Layer, panels
from fabgeo.structures.parts import Prism
from fabgeo.structures.patches import CutRule, cut, cut_lengths
from fabgeo.structures.prisms import plate_prism, prism_properties, prism_volume, ruled_normals
from fabgeo.structures.walls import coped_walls, walls

ANGLES = np.linspace(0.0, 1.2, 9)
PROFILE = np.stack([6000 * np.cos(ANGLES), 6000 * np.sin(ANGLES)], axis=1)


def _generic(refine: int = 4) -> StripModel:
    """A conical model without symmetry: over the Moebius image of a moulding surface."""
    moulding = exact.moulding(9000.0, 900.0, PROFILE)
    circular = exact.inverted(moulding, np.array([-6000.0, 2000.0, -5000.0]), 17000.0)
    made = conical_curves(circular)
    return exact.ExactModel(made.curves, made.edges, 12, kind="conical").interpolant(refine)


@pytest.fixture(scope="module")
def conical() -> StripModel:
    return _generic()


@pytest.fixture(scope="module")
def torus() -> StripModel:
    return exact.revolution(
        8000 + 5000 * np.cos(ANGLES), 5000 * np.sin(ANGLES), segments=24
    ).interpolant()


def _twist_deg(mid: RuledPatch) -> float:
    u = mid.parameters(8)
    a, b = mid.edges(u)
    normals = [unit(cross(d, b - a)) for d in mid.edges(u, 1)]
    return float(np.degrees(np.arcsin(np.linalg.norm(cross(*normals), axis=-1).max())))


@pytest.mark.parametrize("distance", [-400.0, 300.0])
def test_offset_keeps_distance(conical: StripModel, distance: float) -> None:
    made = offset(conical, distance)
    assert made.errors.curve <= 1e-3
    assert made.errors.ruling < 0.01
    assert made.errors.plane < 0.01
    assert made.errors.angle_deg < 0.01


def test_folded_offset_is_refused_by_strip_and_radius(torus: StripModel) -> None:
    with pytest.raises(GeometryError, match=r"strip \d+ at u.*smallest radius.* 49\d\d"):
        offset(torus, -5100.0)


def test_general_model_is_refused_with_the_reason() -> None:
    rng = np.random.default_rng(5)
    control = _generic(1).control + rng.normal(0.0, 60.0, _generic(1).control.shape)
    model = StripModel(control)
    with pytest.raises(GeometryError, match="need a conical or a circular model"):
        cells(model, cut(model, CutRule(count=2)), -300.0)
    assert not admits(model).beams
    assert "common axis" in admits(model).reason
    assert panels(
        StripModel(control[:2]),
        cut(StripModel(control[:2]), CutRule(count=2)),
        Layer("skin", 0.0, 3.0, "steel"),
    )


def test_neighbouring_cells_share_faces_to_the_last_digit(conical: StripModel) -> None:
    patches = cut(conical, CutRule(length=1500.0))
    made = {(c.patch.strip, c.patch.cell): c.prism for c in cells(conical, patches, -300.0)}
    for (strip, cell), prism in made.items():
        beside = made.get((strip + 1, cell))
        if beside is not None:
            assert np.array_equal(prism.knots, beside.knots)
            assert np.array_equal(prism.poles[1], beside.poles[0])
            assert np.array_equal(prism.poles[2], beside.poles[3])
        after = made.get((strip, cell + 1))
        if after is not None:
            assert np.abs(prism.poles[:, -1] - after.poles[:, 0]).max() < 1e-9


def test_cell_walls_are_plane_and_volume_agrees_with_a_second_route(conical: StripModel) -> None:
    patches = cut(conical, CutRule(count=3))
    for cell in cells(conical, patches, -300.0):
        for end in (0, -1):
            a, b, c, d = cell.prism.poles[:, end]
            normal = unit(cross(c - a, d - b))
            assert abs(float(dot(b - a, normal))) < 1e-3
    prism = cells(conical, patches, -300.0)[4].prism
    # Divergence theorem over dense bilinear faces, a route without the Jacobian.
    assert np.isclose(prism_volume(prism), _volume_by_surface(prism), rtol=2e-6)


def _volume_by_surface(prism: Prism, count: int = 400) -> float:
    u = np.linspace(prism.knots[0], prism.knots[-1], count + 1)
    p = np.moveaxis(np.asarray(BSpline(prism.knots, np.moveaxis(prism.poles, 1, 0), 3)(u)), 0, 1)
    p = p - p.mean(axis=(0, 1))
    q = np.roll(p, -1, axis=0)
    total = 0.0
    for a, b, c in (
        (p[:, :-1], q[:, :-1], q[:, 1:]),
        (p[:, :-1], q[:, 1:], p[:, 1:]),
        (p[:, :-1], q[:, :-1], p[:, 1:]),
        (q[:, :-1], q[:, 1:], p[:, 1:]),
    ):  # both ways to split a bilinear face, halved: exact for its volume
        total += float(dot(a, cross(b, c)).sum()) / 12.0
    ends = 0.0
    for k, sign in ((0, -1.0), (-1, 1.0)):
        a, b, c, d = p[:, k]
        ends += sign * float(dot(a, cross(b, c)) + dot(a, cross(c, d))) / 6.0
        ends += sign * float(dot(b, cross(c, d)) + dot(b, cross(d, a))) / 6.0
    return abs(total + ends / 2.0)


def test_folded_cell_is_refused_by_mark() -> None:
    knots = np.array([0.0] * 4 + [1.0] * 4)
    s = np.linspace(0.0, 1.0, 4)[:, None]
    ends = np.array(
        [
            [[0, 0, 0], [100, 0, 0]],
            [[0, 50, 0], [100, 50, 0]],
            [[100, 50, 30], [0, 50, 30]],
            [[100, 0, 30], [0, 0, 30]],
        ],
        dtype=float,
    )
    poles = np.stack([e[0] + s * (e[1] - e[0]) for e in ends])
    assert prism_properties(Prism("C-00-00", knots, poles)).orientation < 0.0


def test_panels_of_any_height_keep_parallel_rulings_and_the_joint(conical: StripModel) -> None:
    patches = cut(conical, CutRule(length=1500.0))
    for height in (0.0, 60.0):
        made = {
            p.mark: p
            for p in panels(
                conical,
                patches,
                Layer("glass", height, 10.0, "glass"),
                Joint(edge=12.0, ruling=10.0),
            )
        }
        for plate in made.values():
            assert _twist_deg(plate.mid) < 0.01
        first = made["P-02-01"]
        beside = made[first.shared["second"]]
        u = np.linspace(max(first.mid.u0, beside.mid.u0), min(first.mid.u1, beside.mid.u1), 25)
        near, far = first.mid.edges(u)[1], beside.mid.edges(u)[0]
        t = unit(first.mid.edges(u, 1)[1])
        across = far - near
        clear = np.linalg.norm(across - dot(across, t)[:, None] * t, axis=-1)
        kink = np.arccos(dot(ruled_normals(first.mid, u), ruled_normals(beside.mid, u)))
        # Two halves square to the edge, hinged by the kink: the straight gap is 12 cos(kink / 2).
        assert np.abs(clear - 12.0 * np.cos(kink / 2.0)).max() < 0.02
        after = made[first.shared["end"]]
        ends = first.mid.edges(np.array([first.mid.u1]))[:, 0]
        others = after.mid.edges(np.array([after.mid.u0]))[:, 0]
        e = unit(ends[1] - ends[0])
        steps = others - ends
        gaps = np.linalg.norm(steps - dot(steps, e)[:, None] * e, axis=-1)
        assert gaps.min() == pytest.approx(10.0, abs=0.05)


def test_layer_surfaces_lie_at_their_height(conical: StripModel) -> None:
    patches = cut(conical, CutRule(count=2))
    low = panels(conical, patches, Layer("a", 0.0, 10.0, "glass"))
    high = panels(conical, patches, Layer("b", 80.0, 10.0, "glass"))
    for a, b in zip(low, high, strict=True):
        u = np.linspace(a.mid.u0, a.mid.u1, 17)
        m = ruled_normals(a.mid, u)
        for x, y in zip(a.mid.edges(u), b.mid.edges(u), strict=True):
            assert np.abs(dot(y - x, m) - 80.0).max() < 2e-3


def test_joint_that_eats_the_panel_is_refused(conical: StripModel) -> None:
    with pytest.raises(GeometryError, match=r"P-00-00.*leave nothing"):
        panels(conical, cut(conical, CutRule(count=2)), Layer("a", 0.0, 4.0, "steel"), Joint(9e3))


def test_plate_volume_is_area_times_thickness(torus: StripModel) -> None:
    plate = panels(torus, cut(torus, CutRule(count=2)), Layer("a", 0.0, 20.0, "steel"))[3]
    mass = plate_mass(plate, DENSITIES["steel"])
    assert mass.volume == pytest.approx(prism_volume(plate_prism(plate)), rel=1e-6)
    assert mass.mass == pytest.approx(mass.volume * 7.85e-6)
    assert np.allclose(together([mass, mass]).centre, mass.centre)


def test_cone_patch_area_in_closed_form() -> None:
    """Between two circles of a cone: (s2^2 - s1^2) / 2 times the opening times sin(half angle)."""
    model = exact.cone(0.5, np.array([6000.0, 7000.0]), opening=1.2, segments=24).interpolant()
    plate = panels(model, cut(model, CutRule(count=1)), Layer("a", 0.0, 1.0, "steel"))[0]
    expected = (7000.0**2 - 6000.0**2) / 2.0 * 1.2 * np.sin(0.5)
    assert plate_mass(plate, 1.0).area == pytest.approx(expected, rel=1e-7)
    least, largest = plate_radii(plate.mid)
    assert least == pytest.approx(6000.0 * np.tan(0.5), rel=3e-3)
    assert largest == pytest.approx(7000.0 * np.tan(0.5), rel=3e-3)


def test_cut_by_length_gives_equal_lengths(torus: StripModel) -> None:
    patches = cut(torus, CutRule(length=1500.0, common=False))
    lengths = cut_lengths(torus, patches).mean(axis=1)
    for strip in range(torus.strips):
        mine = lengths[[k for k, p in enumerate(patches) if p.strip == strip]]
        assert np.ptp(mine) < 0.02 * mine.mean()
        assert 1100.0 < mine.mean() < 2000.0


def test_cut_by_transport_box_fits(torus: StripModel) -> None:
    box = (2000.0, 1500.0, 400.0)
    for patch in cut(torus, CutRule(box=box)):
        points = np.concatenate(patch.edges(torus, patch.parameters(9)))
        assert oriented_box(points).fits(box)


def test_oriented_box_finds_a_turned_box() -> None:
    rng = np.random.default_rng(3)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    corners = np.array([[x, y, z] for x in (0, 5) for y in (0, 3) for z in (0, 1)], dtype=float)
    inside = rng.uniform(size=(40, 3)) * (5, 3, 1)
    box = oriented_box(np.concatenate([corners, inside]) @ turn + 7.0)
    assert np.allclose(box.size, (5.0, 3.0, 1.0), atol=1e-2)
    flat = oriented_box(corners[[0, 2, 4, 6]] @ turn)
    assert np.allclose(flat.size, (5.0, 3.0, 0.0), atol=1e-9)


def test_walls_are_plane_and_lie_between_the_axes(conical: StripModel) -> None:
    patches = cut(conical, CutRule(count=3))
    made = walls(conical, patches, (-20.0, -280.0), 6.0, "steel", clearance=8.0)
    assert len(made) == conical.strips * 4
    for plate in made:
        a, b = plate.mid.poles
        corners = np.stack([a[0], a[-1], b[-1], b[0]])
        normal = unit(cross(corners[2] - corners[0], corners[3] - corners[1]))
        assert abs(float(dot(corners[1] - corners[0], normal))) < 0.01


def test_coped_walls_stand_clear_of_webs_and_flanges(torus: StripModel) -> None:
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape

    from fabgeo.cad.plates import plate_solid

    section = Section(outer=-27.0, depth=240.0, web=8.0, flange_outer=10.0, flange_inner=10.0)
    patches = cut(torus, CutRule(count=8))
    wall = next(
        w for w in coped_walls(torus, patches, section, 6.0, "steel") if "W-03-02" in w.mark
    )
    beam_plates = [p for b in beams(torus, section, BeamRule(), [3, 4]) for p in b.plates]
    solid = plate_solid(wall)
    gaps = {p.mark: BRepExtrema_DistShapeShape(solid, plate_solid(p)).Value() for p in beam_plates}
    near = sorted(gaps.values())[:6]  # web and both flanges of each beam
    assert near[0] > 1.9
    assert near[-1] < 2.5
    corners = np.concatenate(wall.mid.edges(wall.mid.parameters(2)))
    middle = corners - corners.mean(axis=0)
    assert np.linalg.svd(middle)[1][2] < 1e-6  # plane


@pytest.mark.parametrize("construction", ["trajectory", "envelope"])
def test_beams_are_developable_and_orthogonal(conical: StripModel, construction) -> None:
    section = Section(outer=-40.0, depth=300.0)
    rule = BeamRule(construction=construction)
    for beam in beams(conical, section, rule, edges=[0, 3, conical.edges - 1]):
        plates = {plate.role: plate for plate in beam.plates}
        web, flange = plates["web"].mid, plates["flange_outer"].mid
        for plate in beam.plates:
            assert _twist_deg(plate.mid) < 0.01
        u = np.linspace(beam.u0, beam.u1, 33)
        angle = dot(ruled_normals(web, u), ruled_normals(flange, u))
        assert np.degrees(np.arcsin(np.abs(angle).max())) < 0.01
        if construction == "trajectory":
            depth = np.linalg.norm(web.edges(u)[1] - web.edges(u)[0], axis=-1)
            assert np.ptp(depth) < 0.05
            assert abs(depth.mean() - section.clear) < 0.05


def test_beam_segments_fit_the_truck_and_end_plates_close_them(conical: StripModel) -> None:
    box = (4000.0, 2480.0, 2500.0)
    made = beams(conical, Section(), BeamRule(box=box, gap=4.0, end_plate=15.0), edges=[2])
    assert len(made) >= 2
    assert all(b.info["box_length"] <= 4000.0 for b in made)
    assert [p.mark for p in made[0].plates][-1] == "B-02-1-EPB"
    facing = [p for b in made[:2] for p in b.plates if p.role == "end_plate"][:2]
    centres = [p.mid.points(np.array([0.5]), np.array([0.5]))[0] for p in facing]
    assert np.linalg.norm(centres[0] - centres[1]) == pytest.approx(4.0 + 15.0, abs=0.6)
    for beam in made:
        for plate in beam.plates:
            assert prism_properties(plate_prism(plate)).orientation > 0.5


def test_box_and_t_sections(conical: StripModel) -> None:
    box = beams(conical, Section(box=120.0, web=8.0), edges=[3])[0]
    webs = [p.mid for p in box.plates if p.role == "web"]
    u = np.linspace(box.u0, box.u1, 9)
    apart = webs[1].edges(u)[0] - webs[0].edges(u)[0]
    assert np.allclose(np.linalg.norm(apart, axis=-1), 128.0, atol=2e-3)
    assert max(_twist_deg(w) for w in webs) < 0.01
    t = beams(conical, Section(flange_inner=0.0), edges=[3])[0]
    assert {p.role for p in t.plates} == {"web", "flange_outer"}


def test_envelope_flange_refuses_where_the_edge_is_straight() -> None:
    model = exact.cylinder(9000.0, 8000.0, ANGLES).interpolant()
    with pytest.raises(GeometryError, match=r"degenerates.*trajectories"):
        beams(model, Section(), BeamRule(construction="envelope"), edges=[2])


def test_fixings_pierce_panel_and_flange_on_one_axis(conical: StripModel) -> None:
    patches = cut(conical, CutRule(length=1800.0))
    skin = panels(conical, patches, Layer("skin", 0.0, 10.0, "steel"), Joint(12.0, 12.0))
    section = Section(outer=-32.0, width_outer=260.0)
    frame = beams(conical, section, BeamRule(box=(5000.0, 2480.0, 2500.0)))
    made = connect(skin, frame, Fixing(edge_distance=55.0))
    assert len(made.connectors) > 50
    holes = {p.mark: p.holes for p in made.panels}
    flanges = {p.mark: p for b in made.beams for p in b.plates if p.role == "flange_outer"}
    assert sum(map(len, holes.values())) == len(made.connectors)
    assert sum(len(p.holes) for p in flanges.values()) == 2 * len(made.connectors)
    for connector in made.connectors:
        z, origin = connector.frame[:3, 2], connector.frame[:3, 3]
        hole = min(holes[connector.panel], key=lambda h: np.linalg.norm(h.centre - origin))
        off = hole.centre - origin
        assert np.linalg.norm(off - (off @ z) * z) < 1e-6
        product = made.products[connector.product]
        low, high = product.stand_off, product.stand_off + product.step
        assert low - 1e-6 <= off @ z - 5.0 <= high + 1e-6
    # Bolt axes of all holes in a flange meet its mid-surface: they lie on it within 0.1 mm.
    for plate in flanges.values():
        u = np.linspace(plate.mid.u0, plate.mid.u1, 4001)
        a, b = plate.mid.edges(u)
        for hole in plate.holes[:3]:
            v = dot(hole.centre - a, b - a) / dot(b - a, b - a)
            assert np.linalg.norm(a + v[:, None] * (b - a) - hole.centre, axis=-1).min() < 1.0
    found = clashes(made.connectors, made.products, made.panels, made.beams)
    assert all(c.first in {k.mark for k in made.connectors} for c in found)


def test_narrow_flange_and_far_panel_are_refused_by_name(conical: StripModel) -> None:
    patches = cut(conical, CutRule(count=3))
    skin = panels(conical, patches, Layer("skin", 0.0, 10.0, "steel"), Joint(12.0))
    narrow = connect(skin, beams(conical, Section(outer=-32.0, width_outer=100.0)), Fixing())
    assert not narrow.connectors
    assert all("wide" in reason for reason in narrow.refused.values())
    far = connect(skin, beams(conical, Section(outer=-200.0, width_outer=300.0)), Fixing())
    assert not far.connectors
    assert all("stand-off" in reason for reason in far.refused.values())
    assert all(where.startswith("P-") for where in far.refused)


def test_clear_distance_of_flange_and_panel(torus: StripModel) -> None:
    panel = panels(torus, cut(torus, CutRule(count=8)), Layer("skin", 0.0, 4.0, "steel"))[20]
    strip = int(panel.mark.split("-")[1])
    for outer, low, high in ((-27.0, 20.0, 25.2), (-1.0, -6.0, 0.0)):
        beam = beams(torus, Section(outer=outer, width_outer=100.0), BeamRule(), [strip])[0]
        flange = next(p for p in beam.plates if p.role == "flange_outer")
        assert low < clear_distance(panel, flange) < high  # 2 mm of panel, less where it tilts


def test_overlapping_fixings_are_found_and_named(conical: StripModel) -> None:
    patches = cut(conical, CutRule(count=2))
    skin = panels(conical, patches[:2], Layer("skin", 0.0, 10.0, "steel"), Joint(12.0))
    frame = beams(conical, Section(outer=-32.0, width_outer=260.0), edges=[1])
    made = connect(skin, frame, Fixing(spacing=90.0))
    found = clashes(made.connectors, made.products, made.panels, made.beams)
    assert any(c.reason == "fixings overlap" for c in found)


def test_layers_of_quad_mesh_and_strips(torus: StripModel) -> None:
    """On parallel circles the gap is the sagitta of the chord between two nodes."""
    u = np.linspace(0.0, 24.0, 9)
    layered = attach(torus, u)
    radius, angle = 13000.0, 1.2 / 8.0
    assert layered.gap_max == pytest.approx(radius * (1.0 - np.cos(angle / 2.0)), rel=1e-5)
    assert layered.node_error < 1e-9
    assert layered.planarity < 1e-6
    made = mesh_beams(layered, axes(torus)(u), Section(), edges=[2])
    assert len(made) == 8
    assert all(_twist_deg(p.mid) < 0.01 for b in made for p in b.plates)
    model, again = strips_on_mesh(layered.nodes)
    assert again.node_error < 1e-6
    assert again.gap_max == pytest.approx(layered.gap_max, rel=1e-2)
    assert model.strips == torus.strips


def test_two_crossed_models(torus: StripModel) -> None:
    tubes = exact.meridians(
        8000.0, 5000.0, np.linspace(0.1, 1.1, 5), 0.05, 1.15, segments=24
    ).interpolant()
    made = crossed(torus, tubes, (Section(), Section(outer=-400.0)))
    assert made.angle_min_deg == pytest.approx(90.0, abs=0.01)
    assert made.outer
    assert made.inner
    with pytest.raises(GeometryError, match="meet at"):
        crossed(torus, torus, (Section(), Section()))


def test_bevelled_segments_leave_the_root_gap_and_open_to_the_groove(torus: StripModel) -> None:
    section = Section(outer=-60.0, depth=300.0, web=10.0)
    rule = BeamRule(at=(8.0, 16.0), gap=3.0, bevel=60.0)
    made = beams(torus, section, rule, edges=[4])
    gaps = []
    for first, second in pairwise(made):
        for left, right in zip(first.plates, second.plates, strict=True):
            run = left.thickness * np.tan(np.radians(30.0))
            assert left.bevel[1] == right.bevel[0] == pytest.approx(run)
            a, b = (plate_prism(plate).poles for plate in (left, right))
            across = unit(a[0, -1] - a[0, -2])
            root = (b[:2, 0] - a[:2, -1]) @ across
            groove = (b[2:, 0] - a[2:, -1]) @ across
            gaps.append(root.min())
            np.testing.assert_allclose(groove - root[::-1], 2.0 * run, rtol=0.02)
    assert min(gaps) == pytest.approx(3.0, abs=0.05)  # at the inner corner, more elsewhere
    for plate in made[1].plates:  # bevels at both ends take no volume off: what they cut they add
        expected = plate_mass(plate, 1.0).volume
        volume = prism_volume(plate_prism(plate))
        assert volume == pytest.approx(expected, rel=1e-5)
        report = check_solid(plate_solid(plate))
        assert report.sound
        assert report.tolerance <= 1e-3
        assert report.volume == pytest.approx(volume, rel=1e-6)
    assert made[1].info["bevel_deg"] == 60.0
    assert made[0].plates[0].bevel[0] == 0.0  # the beam's own end stays square


def test_end_plates_and_bevels_exclude_each_other() -> None:
    with pytest.raises(InputError, match="end plates"):
        BeamRule(end_plate=12.0, bevel=60.0)
