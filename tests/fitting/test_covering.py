"""Geodesic coverings and planks: closed forms of unfolding, and the law of opposite congruence."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import KDTree

from fabgeo.errors import InputError
from fabgeo.fitting.covering import cover, seam_points
from fabgeo.fitting.fit import fit
from fabgeo.fitting.options import FitOptions
from fabgeo.fitting.planks import developed, opposite_congruence, planks
from fabgeo.fitting.starts import start
from fabgeo.fitting.starts.net import model_through
from fabgeo.fitting.starts.quality import quality
from fabgeo.strips.measures import measure
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.formula import FormulaSurface
from fabgeo.surfaces.trace_extension import Extended

BOWL = FormulaSurface("u", "v", "-2e-5*u**2 - 1e-5*v**2", (-5e3, 5e3), (-3e3, 3e3))
DEEP = FormulaSurface("u", "v", "1.5e-4*(v**2 - u**2)", (-5e3, 5e3), (-5e3, 5e3))


def apart(one: StripModel, other: StripModel) -> float:
    """How far the last edge of a model is from the first of the next, within DEEP's domain."""
    u = np.linspace(0.0, one.segments, 200)
    w = np.linspace(0.0, other.segments, 20001)
    points = one.edge(one.strips, u)
    inside = np.abs(points[:, :2]).max(axis=1) < 4.5e3
    return float(KDTree(other.edge(0, w)).query(points[inside])[0].max())


def cone_strips():
    """Three strips of a cone of revolution: rulings along its generators."""
    u, r = np.linspace(0.0, 1.2, 25), np.array([4.0, 5.0, 6.0, 7.0])
    rows = [np.stack([x * np.cos(u), x * np.sin(u), 0.75 * x + 0 * u], axis=1) for x in r]
    return model_through(np.stack(rows), False, False)


def test_a_cone_develops_to_circular_arcs():
    flat = developed(cone_strips(), 0)
    # Slant lengths 4 * 1.25 and 5 * 1.25; the sector opens by 1.2 / 1.25.
    chord = np.linalg.norm(flat[:, -1] - flat[:, 0], axis=1)
    assert chord == pytest.approx(2.0 * 1.25 * np.array([4.0, 5.0]) * np.sin(0.48), rel=1e-6)
    assert np.linalg.norm(flat[1] - flat[0], axis=1) == pytest.approx(1.25, abs=1e-6)


def test_plank_of_a_flat_strip_is_its_rectangle():
    x = np.linspace(0.0, 9.0, 10)
    rows = [np.stack([x, 0 * x + y, 0 * x], axis=1) for y in (0.0, 0.5, 1.0)]
    found = planks(model_through(np.stack(rows), False, False))
    assert [(p.length, p.width) for p in found] == [pytest.approx((9.0, 0.5))] * 2
    assert max(p.bow for p in found) < 1e-9


def test_strips_of_one_developable_are_congruent_but_not_oppositely():
    # On a cone, both strips develop the common circle with the same curvature: mirror images
    # differ by twice the arc's rise. Geodesic edges differ by nothing.
    defect = opposite_congruence(cone_strips())
    arc, radius = 1.2 * 5.0, 6.25
    rise = radius * (1.0 - np.cos(arc / radius / 2.0))
    assert defect[0] == pytest.approx(2.0 * rise / arc, rel=0.5)
    w = np.linspace(0.0, 3.0, 21)
    rows = [np.stack([np.cos(s) + 0 * w, np.sin(s) + 0 * w, w], axis=1) for s in (0, 0.2, 0.5)]
    assert opposite_congruence(model_through(np.stack(rows), False, False)).max() < 1e-9


