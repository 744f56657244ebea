"""Every formula on exact models to 1e-9 of their size, and 4th-order on their interpolants."""

from __future__ import annotations

import numpy as np
import pytest

from fabgeo.arrays import cross, dot, unit
from fabgeo.strips import exact, measures
from fabgeo.strips.axes import axes, circular_normals, conical_axes
from fabgeo.strips.circular import circular_curves, conical_curves, to_circular, to_conical
from fabgeo.strips.flanges import axis_strip, envelope, trajectory
from fabgeo.strips.frames import EdgeCurves, frames

ANGLES = np.linspace(0.0, 1.2, 9)
PROFILE = np.stack([4000 * np.cos(ANGLES), 4000 * np.sin(ANGLES)], axis=1)
SIZE = 10_000.0

CYLINDER = exact.cylinder(9000.0, 8000.0, ANGLES)
CONE = exact.cone(0.5, np.linspace(6000.0, 14000.0, 7))
REVOLUTION = exact.revolution(8000 + 5000 * np.cos(ANGLES), 5000 * np.sin(ANGLES))
MERIDIANS = exact.meridians(8000.0, 5000.0, ANGLES, -0.6, 0.9)
MOULDING = exact.moulding(9000.0, 900.0, PROFILE)
MOEBIUS = exact.inverted(MOULDING, np.array([-6000.0, 2000.0, -5000.0]), 17000.0)
CYCLIDE = exact.dupin_cyclide()
GREAT_CIRCLES = exact.spherical_geodesics(10_000.0, 800.0, 5)


def conical_of(model: exact.ExactModel) -> exact.ExactModel:
    made = conical_curves(model)
    return exact.ExactModel(made.curves, made.edges, model.segments, kind="conical")


GENERIC_CONICAL = conical_of(MOEBIUS)  # neither rulings nor edges are symmetric
CONICAL = [CYLINDER, CONE, REVOLUTION, MERIDIANS, MOULDING, GENERIC_CONICAL]
CIRCULAR = [REVOLUTION, MERIDIANS, MOULDING, MOEBIUS, CYCLIDE]
U = np.linspace(0.3, 5.7, 23)


@pytest.mark.parametrize("model", [*CONICAL, *CIRCULAR], ids=lambda m: m.name)
def test_strips_are_developable(model: exact.ExactModel) -> None:
    f = frames(model, U)
    assert measures.twist(f).max() < 1e-9
    assert measures.developability(f).max() < 1e-9 * SIZE
    assert measures.folds(f) == ()


@pytest.mark.parametrize("model", CIRCULAR, ids=lambda m: m.name)
def test_circular_residual_vanishes(model: exact.ExactModel) -> None:
    assert measures.circularity(frames(model, U)).max() < 1e-9


@pytest.mark.parametrize("model", CONICAL, ids=lambda m: m.name)
def test_conical_residual_vanishes(model: exact.ExactModel) -> None:
    assert measures.conicality(frames(model, U)).max() < 1e-9


def test_great_circles_are_geodesic() -> None:
    f = frames(GREAT_CIRCLES, U)
    assert measures.geodesic(GREAT_CIRCLES, f).max() < 1e-9


@pytest.mark.parametrize("model", CONICAL, ids=lambda m: m.name)
def test_axes_keep_rulings_and_planes_at_distance(model: exact.ExactModel) -> None:
    field = conical_axes(model)
    f, n = frames(model, U), field(U)
    assert field.mismatch < 1e-9
    for side in f.sides(n):
        across = side - dot(side, f.e)[..., None] * f.e
        assert np.abs(dot(side, f.m) - 1.0).max() < 1e-9  # planes
        assert np.abs(np.linalg.norm(across, axis=-1) - 1.0).max() < 1e-9  # rulings
    offset = f.p - 250.0 * n
    assert np.abs(cross(unit(np.diff(offset, axis=0)), f.e)).max() < 1e-9
    for i in range(model.edges):
        assert np.abs(field.single(i)(U) - n[i]).max() < 1e-12


@pytest.mark.parametrize("model", CONICAL, ids=lambda m: m.name)
def test_axis_strips_are_developable_at_every_edge(model: exact.ExactModel) -> None:
    """n' is parallel to p', at the first and last edge too."""
    field = conical_axes(model)
    h = 1e-3
    weights = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * h)
    dn = sum(w * field(U + k * h) for w, k in zip(weights, (-2, -1, 1, 2), strict=True))
    f = frames(model, U)
    assert np.abs(cross(dn, f.t)).max() < 1e-8 * max(1.0, np.abs(dn).max())


