"""Fits of exact patches give their parameters back; stated bounds hold."""

from __future__ import annotations

import numpy as np
import pytest
from panel_patches import exact_patch

from fabgeo.errors import GeometryError
from fabgeo.panels.candidates import own_candidates
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.certify import deviation
from fabgeo.panels.classify import bend_lines, classify
from fabgeo.panels.fit_shape import best_fit
from fabgeo.panels.limits import Tolerances
from fabgeo.panels.made import as_made, end_turns, follows
from fabgeo.panels.pool import CLASSES
from fabgeo.panels.samples import PanelInput, sample
from fabgeo.panels.shapes import Cone, Cylinder, shape_of
from fabgeo.panels.unfold import unfold
from fabgeo.panels.unfold_split import split_at_rulings
from fabgeo.strips.ruled import RuledPatch

OPENINGS = np.radians([1.0, 5.0, 30.0, 90.0, 170.0])


@pytest.mark.parametrize("opening", OPENINGS)
def test_cylinder_parameters(opening: float) -> None:
    rng = np.random.default_rng(1)
    for radius in (800.0, 5000.0, 40000.0):
        patch = exact_patch("cylinder", rng, opening, radius)
        shape = shape_of(best_fit(sample([patch]), "cylinder", polish=False), 0, "cylinder")
        assert isinstance(shape, Cylinder)
        assert shape.radius == pytest.approx(radius, rel=1e-8)
        # The axis is the exact one: its distance to all points of the patch is the radius.
        point, direction = shape.axis
        away = np.cross(patch.edges(patch.parameters(1)).reshape(-1, 3) - point, direction)
        assert np.abs(np.linalg.norm(away, axis=-1) / radius - 1.0).max() < 1e-8


@pytest.mark.parametrize("opening", OPENINGS)
@pytest.mark.parametrize("full_angle", [5.0, 40.0, 90.0, 170.0])
def test_cone_parameters(opening: float, full_angle: float) -> None:
    rng = np.random.default_rng(2)
    half = np.radians(full_angle) / 2.0
    patch = exact_patch("cone", rng, opening, half_angle=half)
    shape = shape_of(best_fit(sample([patch]), "cone", polish=False), 0, "cone")
    assert isinstance(shape, Cone)
    assert shape.half_angle == pytest.approx(half, rel=1e-8)
    apex, direction = shape.axis
    ray = patch.edges(patch.parameters(1)).reshape(-1, 3) - apex
    cosine = ray @ direction / np.linalg.norm(ray, axis=-1)
    assert np.arccos(cosine) == pytest.approx(np.full(len(ray), half), rel=1e-8)


def test_narrow_cone_parameters() -> None:
    """One degree of cone angle: nearly a cylinder, its apex 570 m away."""
    rng = np.random.default_rng(3)
    half = np.radians(0.5)
    for opening in OPENINGS[1:]:
        patch = exact_patch("cone", rng, opening, half_angle=half)
        shape = shape_of(best_fit(sample([patch]), "cone", polish=False), 0, "cone")
        assert isinstance(shape, Cone)
        assert shape.half_angle == pytest.approx(half, rel=1e-8)


@pytest.mark.parametrize("kind", ["flat", "cylinder", "cone"])
def test_exact_patches_get_their_class(kind: str) -> None:
    rng = np.random.default_rng(4)
    panels = [
        PanelInput(f"P-00-{n:02d}", exact_patch(kind, rng, opening, trim=30.0, half_angle=half))
        for n, (opening, half) in enumerate(
            (o, h) for o in np.radians([30.0, 60.0, 120.0]) for h in (0.4, 0.8, 1.3)
        )
    ]
    chosen = classify(panels, Tolerances(deviation_mm=0.5))
    assert {c.cls for c in chosen} == {kind}
    for choice in chosen:
        assert choice.deviation_mm < 1e-4
        assert choice.bend_lines == ("concurrent" if kind == "cone" else "parallel")


def dense_deviation(patch: RuledPatch, carrier) -> float:
    u, v = np.meshgrid(np.linspace(patch.u0, patch.u1, 161), np.linspace(0.0, 1.0, 21))
    return float(np.abs(carrier.distance(patch.points(u.ravel(), v.ravel()))).max())


