"""Initial strip models: closed forms, laws of conjugate nets, and messages that name the place."""

from __future__ import annotations

import numpy as np
import pytest

from fabgeo.cad.read_surface import read_surface
from fabgeo.errors import GeometryError, InputError
from fabgeo.fitting.hindrance import hindrance
from fabgeo.fitting.starts import start
from fabgeo.fitting.starts.conjugate import conjugate_parameters
from fabgeo.fitting.starts.crossings import crossings
from fabgeo.fitting.starts.ends import leans
from fabgeo.fitting.starts.iso import iso_net
from fabgeo.fitting.starts.net import Net, model_through
from fabgeo.fitting.starts.network import conjugacy_defect
from fabgeo.fitting.starts.quality import check_folds, quality
from fabgeo.fitting.starts.sections import net_of_sections
from fabgeo.surfaces.formula import FormulaSurface
from fabgeo.surfaces.quadgrid import GridSurface
from fabgeo.surfaces.trace_extension import Extended

DOME = FormulaSurface(
    "u", "v", "-0.5e-4 * u**2 + 0.3e-4 * u * v - 0.3e-4 * v**2", (-4e3, 4e3), (-4e3, 4e3)
)
MOULDED = FormulaSurface("u", "v", "-0.5e-4*u**2 - 0.3e-4*v**2", (-4e3, 4e3), (-4e3, 4e3))
TUBE = FormulaSurface(
    "3000*cos(u)", "2000*sin(u)", "v", (0.0, 2 * np.pi), (0.0, 9000.0), closed_u=True
)


def test_translational_surface_starts_without_twist():
    # Lines u = const and v = const of z = f(u) + g(v) are conjugate: a(u) + b(v) moves the same
    # curve along, so that tangents at both ends of a ruling are parallel.
    found = quality(start(MOULDED, "iso", 10, 12, conjugate=False).model, MOULDED)
    assert found.twist_max < 0.1
    assert found.folds == 0.0
    assert found.coverage == 1.0


def test_conjugate_parameters_halve_the_twist_and_stay_monotone():
    net, _ = iso_net(DOME)
    s = net.places(12)
    t, note = conjugate_parameters(net, s, 14)
    assert np.all(np.diff(t, axis=1) > 0.0)
    assert np.all(t[:, [0, -1]] == [0.0, 1.0])
    plain = quality(start(DOME, "iso", 12, 14, conjugate=False).model, DOME)
    better = quality(start(DOME, "iso", 12, 14).model, DOME)
    assert better.twist_rms < 0.75 * plain.twist_rms
    assert "conjugate" in note


@pytest.mark.slow
def test_auto_names_its_reason_and_orders_candidates():
    found = start(DOME, "auto", 10, 12)
    scores = [c.score for c in found.candidates if c.trial is not None]
    assert scores == sorted(scores)
    assert found.candidates[0].trial is not None
    assert found.why.count("twist") >= len(found.candidates)
    assert found.method in ("iso", "principal", "geodesic")
    assert (found.model.strips, found.model.segments) == (10, 12)


@pytest.mark.slow
def test_auto_leaves_lines_that_no_developable_strip_can_cross():
    # z = k x y: its parameter lines are asymptotic, its principal lines run diagonally.
    saddle = FormulaSurface("u", "v", "4e-5 * u * v", (-4e3, 4e3), (-4e3, 4e3))
    found = start(saddle, "auto", 8, 8)
    assert found.method == "principal"
    assert found.candidates[0].works
    iso = [c for c in found.candidates if c.method == "iso"]
    assert len(iso) == 2
    assert not any(c.works for c in iso)
    assert "after a short fit" in found.why


@pytest.mark.parametrize("counts", [(6, 10), (16, 24), (3, 7)])
def test_starts_have_the_numbers_asked_for(counts):
    for direction in ("u", "v"):
        model = start(DOME, "iso", *counts, direction, conjugate=False).model
        assert (model.strips, model.segments) == counts


def test_sag_target_rules_the_number_of_strips():
    # Sag falls with the square of the width: a quarter of it needs about twice the strips.
    coarse = start(DOME, "iso", sag=8.0, direction="v").model.strips
    fine = start(DOME, "iso", sag=2.0, direction="v").model.strips
    assert fine == pytest.approx(2 * coarse, abs=1)


def test_closed_directions_are_honoured():
    around = start(TUBE, "iso", 6, 24, "u").model
    assert around.closed_u
    assert not around.closed_i
    along = start(TUBE, "iso", 24, 6, "v").model
    assert along.closed_i
    assert not along.closed_u
    # An elliptic cylinder is developable: its own lines are conjugate.
    assert quality(along, TUBE).twist_max < 2e-3


def test_resampled_model_is_the_model_refined():
    first = start(DOME, "iso", 6, 8).model
    second = start(DOME, "model", 6, 16, seed=first)
    u = np.linspace(0.0, 8.0, 33)
    assert np.abs(second.model.points(2.0 * u) - first.points(u)).max() < 1e-9
    third = start(DOME, "model", 9, 8, seed=first).model
    assert (third.strips, third.segments) == (9, 8)
    assert np.abs(third.points(u)[[0, -1]] - first.points(u)[[0, -1]]).max() < 1.0