@pytest.mark.parametrize("model", CIRCULAR, ids=lambda m: m.name)
def test_circular_normals(model: exact.ExactModel) -> None:
    field = circular_normals(model)
    assert field.mismatch < 1e-8
    f, n = frames(model, U), field(U)
    assert np.abs(np.linalg.norm(n, axis=-1) - 1.0).max() < 1e-12
    # The offset strips stay developable: three vectors e, t_i, t_{i+1} and parallel edges' normals
    offset = exact.ExactModel(
        lambda u: model.points(u) - 300.0 * field(u), model.edges, model.segments
    )
    g = frames(offset, U)
    assert np.abs(cross(g.t, f.t)).max() < 1e-7  # n' parallel to p'
    assert measures.twist(g).max() < 1e-7
    assert np.abs(np.linalg.norm(g.p - f.p, axis=-1) - 300.0).max() < 1e-9 * SIZE


def test_conical_to_circular_and_back() -> None:
    made = circular_curves(GENERIC_CONICAL)
    circular = exact.ExactModel(made.curves, made.edges, GENERIC_CONICAL.segments)
    f = frames(circular, U)
    assert measures.circularity(f).max() < 1e-7
    assert measures.twist(f).max() < 1e-7
    p = GENERIC_CONICAL.points(U)
    q = circular.points(U)  # q_{i-1} and q_i lie on one sphere about p_i
    left = np.linalg.norm(q[:-1] - p[1:-1], axis=-1)
    right = np.linalg.norm(q[1:] - p[1:-1], axis=-1)
    assert np.abs(left - right).max() < 1e-9 * SIZE


def test_conversion_does_not_add_up_defects() -> None:
    """A model that is only nearly conical gives one as nearly circular, and comes back."""
    near = GENERIC_CONICAL.interpolant(2)
    defect = measures.measure(near, per_segment=4).conicality
    assert defect is not None
    made = to_circular(near)
    assert measures.measure(made, per_segment=4).circularity.value < 1.2 * defect.value
    told = made.info["converted"]
    assert told["within"]
    assert told["error"] <= told["tolerance"]
    assert not to_circular(near, 1e-12).info["converted"]["within"]  # halving ends before
    again = to_conical(made)
    u = np.linspace(2.0, near.segments - 2.0, 41)
    gap = again.points(u * again.segments / near.segments) - near.points(u)[1:-1]
    assert np.linalg.norm(gap, axis=-1).max() < 10.0 * defect.value * SIZE


