"""Fits on small surfaces in closed form, judged by the measures that the fit does not know."""

from __future__ import annotations

import signal

import numpy as np
import pytest
from fit_helpers import Graph, SphereZone, iso_start, quadric, sphere_start

from fabgeo.errors import GeometryError, InputError
from fabgeo.fitting import FitOptions, fit
from fabgeo.fitting.held import Held, choose
from fabgeo.fitting.objectives.base import State
from fabgeo.fitting.objectives.points import closest_sites
from fabgeo.fitting.obstacle import obstacle
from fabgeo.fitting.quality import dense_sites, quality
from fabgeo.fitting.reference import Reference
from fabgeo.fitting.samples import Net
from fabgeo.fitting.starts import start
from fabgeo.fitting.stoppable import stoppable
from fabgeo.fitting.store import load_model, save_model
from fabgeo.strips.measures import measure
from fabgeo.surfaces.formula import FormulaSurface
from fabgeo.surfaces.trace_extension import Extended

DOME, SADDLE = (-0.5e-4, -1.5e-4), (0.5e-4, -1.0e-4)


@pytest.mark.parametrize("curvatures", [DOME, SADDLE])
def test_reaches_the_sag_limit_within_the_boundary(curvatures):
    surface = quadric(*curvatures)
    result = fit(surface, iso_start(surface, 8, 12))
    found = measure(result.model, surface)
    assert result.status == "converged"
    assert found.deviation_over_sag_limit <= 1.05
    assert found.twist_deg.value <= 0.002
    assert not found.folds
    # Held to within half the sag of a chord, where all strips stand off by as much.
    assert found.boundary_max <= 1.05 * found.sag_limit.value


@pytest.mark.parametrize("kind", ["conical", "circular"])
def test_principal_models_reach_their_property(kind):
    # The parameter lines of a translation surface's own principal sections: nearly principal.
    surface = quadric(*SADDLE, half=(4000.0, 4000.0))
    result = fit(surface, iso_start(surface, 8, 12), kind)
    found = measure(result.model, surface)
    assert found.twist_deg.value <= 0.005
    residual = found.conicality if kind == "conical" else found.circularity
    assert residual is not None
    assert residual.value <= 1e-4


def test_the_unit_of_length_does_not_matter():
    small, large = quadric(-0.5, -1.5, (0.5, 0.5)), quadric(-0.5e-5, -1.5e-5, (5e4, 5e4))
    results = [fit(s, iso_start(s, 6, 8)) for s in (small, large)]
    np.testing.assert_allclose(
        results[0].model.control * 1e5, results[1].model.control, rtol=0, atol=1e-3
    )


def test_interrupting_keeps_the_best_and_a_fit_resumes_from_it():
    surface = quadric(*DOME)
    heard = []
    part = fit(
        surface, iso_start(surface, 6, 8), listener=lambda p: heard.append(p) or len(heard) < 2
    )
    assert part.status == "interrupted"
    assert len(heard) == 2
    rest = fit(surface, part.model)
    assert rest.status == "converged"
    assert measure(rest.model).twist_deg.value < measure(part.model).twist_deg.value


def test_an_interrupt_ends_a_fit_with_its_best_which_a_file_takes_up(tmp_path):
    surface = quadric(*DOME)
    begun, handler, heard = iso_start(surface, 6, 8), signal.getsignal(signal.SIGINT), []

    def interrupt(progress):
        heard.append(progress)
        if len(heard) == 3:
            signal.raise_signal(signal.SIGINT)

    with stoppable(interrupt) as listener:
        part = fit(surface, begun, listener=listener)
    assert signal.getsignal(signal.SIGINT) is handler
    assert (part.status, len(heard)) == ("interrupted", 3)
    save_model(tmp_path / "strips.json", part.model)
    rest = fit(surface, load_model(tmp_path / "strips.json"))
    assert rest.status == "converged"
    assert rest.history[0]["cost"] <= part.history[-1]["cost"]
    with stoppable():
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)


