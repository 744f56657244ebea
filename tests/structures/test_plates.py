"""Panels, layers and walls: thickness, joints, cuts, mass, transport."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from structure_models import twist_deg

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.cad.plates import plate_solid
from fabgeo.errors import GeometryError
from fabgeo.fitting.fit import fit
from fabgeo.fitting.starts import start
from fabgeo.strips import exact
from fabgeo.strips.model import StripModel
from fabgeo.structures.beams import BeamRule, Section, beams, plate_radii
from fabgeo.structures.boxes import oriented_box
from fabgeo.structures.masses import DENSITIES, plate_mass, together
from fabgeo.structures.panels import Joint, Layer, panels
from fabgeo.structures.patches import CutRule, cut, cut_lengths
from fabgeo.structures.prisms import plate_prism, prism_volume, ruled_normals
from fabgeo.structures.walls import coped_walls, walls
from fabgeo.surfaces.formula import FormulaSurface


@pytest.mark.parametrize("height", [-20.0, 40.0])
def test_layers_of_strips_that_go_on_smoothly_stay_beside_them(height: float) -> None:
    # Four rings of one cylinder, off it by what fits leave: planes meet at hardly any angle.
    places = 1000.0 * np.arange(5.0)

    def rings(u: Array) -> Array:
        way = np.stack([np.cos(u / 8.0), np.sin(u / 8.0), np.zeros_like(u)], axis=-1)
        return 5000.0 * way + places[:, None, None] * np.array([0.0, 0.0, 1.0])

    exactly = exact.ExactModel(rings, edges=5, segments=12).interpolant(2)
    noise = np.random.default_rng(1).normal(0.0, 0.01, exactly.control.shape)
    model = exactly.with_control(exactly.control + noise)
    layer = Layer("lining", height, 10.0, "glass")
    for plate in panels(model, cut(model, CutRule(count=3)), layer, Joint(edge=0.0, ruling=0.0)):
        a, b = plate.mid.edges(plate.mid.parameters(8))
        strip = int(plate.mark.split("-")[1])
        for points, place in ((a, places[strip]), (b, places[strip + 1])):
            assert np.abs(np.linalg.norm(points[:, :2], axis=1) - 5000.0 - height).max() < 0.1
            assert np.abs(points[:, 2] - place).max() < 0.1


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
            assert twist_deg(plate.mid) < 0.01
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


def test_a_model_parted_at_an_edge_has_the_panels_of_the_whole(conical: StripModel) -> None:
    layer, rule = Layer("panel", 0.0, 3.0, "glass"), CutRule(count=2)
    whole = panels(conical, cut(conical, rule), layer, Joint(12.0, 10.0))
    made = []
    for rows, seams, first in ((slice(0, 3), (False, True), 0), (slice(2, None), (True, False), 2)):
        part = conical.with_control(conical.control[rows])
        own = [replace(patch, strip=patch.strip + first) for patch in cut(part, rule)]
        made += panels(part, own, layer, Joint(12.0, 10.0, seams=seams), first=first)
    assert [plate.mark for plate in made] == [plate.mark for plate in whole]
    for one, other in zip(made, whole, strict=True):
        u = one.mid.parameters(4)
        assert np.abs(one.mid.edges(u) - other.mid.edges(u)).max() < 1e-6
        across = {"P-01": "second", "P-02": "first"}.get(one.mark[:4])
        assert set(other.shared) - set(one.shared) == ({across} if across else set())


def test_layers_of_a_general_model_meet_edge_to_edge() -> None:
    """Its strips' rulings lean differently along an edge: one lean for both leaves 5 mm open."""
    z = "0.05*u*v - 0.03*u**2 + 0.02*v**2"
    roof = FormulaSurface("u", "v", z, (-3.0, 3.0), (-4.0, 4.0), scale=1000.0)
    begun = start(roof, "auto", 4, 10)
    model = fit(begun.reference, begun.model).model
    patches = cut(model, CutRule(count=1))
    angles = []
    for height in (-40.0, 40.0):
        made = panels(model, patches, Layer("panel", height, 3.0, "glass"))
        for one, beyond in pairwise(made):
            u = np.linspace(one.mid.u0, one.mid.u1, 2001)
            near, far = one.mid.edges(u)[1][200:-200:50], beyond.mid.edges(u)[0]
            steps = near[:, None] - far
            k = np.linalg.norm(steps, axis=-1).argmin(axis=1)
            t = unit(beyond.mid.edges(u[k], 1)[0])
            step = near - far[k]
            assert np.linalg.norm(step - dot(step, t)[:, None] * t, axis=1).max() < 0.05
            angles.append(dot(ruled_normals(one.mid, u), ruled_normals(beyond.mid, u)).min())
    assert np.degrees(np.arccos(min(angles))) > 3.0


def test_layers_of_a_divided_strip_lie_as_those_of_the_whole() -> None:
    roof = FormulaSurface("u", "v", "-0.06*u**2 - 0.05*v**2", (-1.0, 1.0), (-1.5, 1.5), scale=1e3)
    begun = start(roof, "auto", 3, 8)
    model = fit(begun.reference, begun.model).model
    layer, rule = Layer("panel", 40.0, 3.0, "glass"), CutRule(count=1)
    whole, lanes = (panels(m, cut(m, rule), layer) for m in (model, model.divided(2)))
    u = whole[0].mid.parameters(4)
    for k, plate in enumerate(whole):
        first, second = lanes[2 * k].mid.edges(u), lanes[2 * k + 1].mid.edges(u)
        assert np.abs(first[1] - second[0]).max() < 1e-2
        assert np.abs(np.stack([first[0], second[1]]) - plate.mid.edges(u)).max() < 1e-2


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
    straight = oriented_box(corners)  # faces along the axes are seen edge on
    assert np.allclose(straight.size, (5.0, 3.0, 1.0), atol=1e-12)
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


@pytest.mark.slow
@pytest.mark.parametrize("inner", [0.0, 10.0])
def test_walls_stand_clear_of_deep_beams_that_lean(conical: StripModel, inner: float) -> None:
    """Axes lean along the rulings: 600 mm below the panels a web has left its edge by 50 mm."""
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape

    section = Section(outer=-27.0, depth=600.0, web=6.0, flange_outer=10.0, flange_inner=inner)
    patches = cut(conical, CutRule(count=3))
    made = coped_walls(conical, patches, section, 6.0, "steel")
    plates = [p for b in beams(conical, section, BeamRule(), [1, 2]) for p in b.plates]
    solid = plate_solid(next(wall for wall in made if wall.mark == "W-01-01"))
    gaps = [BRepExtrema_DistShapeShape(solid, plate_solid(plate)).Value() for plate in plates]
    assert min(gaps) > 1.8


def test_coped_walls_stand_clear_of_webs_and_flanges(torus: StripModel) -> None:
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape

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