@pytest.mark.parametrize("model", [*CONICAL, MOEBIUS], ids=lambda m: m.name)
def test_trajectory_flanges(model: exact.ExactModel) -> None:
    """c' . n = 0; c + v b is developable and orthogonal to the axis strip; depth is constant."""
    field = axes(model)
    for edge in (0, model.edges // 2, model.edges - 1):
        strip = axis_strip(model, field, edge)
        s = trajectory(strip)

        def curve(u, level, strip=strip, s=s):
            return strip.at(u, s(u) + level)

        h = 0.02
        steps = (-3, -2, -1, 1, 2, 3)
        weights = np.array([-1, 9, -45, 45, -9, 1]) / (60 * h)
        dc = sum(w * curve(U + k * h, -200.0) for w, k in zip(weights, steps, strict=True))
        db = sum(w * strip.frame(U + k * h)[2] for w, k in zip(weights, steps, strict=True))
        _, n, b = strip.frame(U)
        c = unit(dc)
        assert np.abs(dot(c, n)).max() < 1e-7
        assert np.abs(dot(db, n)).max() < 1e-7  # ruling turns within the flange's plane
        depth = np.linalg.norm(curve(U, -50.0) - curve(U, -350.0), axis=-1)
        assert np.abs(depth - 300.0).max() < 1e-9 * SIZE
        assert np.abs(dot(b, n)).max() < 1e-12


def test_envelope_flange_is_developable_and_orthogonal() -> None:
    field = axes(GENERIC_CONICAL)
    strip = axis_strip(GENERIC_CONICAL, field, 3)

    def edges(u):
        c, r = envelope(strip, -200.0, u, "beam")
        return np.stack([c - 80.0 * r, c + 80.0 * r])

    flange = exact.ExactModel(edges, 2, GENERIC_CONICAL.segments)
    f = frames(flange, U)
    assert measures.twist(f).max() < 1e-6
    _, n, b = strip.frame(U)
    t = strip.frame(U)[0]
    web = unit(cross(t, n))
    assert np.abs(dot(f.m[0], web)).max() < 1e-6
    assert np.abs(dot(edges(U)[1] - edges(U)[0], b) - 160.0).max() < 1e-6


ORDERS = [REVOLUTION, MERIDIANS, MOULDING, GENERIC_CONICAL]


@pytest.mark.parametrize("model", ORDERS, ids=lambda m: m.name)
def test_interpolants_converge_with_the_fourth_power(model: exact.ExactModel) -> None:
    """Halving the knot spacing divides the distance from the exact edges by 16."""
    u = np.linspace(2.1, 9.9, 61)
    errors = []
    for refine in (1, 2, 4):
        made = model.interpolant(refine)
        errors.append(np.abs(made.points(u * refine) - model.points(u)).max())
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert orders.min() > 3.5 or errors[-1] < 1e-9 * SIZE


@pytest.mark.parametrize("model", ORDERS, ids=lambda m: m.name)
def test_axes_of_interpolants_converge(model: exact.ExactModel) -> None:
    """At knots the axes are as good as the spline's tangents: fourth order."""
    u = np.arange(2.0, 10.0)
    true = conical_axes(model)(u)[1:-1]
    errors = []
    for refine in (1, 2, 4):
        made = conical_axes(model.interpolant(refine))(u * refine)[1:-1]
        errors.append(np.abs(made - true).max())
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert orders.min() > 3.4 or errors[-1] < 1e-10


def figures(model: EdgeCurves, u: np.ndarray) -> dict[str, np.ndarray]:
    """Every measure along a model, lengths over its size; those of second derivatives last."""
    f = frames(model, u)
    first, second = measures.bending_radius(model, f)
    return {
        "twist": measures.twist(f),
        "developability": measures.developability(f) / SIZE,
        "conicality": measures.conicality(f),
        "circularity": measures.circularity(f),
        "kink": measures.kink_across(f),
        "width": f.length / SIZE,
        "regression": measures.regression(f),
        "geodesic": measures.geodesic(model, f),
        "bending": f.length / np.stack([first, second]),
    }


@pytest.mark.parametrize("model", [*ORDERS, MOEBIUS, CYCLIDE, GREAT_CIRCLES], ids=lambda m: m.name)
def test_measures_of_interpolants_converge(model: exact.ExactModel) -> None:
    """At knots: fourth order; the second derivatives of a cubic spline are of second order."""
    u = np.arange(2.0, 11.0)
    true = figures(model, u)
    found = [figures(model.interpolant(refine), u * refine) for refine in (2, 4)]
    for name, values in true.items():
        coarse, fine = (float(np.abs(at[name] - values).max()) for at in found)
        order = 1.9 if name in ("geodesic", "bending") else 3.7
        assert fine < 2e-9 or coarse > 2.0**order * fine, name


def test_a_kink_along_an_edge_is_found() -> None:
    """Polygons that turn by 0.1 at u = 2: exact curves may, splines are smooth."""

    def curves(u: np.ndarray) -> np.ndarray:
        past = np.maximum(u - 2.0, 0.0)
        x, y = np.minimum(u, 2.0) + past * np.cos(0.1), past * np.sin(0.1)
        return np.stack([np.stack([x, y, 0.0 * u + z], axis=-1) for z in (0.0, 1.0)])

    class Bent(exact.ExactModel):
        def points(self, u, derivative=0):
            u = np.atleast_1d(np.asarray(u, dtype=np.float64))
            h = 1e-10  # narrower than the look to both sides of a knot
            return curves(u) if derivative == 0 else (curves(u + h) - curves(u - h)) / (2.0 * h)

    found = measures.kink_along(Bent(curves, 2, 4))
    assert found.u == 2.0
    assert found.value == pytest.approx(np.degrees(0.1), rel=1e-4)


def test_bending_radius_of_cones_and_cylinders() -> None:
    """On parallel circles the radius is r / cos(slope of the cone); striction at the apex."""
    f = frames(CONE, U)
    first, second = measures.bending_radius(CONE, f)
    d = np.linspace(6000.0, 14000.0, 7)
    assert np.allclose(np.abs(first), (d[:-1] * np.tan(0.5))[:, None], rtol=1e-8)
    assert np.allclose(np.abs(second), (d[1:] * np.tan(0.5))[:, None], rtol=1e-8)
    assert np.allclose(measures.regression(f), (d[:-1] / d[1:])[:, None], rtol=1e-9)


def test_tangent_developable_regression_and_radius() -> None:
    """The striction curve is the helix: speeds across the ruling grow with the distance to it."""
    model = exact.tangent_developable(500.0, 3000.0, 2000.0, 1000.0)
    f = frames(model, U)
    assert measures.twist(f).max() < 1e-9
    assert np.allclose(measures.regression(f), 2000.0 / 3000.0, rtol=1e-9)
    kappa, tau = 3000.0 / (3000.0**2 + 500.0**2), 500.0 / (3000.0**2 + 500.0**2)
    first, second = measures.bending_radius(model, f)
    assert np.allclose(np.abs(first), 2000.0 * kappa / tau, rtol=1e-7)
    assert np.allclose(np.abs(second), 3000.0 * kappa / tau, rtol=1e-7)