@pytest.mark.slow
def test_principal_lines_of_a_torus_are_its_circles():
    torus = FormulaSurface(
        "(5000 + 2000*cos(v))*cos(u)", "(5000 + 2000*cos(v))*sin(u)", "2000*sin(v)",
        (-0.6, 0.6), (-0.5, 0.5),
    )  # fmt: skip
    found = start(torus, "principal", 8, 10)
    points = found.model.points(found.model.parameters(2))
    inside = ~torus.closest(points.reshape(-1, 3)).on_boundary.reshape(points.shape[:2])
    # Edges along the larger curvature run in planes through the axis: constant u.
    angle = np.arctan2(points[..., 1], points[..., 0])
    assert max(np.ptp(a[i]) for a, i in zip(angle, inside, strict=True) if i.any()) < 1e-3
    assert found.overhangs


@pytest.mark.slow
def test_principal_start_tells_of_umbilics():
    sphere = FormulaSurface(
        "9000*cos(u)*cos(v)", "9000*sin(u)*cos(v)", "9000*sin(v)", (-0.4, 0.4), (-0.4, 0.4)
    )
    try:
        notes = start(sphere, "principal", 6, 6).notes
    except GeometryError as error:
        notes = [str(error)]
    assert any("hardly defined" in n or "umbilic" in n for n in notes)


@pytest.mark.slow
def test_a_start_that_covers_a_part_says_what_keeps_it_from_the_rest():
    # Principal lines of a monkey saddle turn about its flat umbilic.
    monkey = FormulaSurface("u", "v", "(u**3 - 3*u*v**2)/60", (-5, 5), (-5, 5), scale=1e3)
    found = start(monkey, kind="conical")
    assert found.method == "principal"
    assert "no more of it is covered since umbilic near" in found.why
    assert set(found.model.info["start"]["tried"]) == {"iso", "principal"}


def test_parallel_sections_meet_in_parallel_tangents():
    # An ellipse and its scaled, raised copies: similar sections correspond by their centre.
    w = np.linspace(0.0, 2.0 * np.pi, 181)
    sections = [
        np.stack([k * 3000 * np.cos(w), k * 2000 * np.sin(w), 0 * w + 3500 * j], axis=1)
        for j, k in enumerate((1.0, 0.95, 0.88, 0.8))
    ]
    net = net_of_sections(sections, np.array([0.0, 0.0, 1.0]))
    t, _ = conjugate_parameters(net, np.linspace(0, 1, 4), 40)
    points = net.sampled(np.linspace(0, 1, 4), t)
    tangent = net.evaluate(np.broadcast_to(np.linspace(0, 1, 4)[:, None], t.shape), t, 0, 1)
    turn = np.arctan2(tangent[..., 1], tangent[..., 0])
    assert np.abs(np.angle(np.exp(1j * np.diff(turn, axis=0)))).max() < np.radians(0.5)
    assert np.ptp(points[..., 2], axis=1).max() < 1e-6


def test_sections_that_do_not_fit_together_are_named():
    w = np.linspace(0.0, 2.0 * np.pi, 60)
    ring = np.stack([np.cos(w), np.sin(w), 0 * w], axis=1)
    with pytest.raises(InputError, match=r"section 1.*open"):
        net_of_sections([ring, ring[:30] + np.array([0, 0, 1])], np.array([0.0, 0.0, 1.0]))
    tilted = ring + np.stack([0 * w, 0 * w, 1 + 0.1 * np.cos(w)], axis=1)
    with pytest.raises(InputError, match=r"section 1.*leaves its plane"):
        net_of_sections([ring, tilted], np.array([0.0, 0.0, 1.0]))


def test_a_meshs_own_net_overhangs_for_conical_models():
    x, y = np.meshgrid(np.linspace(-4e3, 4e3, 9), np.linspace(-3e3, 3e3, 7), indexing="ij")
    grid = np.stack([x, y, -0.5e-4 * x**2 - 0.3e-4 * y**2], axis=-1)
    surface = GridSurface(grid)
    model = start(surface, "mesh", around=True).model
    assert (model.strips, model.segments) == (10, 8)
    points = model.points(np.arange(9.0))
    np.testing.assert_allclose(points[1:-1, 1:-1], grid, atol=1e-9)
    # The parabolas through the outer vertices are the surface's own: one step further out.
    np.testing.assert_allclose(points[0, 1:-1, 0], -5e3)
    np.testing.assert_allclose(points[0, 1:-1, 2], -0.5e-4 * 5e3**2 - 0.3e-4 * grid[0, :, 1] ** 2)


def test_geodesics_reach_beyond_the_boundary_on_all_sides():
    # An edge along the boundary, now inside, now outside, would be cut in slivers.
    model = start(MOULDED, "geodesic", 6, 8).model
    beyond = Extended(MOULDED).beyond
    u = model.parameters(4)
    for line in (*model.points(u)[[0, -1]], *np.swapaxes(model.points(u), 0, 1)[[0, -1]]):
        assert beyond(line).min() > 0.0


