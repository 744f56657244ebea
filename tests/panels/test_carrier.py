"""The one family of plane, cylinder and cone against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from fabgeo.panels.carrier import Carriers, frames

K = np.array([0.0, 0.3, 0.0, 0.3, -0.4, 0.001])
G = np.array([0.0, 0.0, 0.2, 0.2, -0.1, 0.0001])


@pytest.fixture
def carriers() -> Carriers:
    rng = np.random.default_rng(5)
    frame = frames(rng.normal(size=(6, 3)), rng.normal(size=(6, 3)))
    return Carriers(rng.normal(size=(6, 3)), frame, K, G)


@pytest.fixture
def points(carriers: Carriers) -> np.ndarray:
    rng = np.random.default_rng(6)
    return carriers.origin[:, None] + rng.uniform(-0.9, 0.9, (6, 40, 3))


def test_distance_is_the_textbook_one(carriers: Carriers, points: np.ndarray) -> None:
    x, y, z = np.moveaxis(carriers.local(points), -1, 0)
    d = carriers.distance(points)
    assert d[0] == pytest.approx(z[0], abs=1e-14)  # plane
    assert d[1] == pytest.approx(np.hypot(y[1], z[1] + 1 / 0.3) - 1 / 0.3, abs=1e-13)
    # Cone: radial distance times cos minus axial distance times sin of the half angle.
    half = np.arctan2(0.2, 0.3)
    q = np.stack([x[3] + 1 / 0.2, y[3], z[3]], -1)
    axial = q @ np.array([np.cos(half), 0.0, -np.sin(half)])
    radial = np.sqrt((q**2).sum(-1) - axial**2)
    assert d[3] == pytest.approx(radial * np.cos(half) - axial * np.sin(half), abs=1e-13)


def test_feet_lie_on_the_carrier_and_coordinates_lead_back(
    carriers: Carriers, points: np.ndarray
) -> None:
    feet = carriers.project(points)
    assert np.abs(carriers.distance(feet)).max() < 1e-14
    assert np.abs(carriers.at(*carriers.coordinates(points)) - feet).max() < 1e-13


def test_rulings_stay_on_the_carrier(carriers: Carriers, points: np.ndarray) -> None:
    feet, along = carriers.project(points), carriers.ruling(points)
    assert np.abs(carriers.distance(feet + 0.5 * along)).max() < 1e-14
    assert np.abs(carriers.distance(feet - 0.5 * along)).max() < 1e-14


@pytest.mark.parametrize("column", range(6))
def test_derivatives_against_differences(
    carriers: Carriers, points: np.ndarray, column: int
) -> None:
    step = np.zeros((6, 6))
    step[:, column] = 1e-6
    ahead, behind = carriers.moved(step), carriers.moved(-step)
    along = np.random.default_rng(7).normal(size=points.shape)
    _, jac = carriers.derivatives(points)
    _, tilt_jac = carriers.tilt_derivatives(points, along)
    slope = (ahead.distance(points) - behind.distance(points)) / 2e-6
    turn = ((ahead.normal(points) - behind.normal(points)) * along).sum(-1) / 2e-6
    assert jac[..., column] == pytest.approx(slope, abs=2e-9)
    assert tilt_jac[..., column] == pytest.approx(turn, abs=5e-9)


def test_hessian_is_one_curvature(carriers: Carriers, points: np.ndarray) -> None:
    kappa, along = carriers.curvature(points)
    way = np.random.default_rng(8).normal(size=points.shape)
    h = 1e-5
    change = (carriers.normal(points + h * way) - carriers.normal(points - h * way)) / (2 * h)
    expected = (kappa * (along * way).sum(-1))[..., None] * along
    assert change == pytest.approx(expected, abs=1e-8)