def check_bounds(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    kinds = rng.choice(["flat", "cylinder", "cone"], count)
    patches = [
        exact_patch(
            kind,
            rng,
            opening=rng.uniform(0.02, 1.0),
            radius=rng.uniform(1500.0, 30000.0),
            length=rng.uniform(300.0, 3000.0),
            half_angle=rng.uniform(0.05, 1.4),
            trim=rng.uniform(0.0, 80.0),
            noise=0.2,
            spans=12,
        )
        for kind in kinds
    ]
    panels = [PanelInput(f"P-{n:04d}", p) for n, p in enumerate(patches)]
    for choice, patch, kind in zip(
        classify(panels, Tolerances(deviation_mm=1.0)), patches, kinds, strict=True
    ):
        assert CLASSES.index(choice.cls) <= CLASSES.index(kind), (choice.mark, kind, choice.cls)
        if choice.shape is not None:
            assert dense_deviation(patch, choice.shape) <= choice.bound_mm
            assert choice.bound_mm <= 1.0


def test_perturbed_patches_keep_class_and_bound() -> None:
    check_bounds(60, seed=11)


@pytest.mark.slow
def test_a_thousand_perturbed_patches_keep_class_and_bound() -> None:
    check_bounds(1000, seed=12)


def test_bound_holds_for_ill_fitting_shapes() -> None:
    """Cylinder patches against planes, and cones against cylinders: large distances."""
    rng = np.random.default_rng(6)
    for kind, wrong in (("cylinder", "flat"), ("cone", "cylinder"), ("cone", "flat")):
        patch = exact_patch(kind, rng, 0.7, spans=9)
        samples = sample([patch])
        carriers = best_fit(samples, wrong)
        found, bound = deviation(samples, carriers)
        dense = dense_deviation(patch, shape_of(carriers, 0, wrong))
        assert found[0] <= dense + 1e-9 <= bound[0]
        assert bound[0] < 1.1 * dense


def test_polishing_lowers_the_largest_deviation() -> None:
    rng = np.random.default_rng(7)
    samples = sample([exact_patch("cylinder", rng, 0.4, noise=0.5, spans=12) for _ in range(8)])
    before, _ = deviation(samples, best_fit(samples, "cylinder", polish=False))
    after, _ = deviation(samples, best_fit(samples, "cylinder"))
    assert np.all(after <= before * 1.0001)
    assert np.mean(after / before) < 0.9


@pytest.mark.parametrize("kind", ["cylinder", "cone"])
def test_made_panel_lies_on_its_shape(kind: str) -> None:
    rng = np.random.default_rng(8)
    patch = exact_patch(kind, rng, 0.5, noise=0.5, spans=12)
    shape = shape_of(best_fit(sample([patch]), kind), 0, kind)
    made = as_made(patch, shape)
    u, v = np.meshgrid(made.parameters(7), np.linspace(0.0, 1.0, 7))
    assert np.abs(shape.distance(made.points(u.ravel(), v.ravel()))).max() < 1e-4
    # Its lines are the shape's rulings, so it unrolls as the shape does.
    first, second = (shape.ruling(edge) for edge in made.edges(made.parameters(7)))
    assert np.abs(first - second).max() < 1e-6
    certificate = unfold(made, "P", "steel", 3.0).certificate
    assert certificate["refold_error_mm"] < 1e-3
    assert certificate["twist_max_deg"] < 1e-4


@pytest.mark.parametrize("kind", ["cylinder", "cone"])
def test_joints_are_taken_off_the_panel_as_made(kind: str) -> None:
    """The slower end of either end ruling comes in by what is asked, whatever the part began as."""
    patch = exact_patch(kind, np.random.default_rng(8), 0.5, noise=0.5, spans=12)
    shape = shape_of(best_fit(sample([patch]), kind), 0, kind)
    part = split_at_rulings(patch, np.array([patch.u0 + 0.1, patch.u1 - 0.2]))[1]
    take = (5.0, 3.0)
    whole, net = as_made(patch, shape), as_made(part, shape, end_turns(patch, shape, take))
    for u, v, way in ((whole.u0, net.u0, take[0]), (whole.u1, net.u1, take[1])):
        a, b = whole.edges(np.array([u]))[:, 0]
        along = (b - a) / np.linalg.norm(b - a)
        ends = net.edges(np.array([v]))[:, 0]
        away = ends - a - np.outer((ends - a) @ along, along)
        # On a cone both ends go as far as they are from the apex (edges run obliquely).
        reach = np.linalg.norm(ends - shape.apex, axis=1) if isinstance(shape, Cone) else np.ones(2)
        expected = way * reach / reach.min()
        assert np.linalg.norm(away, axis=1) == pytest.approx(expected, abs=1e-3)
    assert np.abs(shape.distance(net.edges(net.parameters(3))[0])).max() < 1e-4


def test_shapes_whose_rulings_run_across_the_panel_are_refused() -> None:
    """A cylinder turned by a right angle, and a cone whose apex lies within the panel."""
    rng = np.random.default_rng(12)
    samples = sample([exact_patch("cone", rng, 0.5)])
    good = best_fit(samples, "cone")
    a, m, n = good.frame[0]
    turned = Carriers(good.origin, np.stack([m, -a, n])[None], good.k, 0.0 * good.g)
    near = Carriers(good.origin, good.frame, good.k, np.full(1, 1.0 / 300.0))
    assert follows(samples, good)[0]
    assert not follows(samples, turned)[0]
    assert not follows(samples, near)[0]
    with pytest.raises(GeometryError, match="rulings do not follow"):
        as_made(
            exact_patch("cone", np.random.default_rng(12), 0.5), shape_of(turned, 0, "cylinder")
        )


def test_general_cylinders_and_cones_are_recognised() -> None:
    """Rulings parallel or through one point over a curve that is no circle."""
    rng = np.random.default_rng(9)
    s = np.linspace(0.0, 1.0, 15)
    base = exact_patch("cylinder", rng, 0.5, spans=12)
    curve = np.stack([3000.0 * s, 400.0 * s**3, 100.0 * np.sin(4.0 * s)], -1)
    apex = np.array([500.0, 9000.0, 7000.0])
    parallel = RuledPatch.through(
        base.knots, 12.0 * s, curve, curve + np.array([0.0, 200.0, 1500.0])
    )
    concurrent = RuledPatch.through(base.knots, 12.0 * s, curve, curve + 0.2 * (apex - curve))
    assert bend_lines(sample([parallel, concurrent]), 0.1) == ["parallel", "concurrent"]


def test_impossible_is_proven_by_the_power_mean() -> None:
    """A class is excluded only where no placement can keep the tolerance."""
    rng = np.random.default_rng(10)
    patch = exact_patch("cylinder", rng, 0.5, radius=5000.0)  # sag 5000 (1 - cos 0.25) = 155 mm
    for tolerance, possible in ((70.0, False), (85.0, True)):
        own = own_candidates([PanelInput("P", patch)], Tolerances(deviation_mm=tolerance))
        assert own.possible[0, 0] == possible