def test_a_model_is_gone_on_with_at_the_weight_reached():
    surface = quadric(*SADDLE)
    first = fit(surface, iso_start(surface, 6, 8), options=FitOptions(twist_limit_deg=0.02))
    weight = first.history[-1]["developability"]
    assert weight > 1.0
    again = fit(surface, first.model)
    assert again.history[0]["developability"] == weight
    assert again.statistics["twist_max_deg"] <= 0.002
    # On another surface the model is no solution, and its weights would only hold it back.
    other = quadric(0.8e-4, -1.0e-4)
    assert fit(other, first.model).history[0]["developability"] == 1.0


def test_edges_along_asymptotic_directions_are_named_inside():
    # z = k x y again, with nothing held: edges y = const are asymptotic lines everywhere.
    k = 4e-5
    surface = Graph(
        lambda x, y: k * x * y,
        lambda x, y: (k * y, k * x),
        lambda x, y: (0 * x, k + 0 * x, 0 * x),
    )
    start = iso_start(surface, 6, 8)
    net, length = Net.of(start), 1000.0
    state = State(net, np.array(start.control) / length, Reference(surface, length))
    figures = quality(state, dense_sites(net), "general")
    place = figures.twist_strip, figures.twist_u
    words = obstacle(state, Held(), place)
    assert "principal" not in obstacle(state, Held(), place, ["principal"])  # tried already
    assert words.startswith("strip ")
    assert "u = " in words
    assert "edges run along an asymptotic direction" in words
    assert "start 'principal'" in words


def test_a_border_that_overhangs_by_little_is_not_drawn_to_the_boundary():
    surface = FormulaSurface("u", "v", "-0.5e-4*u**2 - 0.3e-4*v**2", (-4e3, 4e3), (-4e3, 4e3))
    # 150 mm are a seventh of a strip's width: near enough to be held, were it inside.
    start = iso_start(quadric(-1e-4, -0.6e-4, half=(4150.0, 4150.0)), 8, 8)
    control = np.array(start.control) / 1037.5
    near = choose(Net.of(start), control, Reference(surface, 1037.5), "auto", "general")
    beyond = choose(Net.of(start), control, Reference(Extended(surface), 1037.5), "auto", "general")
    assert len(near.ends) == len(near.edges) == 2
    assert not beyond.ends
    assert not beyond.edges


def test_a_folded_start_is_named():
    surface = quadric(*DOME)
    start = iso_start(surface, 6, 8)
    control = np.array(start.control)
    control[[2, 3], 5:8] = control[[3, 2], 5:8]
    with pytest.raises(GeometryError, match=r"strip [1-3] folds over at u = "):
        fit(surface, start.with_control(control))


def test_unknown_kinds_and_boundaries_are_refused():
    surface = quadric(*DOME)
    start = iso_start(surface, 4, 4)
    with pytest.raises(InputError, match="kind"):
        fit(surface, start, "round")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="boundary"):
        FitOptions(boundary="edge")  # type: ignore[arg-type]


@pytest.mark.parametrize("around", [True, False])
def test_tubes_close_in_both_directions(around):
    surface = SphereZone()
    start = sphere_start(surface, *((6, 16) if around else (16, 8)), around)
    result = fit(surface, start)
    found = measure(result.model, surface)
    assert (result.model.closed_u, result.model.closed_i) == (around, not around)
    assert result.status == "converged"
    assert found.twist_deg.value <= 0.002
    assert found.deviation_over_sag_limit <= 1.05


def test_subdividing_moves_nothing():
    for closed in (False, True):
        start = sphere_start(SphereZone(), 6, 8, not closed)
        fine = start.divided(2)
        assert fine.strips == 2 * start.strips
        u = np.linspace(0.0, start.segments, 7)
        np.testing.assert_array_equal(fine.points(u)[::2], start.points(u))
        a, b = start.pairs(start.points(u))
        np.testing.assert_allclose(fine.points(u)[1::2], (a + b) / 2.0, atol=1e-9)