@pytest.mark.slow
def test_five_models_cover_an_interior_with_planks_of_one_width():
    found = cover(BOWL, 5, 4)
    assert len(found.models) == 5
    assert found.coverage == 1.0
    assert min(low for low, _ in found.widths) > 0.95
    assert max(high for _, high in found.widths) < 1.05
    for model in found.models:
        points = seam_points(model, Extended(BOWL))
        result = fit(Extended(BOWL), model, "geodesic", FitOptions(points=points))
        assert result.status == "converged"
        assert opposite_congruence(result.model).max() < 1e-4
        told = measure(result.model)
        assert told.geodesic is not None
        assert np.degrees(told.geodesic.value) < 0.01
        assert told.twist_deg.value < 0.02
        assert max(plank.bow for plank in planks(result.model)) < 1.0


@pytest.mark.slow
def test_models_side_by_side_follow_a_saddle_that_one_alone_cannot():
    # Curvatures of 0.3 per m: conjugate rulings between geodesics spread more than twofold.
    fitted = []
    for number in (1, 2):
        begun = start(DEEP, "geodesic", 4, 24, part=(number, 5))
        options = FitOptions(points=seam_points(begun.model, begun.reference))
        result = fit(begun.reference, begun.model, "geodesic", options)
        assert result.status == "converged"
        assert opposite_congruence(result.model).max() < 1e-5
        fitted.append(result.model)
    assert apart(*fitted) < 10.0  # strips are a metre wide


@pytest.mark.slow
def test_one_model_that_cannot_follow_says_that_several_can():
    begun = start(DEEP, "geodesic", 16, 16)
    result = fit(begun.reference, begun.model, "geodesic", FitOptions(refinements=0))
    assert result.status == "limited"
    assert "cover the surface by several models side by side" in result.reason
    assert "principal" not in result.reason


def test_rulings_between_geodesics_end_where_conjugate_ones_lead():
    free = start(DEEP, "geodesic", 4, 16, part=(1, 5))
    held = start(DEEP, "geodesic", 4, 16, part=(1, 5), ends="held")
    twist = [quality(s.model, Extended(DEEP), 1).twist_rms for s in (free, held)]
    assert twist[0] < 0.5 * twist[1]


def test_neighbouring_models_start_from_one_seam():
    one, other = (start(DEEP, "geodesic", 2, 12, part=(k, 3)).model for k in (1, 2))
    assert apart(one, other) < 5.0
    with pytest.raises(InputError, match="one from 1 to 3"):
        start(DEEP, "geodesic", 2, 12, part=(4, 3))


def test_outermost_models_go_on_beyond_the_boundary_and_no_others_do():
    for number, outer in ((1, (0,)), (2, ()), (3, (-1,))):
        edges = start(BOWL, "geodesic", 3, 12, part=(number, 3)).model.points(np.arange(13.0))
        for k in (0, -1):
            within = np.abs(edges[k, :, 0]) < 5e3
            beyond = np.abs(edges[k, within, 1]) > 3e3
            assert beyond.all() if k in outer else not beyond.any()


def test_seams_lie_where_free_edges_of_a_cylinder_do():
    """Chords of a circle are as far off it at their ends as in their middles, on the other side."""
    radius, angle = 7.0, np.array([-0.3, 0.0, 0.3])
    w = np.linspace(0.0, 3.0, 13)
    rows = [
        np.stack([radius * np.sin(s) + 0 * w, w, radius * np.cos(s) + 0 * w], axis=1) for s in angle
    ]
    model = model_through(np.stack(rows), False, False)
    tube = FormulaSurface("7*sin(u)", "v", "7*cos(u)", (-1.0, 1.0), (-1.0, 4.0))
    points = seam_points(model, tube)
    off = np.hypot(points[:, 0], points[:, 2]) - radius
    middle = radius - radius * np.cos(0.15)  # of a chord whose ends lie on the circle
    assert off == pytest.approx(middle / 2.0, rel=0.02)


def test_a_covering_of_nothing_is_refused():
    with pytest.raises(InputError, match="models: expected a whole number"):
        cover(BOWL, 0)
