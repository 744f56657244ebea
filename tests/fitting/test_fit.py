"""Fits on small surfaces in closed form, judged by the measures that the fit does not know."""

from __future__ import annotations

import numpy as np
import pytest
from fit_helpers import iso_start, quadric

from fabgeo.errors import GeometryError, InputError
from fabgeo.fitting import FitOptions, fit
from fabgeo.strips.measures import measure

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