def test_coarse_levels_lead_to_the_same_model():
    surface = quadric(*DOME)
    start = iso_start(surface, 6, 16)
    direct = fit(surface, start, options=FitOptions(levels=0))
    coarse = fit(surface, start, options=FitOptions(levels=1))
    assert coarse.history[0]["segments"] == 8
    assert coarse.model.segments == 16
    sag = measure(direct.model, surface).sag_limit.value
    u = np.linspace(0.0, 16.0, 33)
    distance = np.linalg.norm(direct.model.points(u) - coarse.model.points(u), axis=-1)
    normal = np.abs(direct.model.points(u)[..., 2] - coarse.model.points(u)[..., 2])
    assert normal.max() < 2.0 * sag
    assert np.sqrt(np.mean(distance**2)) < 20.0 * sag
    assert measure(coarse.model).twist_deg.value <= 0.002


def test_strips_taken_together_lead_to_the_same_limit():
    surface = quadric(*DOME)
    result = fit(surface, iso_start(surface, 8, 8), options=FitOptions(across=1))
    found = measure(result.model, surface)
    assert result.model.strips == 8
    assert found.twist_deg.value <= 0.002
    assert found.deviation_over_sag_limit <= 1.05
    with pytest.raises(InputError, match="7 strips"):
        fit(surface, iso_start(surface, 7, 8), options=FitOptions(across=1))


def test_mounting_points_are_met():
    surface = quadric(*DOME)
    start = iso_start(surface, 6, 8)
    edge = start.points(np.array([2.0, 5.5]))[[2, 4], [0, 1]]
    points = edge + np.array([[30.0, 200.0, 0.0], [0.0, -150.0, 0.0]])
    points[:, 2] = surface.lift(*points[:, :2].T)[:, 2]
    result = fit(surface, start, options=FitOptions(points=points))

    def gap(model):
        i, u = closest_sites(Net.of(model), np.array(model.control), points)
        return np.linalg.norm(model.points(u)[i, [0, 1]] - points, axis=1)

    assert np.all(gap(start) > 100.0)
    assert np.all(gap(result.model) < 5.0)
    assert measure(result.model, surface).deviation_over_sag_limit <= 2.0


def test_a_boundary_along_an_asymptotic_direction_is_named():
    # z = k x y: the lines x = const and y = const are its asymptotic lines.
    k = 4e-5
    surface = Graph(
        lambda x, y: k * x * y,
        lambda x, y: (k * y, k * x),
        lambda x, y: (0 * x, k + 0 * x, 0 * x),
    )
    result = fit(surface, iso_start(surface, 6, 8), options=FitOptions(stages=2, iterations=4))
    assert "asymptotic direction" in result.reason
    assert "end u = 0" in result.reason


def test_geodesic_models_have_opposite_geodesic_curvatures():
    surface = quadric(*DOME)
    options = FitOptions(twist_limit_deg=0.01, kind_limit_deg=0.01)
    result = fit(surface, iso_start(surface, 6, 10), "geodesic", options)
    found = measure(result.model, surface)
    assert result.status == "converged"
    assert found.geodesic is not None
    assert found.geodesic.value <= np.radians(0.01)
    assert found.twist_deg.value <= 0.012


@pytest.mark.slow
def test_a_conical_model_covers_a_roof_askew_to_its_principal_lines():
    roof = FormulaSurface(
        "u", "v", "3 - 0.03*u**2 - 0.05*v**2 + 0.004*u*v", (-6.0, 6.0), (-5.0, 5.0), scale=1000.0
    )
    begun = start(roof, kind="conical")
    assert begun.method == "principal"
    options = FitOptions(twist_limit_deg=0.004, kind_limit_deg=0.004)
    found = measure(fit(begun.reference, begun.model, "conical", options).model, roof)
    assert found.covered_share is not None
    assert found.covered_share > 0.995
    assert found.twist_deg.value < 0.005
    assert found.deviation_over_sag_limit is not None
    assert found.deviation_over_sag_limit < 1.2
