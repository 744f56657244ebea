"""Models that overhang the boundary: what counts there, and when a border is left free."""

from __future__ import annotations

import numpy as np
import pytest
from fit_helpers import iso_start, quadric

from fabgeo.fitting import FitOptions, fit
from fabgeo.fitting.held import Held
from fabgeo.fitting.level import Level
from fabgeo.fitting.reference import Reference
from fabgeo.fitting.samples import Net
from fabgeo.fitting.starts import start
from fabgeo.strips.measures import measure
from fabgeo.surfaces.formula import FormulaSurface
from fabgeo.surfaces.trace_extension import Extended

DOME = (-0.5e-4, -1.5e-4)


def test_proximity_counts_on_the_surface_and_little_where_a_model_overhangs():
    surface = quadric(*DOME, half=(3000.0, 3000.0))
    begun = iso_start(quadric(*DOME, half=(5000.0, 3000.0)), 6, 10)
    flat = FormulaSurface("u", "v", "0*u", (-3e3, 3e3), (-3e3, 3e3))

    def importances(reference, control):
        options, net = FitOptions(), Net.of(begun)
        level = Level(net, Reference(reference, 1000.0), "geodesic", options, Held())
        terms = level.problem(control, control, 1.0, 0.0).objectives
        term = next(t for t in terms if t.name == "proximity of edges")
        x = term.sites.evaluate(control)[..., 0]
        return np.maximum(np.abs(x) - 3.0, 0.0), np.broadcast_to(term.importance, x.shape)

    control = np.array(begun.control) / 1000.0
    assert np.all(importances(surface, control)[1] == 1.0)
    beyond, counts = importances(Extended(flat), control * [1.0, 1.0, 0.0])
    assert beyond.max() > 1.5
    assert np.all(counts[beyond <= 0.5] == 1.0)
    np.testing.assert_allclose(
        counts, (1.0 + np.maximum(2.0 * beyond - 1.0, 0.0) ** 2) ** -2.0, rtol=1e-6
    )


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["conical", "circular"])
def test_a_cap_in_a_square_turned_against_its_principal_lines_is_covered(kind):
    # Half of what covers it overhangs; drawn to the continuation there, outer strips pinch.
    x, y = "(u*cos(0.4) + v*sin(0.4))", "(v*cos(0.4) - u*sin(0.4))"
    height = f"5*sqrt(1 - ({x}/9)**2 - ({y}/7)**2)"
    cap = FormulaSurface("u", "v", height, (-4.0, 4.0), (-4.0, 4.0), scale=1000.0)
    begun = start(cap, strips=16, segments=16, kind=kind)
    result = fit(begun.reference, begun.model, kind)
    found = measure(result.model, cap)
    assert result.status == "converged"
    assert not found.folds
    assert found.twist_deg.value <= 0.005
    assert found.deviation_over_sag_limit is not None
    assert found.deviation_over_sag_limit <= 1.25
    assert found.width_min is not None
    assert found.width_max is not None
    assert found.width_min.value > 0.4 * found.width_max.value


@pytest.mark.slow
def test_a_border_that_no_strip_can_follow_is_left_free_unless_it_is_to_be_held():
    # Sides of a square turned against the principal lines meet in directions not conjugate.
    dome = FormulaSurface(
        "u", "v", "-0.025*u**2 - 0.075*v**2 + 0.03*u*v", (-5.0, 5.0), (-5.0, 5.0), scale=1000.0
    )
    free, held = (start(dome, strips=16, segments=24, held=held) for held in (False, True))
    assert free.overhangs
    assert not held.overhangs
    assert "where the boundary holds it" in free.why
    near, far = (measure(fit(s.reference, s.model).model, dome) for s in (free, held))
    assert near.twist_deg.value <= 0.002
    assert near.deviation_over_sag_limit <= 1.05
    assert near.deviation_max.value < 0.6 * far.deviation_max.value
    assert near.covered_share == 1.0
    # Where the border can be followed, it is.
    straight = FormulaSurface(
        "u", "v", "-0.025*u**2 - 0.075*v**2", (-5.0, 5.0), (-5.0, 5.0), scale=1000.0
    )
    assert not start(straight, strips=16, segments=24).overhangs


@pytest.mark.slow
def test_a_general_model_lets_go_of_a_continuation_that_twists_it():
    # The lines of a monkey saddle leave its square far: no strips follow what is continued there.
    monkey = FormulaSurface(
        "u", "v", "(u**3 - 3*u*v**2)/60", (-5.0, 5.0), (-5.0, 5.0), scale=1000.0
    )
    begun = start(monkey, "principal", 10, 20)
    assert begun.overhangs
    held = fit(begun.reference, begun.model, options=FitOptions(continuation="followed"))
    assert held.status == "limited"
    let_go = fit(begun.reference, begun.model)
    assert let_go.status == "converged"
    found = measure(let_go.model, monkey)
    assert found.twist_deg.value <= 0.003
    assert found.deviation_over_sag_limit is not None
    assert found.deviation_over_sag_limit <= 1.1
    assert not found.folds
    # It is gone on with as it was left.
    again = fit(begun.reference, let_go.model)
    assert again.status == "converged"
    assert again.history[0]["developability"] >= let_go.history[-1]["developability"]


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "method"), [("conical", "principal"), ("geodesic", "geodesic")])
def test_the_largest_deviation_of_models_of_a_kind_is_made_small(kind, method):
    height = "0.15*v**2 - 0.015*u**2"
    saddle = FormulaSurface("u", "v", height, (-5.0, 5.0), (-5.0, 5.0), scale=1000.0)
    begun = start(saddle, method, 16, 24)
    rms, most = (
        fit(begun.reference, begun.model, kind, FitOptions(minimise=m)) for m in ("rms", "max")
    )
    least, far = (measure(r.model, saddle) for r in (most, rms))
    assert most.status == "converged"
    assert least.deviation_max.value < 0.96 * far.deviation_max.value
    assert least.deviation_over_sag_limit is not None
    assert least.deviation_over_sag_limit <= 1.05
    assert not least.folds


@pytest.mark.slow
def test_a_fit_that_ends_near_its_limits_is_made_again_and_reaches_them():
    # Principal curvatures of +-0.3 per m: slopes of 1.5 at the sides of the square.
    height = "0.15*v**2 - 0.15*u**2"
    saddle = FormulaSurface("u", "v", height, (-5.0, 5.0), (-5.0, 5.0), scale=1000.0)
    begun = start(saddle, "geodesic", 16, 24)
    result = fit(begun.reference, begun.model, "geodesic")
    found = measure(result.model, saddle)
    assert result.status == "converged"
    assert found.twist_deg.value <= 0.003
    assert found.geodesic is not None
    assert np.degrees(found.geodesic.value) <= 0.01
    assert found.deviation_over_sag_limit is not None
    assert found.deviation_over_sag_limit <= 1.1
    assert not found.folds