@pytest.mark.slow
def test_automatic_geodesic_models_start_from_geodesics():
    # Parameter lines of a translational surface have no twist, but a fit draws them in: 62 % of
    # this roof were covered.
    roof = FormulaSurface("u", "v", "-5e-5*u**2 - 3e-5*v**2", (-4e3, 4e3), (-6e3, 6e3))
    found = start(roof, "auto", 6, 6, kind="geodesic")
    assert found.method == "geodesic"
    assert found.overhangs


@pytest.mark.slow
def test_geodesics_of_a_cylinder_are_helices_and_rulings_fit():
    found = start(TUBE, "geodesic", 6, 8, (0.0, 0.0, 1.0), seed=None)
    points = found.model.points(found.model.parameters(2))
    # Geodesics across a horizontal section of a cylinder are its vertical lines.
    assert np.ptp(points[..., :2], axis=1).max() < 1.0


def test_network_measures_its_conjugacy():
    x = np.linspace(-3500.0, 3500.0, 9)
    grid = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    conjugate = Net(MOULDED.evaluate(*grid.T).point.reshape(9, 9, 3))
    assert np.degrees(np.abs(conjugacy_defect(conjugate, MOULDED)).max()) < 1e-3
    # Turned by 45 degrees on a paraboloid a, b: defect atan((a - b) / (a + b)) in the middle.
    turned = np.stack([grid[:, 0] - grid[:, 1], grid[:, 0] + grid[:, 1]], axis=1) / 2.0
    net = Net(MOULDED.evaluate(*turned.T).point.reshape(9, 9, 3))
    middle = conjugacy_defect(net, MOULDED, 1)[0]
    assert middle == pytest.approx(np.arctan(0.4 / 1.6), abs=1e-6)


def test_crossings_of_straight_families_are_exact():
    x = np.linspace(-1.0, 1.0, 21)
    rows = np.stack([np.stack([x, 0 * x + y, 0 * x], axis=1) for y in (-0.5, 0.1, 0.7)])
    columns = np.stack([np.stack([0.3 * x + c, x, 0 * x], axis=1) for c in (-0.4, 0.2, 5.0)])
    nodes = crossings(rows, columns)
    for i, y in enumerate((-0.5, 0.1, 0.7)):
        for j, c in enumerate((-0.4, 0.2)):
            assert np.allclose(nodes[i, j], [0.3 * y + c, y, 0.0], atol=1e-9)
    assert np.isnan(nodes[:, 2]).all()


def test_lean_is_ninety_degrees_along_an_asymptotic_border():
    # The hypar's straight borders are asymptotic lines; a dome's border needs little lean.
    hypar = FormulaSurface("u", "v", "1e-4*u*v", (-4e3, 4e3), (-4e3, 4e3))
    lean, _ = leans(iso_net(hypar)[0], hypar, 1.0)
    assert lean.min() > 89.9
    found = start(hypar, "iso", 8, 8)
    assert any("asymptotic" in n for n in found.notes)


def test_a_folded_start_is_named_by_strip_and_u():
    net, _ = iso_net(MOULDED)
    points = net.sampled(net.places(6), net.stations(8)).copy()
    points[[2, 3], 5] = points[[3, 2], 5]  # two edges cross at one station
    with pytest.raises(GeometryError, match=r"strip 2, u = 4\.\d+.*folds"):
        check_folds(model_through(points, False, False), MOULDED, "test")


def test_the_property_that_keeps_starts_off_is_named(shared_data):
    # Gauss's curvature of z = u^2 + v^3 has the sign of v: dome-like there, saddle-like here.
    mixed = FormulaSurface("u", "v", "0.1*u**2 + 0.02*v**3", (-4, 4), (-4, 4), scale=1000.0)
    words = hindrance(mixed)
    dome, saddle = (float(part.split(", ")[1]) for part in words.split("(")[1:3])
    assert words.startswith("it is dome-like near")
    assert dome > 0.0 > saddle
    # A ship's flat bottom with its bilge.
    words = hindrance(read_surface(shared_data / "surfaces" / "half-hull.step", faces=[1]))
    assert words.startswith("it is flat on 5")
    assert "bends with a radius of 1612" in words


@pytest.mark.parametrize(
    ("call", "words"),
    [
        ({"method": "isso"}, "expected one of"),
        ({"method": "iso", "stripes": 3}, "did you mean 'strips'"),
        ({"method": "iso", "direction": "w"}, "expected 'u' or 'v'"),
        ({"method": "iso", "strips": 10**6}, "ask for at most"),
        ({"method": "iso", "strips": 0}, "at least 1"),
        ({"method": "mesh"}, "no regular quad mesh"),
        ({"method": "network"}, "two families"),
        ({"method": "model"}, "previous model"),
    ],
)
def test_bad_requests_say_how_to_cure_them(call, words):
    with pytest.raises(InputError, match=words):
        start(DOME, **call)
