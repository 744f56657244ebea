"""Measures against closed forms: sag of chords, kinks, distances both ways, folds, boundaries."""

from __future__ import annotations

import numpy as np
import pytest

from fabgeo.arrays import Array, unit
from fabgeo.strips import exact
from fabgeo.strips.distances import distances_from
from fabgeo.strips.measures import measure
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import DesignSurface, SurfacePoints

R, TUBE = 8000.0, 5000.0
ANGLES = np.linspace(0.0, 1.2, 9)
LOW, HIGH = -0.6, 0.9


class Torus:
    """The part of a torus between two meridians and two parallels, in closed form."""

    name = "torus"

    def _at(self, theta: Array, psi: Array) -> SurfacePoints:
        ring = np.stack([np.cos(theta), np.sin(theta), 0.0 * theta], axis=-1)
        up = np.array([0.0, 0.0, 1.0])
        n = np.cos(psi)[:, None] * ring + np.sin(psi)[:, None] * up
        along = -np.sin(psi)[:, None] * ring + np.cos(psi)[:, None] * up
        around = np.stack([-np.sin(theta), np.cos(theta), 0.0 * theta], axis=-1)
        k = np.cos(psi) / (R + TUBE * np.cos(psi))
        shape = -np.einsum("ki,kj->kij", along, along) / TUBE
        shape -= k[:, None, None] * np.einsum("ki,kj->kij", around, around)
        return SurfacePoints(R * ring + TUBE * n, n, shape, np.zeros(len(n), dtype=bool))

    @property
    def bounds(self) -> Array:
        return np.array([[0.0, 0.0, -3000.0], [13_000.0, 13_000.0, 4000.0]])

    @property
    def loops(self) -> tuple[Array, ...]:
        s = np.linspace(0.0, 1.0, 401)
        theta = np.concatenate([0 * s, 1.2 * s, 1.2 + 0 * s, 1.2 * (1 - s)])
        psi = np.concatenate(
            [LOW + (HIGH - LOW) * s, HIGH + 0 * s, HIGH - (HIGH - LOW) * s, LOW + 0 * s]
        )
        return (self._at(theta, psi).point,)

    def closest(self, points: Array) -> SurfacePoints:
        theta = np.arctan2(points[:, 1], points[:, 0])
        psi = np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1]) - R)
        return self._at(theta, psi)

    def sample(self, count: int) -> SurfacePoints:
        k = int(np.sqrt(count))
        theta, psi = np.meshgrid(np.linspace(0.0, 1.2, k), np.linspace(LOW, HIGH, k))
        return self._at(theta.ravel(), psi.ravel())


@pytest.fixture(scope="module")
def model() -> StripModel:
    return exact.meridians(R, TUBE, ANGLES, LOW, HIGH, segments=48).interpolant()


def test_chords_inside_the_surface_have_their_sagitta(model: StripModel) -> None:
    """Meridian strips are chords of parallel circles: the deviation is known in closed form."""
    surface = Torus()
    assert isinstance(surface, DesignSurface)
    found = measure(model, surface)
    step = ANGLES[1] - ANGLES[0]
    psi = np.linspace(LOW, HIGH, 20_001)
    ring = R + TUBE * np.cos(psi)
    middle = np.stack([ring * np.cos(step / 2.0) - R, TUBE * np.sin(psi)])
    sag = TUBE - np.linalg.norm(middle, axis=0)
    assert found.deviation_max is not None
    assert found.deviation_max.value == pytest.approx(sag.max(), rel=1e-4)
    width = 2.0 * ring * np.sin(step / 2.0)
    limit = (np.cos(psi) / ring * width**2 / 16.0).max()
    assert found.sag_limit is not None
    assert found.sag_limit.value == pytest.approx(limit, rel=5e-3)
    assert found.deviation_over_sag_limit == pytest.approx(sag.max() / limit, rel=5e-3)
    assert found.deviation_over_sag_limit == pytest.approx(2.0, rel=0.01)  # all on one side
    assert found.surface_to_model_max == pytest.approx(sag.max(), rel=0.01)
    assert found.boundary_max is not None
    assert found.boundary_max < 1.0 + 1300.0 * (1.0 - np.cos(step / 2.0)) * 10.0
    assert found.boundary_to_model_max is not None
    assert found.boundary_to_model_max < 1.0 + sag.max() * 1.1


def test_the_nearest_of_two_parts_is_as_near_as_the_whole(model: StripModel) -> None:
    points = model.points(model.parameters(1)).reshape(-1, 3) * np.array([1.0, 1.01, 0.99])
    parts = [model.with_control(model.control[rows]) for rows in (slice(0, 4), slice(3, None))]
    apart = np.min([distances_from(part, points) for part in parts], axis=0)
    assert apart == pytest.approx(distances_from(model, points), abs=1e-6)
    assert apart.min() > 0.0


def test_kinks_widths_and_radii_in_closed_form(model: StripModel) -> None:
    found = measure(model)
    step = ANGLES[1] - ANGLES[0]
    # The kink across a meridian is steepest where cos(psi) is 1: the angle between two chords.
    assert found.kink_across_deg is not None
    assert found.kink_across_deg.value == pytest.approx(np.degrees(step), rel=1e-4)
    assert found.width_max.value == pytest.approx(2 * (R + TUBE) * np.sin(step / 2.0), rel=1e-5)
    assert found.width_min.value == pytest.approx(
        2 * (R + TUBE * np.cos(HIGH)) * np.sin(step / 2.0), rel=1e-6
    )
    assert found.regression.value == pytest.approx(1.0, abs=1e-9)  # cylinders
    assert found.kink_along_deg.value < 1e-5
    assert found.folds == ()
    assert found.twist_deg.value < 1e-9


def test_twist_and_its_place_are_found(model: StripModel) -> None:
    control = np.array(model.control)
    control[4, 25] += 40.0 * unit(np.array([0.3, -0.2, 1.0]))
    found = measure(model.with_control(control))
    assert found.twist_deg.value > 0.1
    assert found.twist_deg.strip in (3, 4)
    assert abs(found.twist_deg.u - 24.0) < 3.0


def test_a_fold_is_named_by_strip(model: StripModel) -> None:
    """An edge that runs back on itself over a stretch folds both its strips."""
    control = np.array(model.control)
    control[4, 20:27] = control[4, 20:27][::-1]
    found = measure(model.with_control(control))
    assert {fold.strip for fold in found.folds} == {3, 4}
    assert all(17.0 < fold.u < 27.0 for fold in found.folds)


def test_measures_are_the_same_in_any_position(model: StripModel) -> None:
    rng = np.random.default_rng(7)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    moved = model.with_control(model.control @ turn.T + 5000.0)
    a, b = measure(model), measure(moved)
    for name in ("kink_across_deg", "width_min", "radius_min", "circularity"):
        assert getattr(a, name).value == pytest.approx(getattr(b, name).value, rel=1e-6, abs=1e-8)


def test_a_ring_of_strips_closes() -> None:
    """A model closed in i and in u: the whole torus; every edge is interior."""
    angles = np.linspace(0.0, 2.0 * np.pi, 17)[:-1]
    parallels = exact.revolution(
        R + TUBE * np.cos(angles), TUBE * np.sin(angles), 2.0 * np.pi, 64
    ).interpolant()
    ring = StripModel(parallels.control, True, True, "conical")
    found = measure(ring)
    assert ring.strips == 16
    assert found.kink_across_deg is not None
    assert found.kink_across_deg.value == pytest.approx(360.0 / 16.0, rel=1e-5)
    assert found.folds == ()
