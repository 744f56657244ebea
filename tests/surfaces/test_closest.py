"""Closest points, normals, shape tensors and boundaries against closed forms and dense samples."""

import pickle

import numpy as np
import pytest
from scipy.spatial import KDTree
from shapes import TURN, cylinder, hypar, sphere, torus

from fabgeo.surfaces.base import DesignSurface
from fabgeo.surfaces.formula import FormulaSurface

RANDOM = np.random.default_rng(7)
SCATTER = RANDOM.normal(size=(2000, 3)) * 3.0


def test_all_speak_the_protocol():
    for surface in (sphere(), hypar()):
        assert isinstance(surface, DesignSurface)


def test_sphere():
    at = sphere(3.0).closest(SCATTER)
    out = SCATTER / np.linalg.norm(SCATTER, axis=1)[:, None]
    assert np.abs(at.point - 3.0 * out).max() < 1e-8
    assert np.abs(at.normal - out).max() < 1e-8
    kappa, _ = at.principal()
    assert np.abs(kappa + 1.0 / 3.0).max() < 1e-9  # bends away from the outer normal
    assert not at.on_boundary.any()
    assert sphere().loops == ()


def test_points_at_a_pole():
    at = sphere(3.0).closest(np.array([[0.0, 0.0, 5.0], [0.0, 0.0, -1.0], [1e-9, 0.0, 4.0]]))
    assert np.abs(at.point - [[0, 0, 3], [0, 0, -3], [0, 0, 3]]).max() < 1e-6
    assert np.abs(at.normal - [[0, 0, 1], [0, 0, -1], [0, 0, 1]]).max() < 1e-3
    assert np.abs(at.principal()[0] + 1.0 / 3.0).max() < 1e-6


def test_cylinder_with_ends():
    surface = cylinder(2.0, 5.0)
    at = surface.closest(SCATTER)
    flat = SCATTER[:, :2] / np.linalg.norm(SCATTER[:, :2], axis=1)[:, None]
    expected = np.column_stack([2.0 * flat, np.clip(SCATTER[:, 2], 0.0, 5.0)])
    assert np.abs(at.point - expected).max() < 1e-8
    outside = (SCATTER[:, 2] < 0.0) | (SCATTER[:, 2] > 5.0)
    assert (at.on_boundary == outside).all()
    kappa, axes = at.principal()
    assert np.abs(kappa - [-0.5, 0.0]).max() < 1e-9
    assert np.abs(np.abs(axes[:, 1, 2]) - 1.0).max() < 1e-9
    lengths = [np.linalg.norm(np.roll(x, -1, 0) - x, axis=1).sum() for x in surface.loops]
    assert lengths == pytest.approx([2.0 * TURN, 2.0 * TURN], rel=1e-4)


def test_torus():
    at = torus(5.0, 2.0).closest(SCATTER + np.array([4.0, 0.0, 0.0]))
    x = SCATTER + np.array([4.0, 0.0, 0.0])
    ring = np.hypot(x[:, 0], x[:, 1])
    core = 5.0 * np.column_stack([x[:, 0] / ring, x[:, 1] / ring, np.zeros(len(x))])
    distance = np.linalg.norm(x - core, axis=1)
    assert np.abs(np.linalg.norm(at.point - x, axis=1) - np.abs(distance - 2.0)).max() < 1e-8
    out = (at.point - core) / 2.0
    assert np.abs(at.normal - out).max() < 1e-6
    cos = (at.normal * core).sum(axis=1) / 5.0
    expected = np.stack([np.full(len(x), -0.5), -cos / (5.0 + 2.0 * cos)], axis=1)
    order = np.argsort(-np.abs(expected), axis=1)
    assert at.principal()[0] == pytest.approx(np.take_along_axis(expected, order, 1), abs=1e-6)


def test_saddle_against_dense_samples_and_closed_form():
    surface = hypar(1.0)
    x = RANDOM.normal(size=(500, 3)) * 0.8
    at = surface.closest(x)
    u, v = (g.ravel() for g in np.meshgrid(*[np.linspace(-1.0, 1.0, 1201)] * 2))
    dense = KDTree(np.column_stack([u, v, u * v])).query(x)[0]
    distance = np.linalg.norm(at.point - x, axis=1)
    assert (distance <= dense + 1e-12).all()
    assert (dense - distance).max() < 2e-3
    w = 1.0 + at.point[:, 0] ** 2 + at.point[:, 1] ** 2
    gauss = -1.0 / w**2  # of z = x y
    assert at.principal()[0].prod(axis=1) == pytest.approx(gauss)
    inner = ~at.on_boundary
    r = x - at.point
    assert np.abs(np.cross(r, at.normal))[inner].max() < 1e-8


def test_shape_tensor_is_the_change_of_the_normal():
    """Weingarten: dn = -S dx, by finite differences of the normals along the surface."""
    surface = torus()
    at = surface.sample(200)
    _, axes = at.principal()
    h = 1e-5
    for k in (0, 1):
        step = h * axes[:, k]
        ahead, behind = surface.closest(at.point + step), surface.closest(at.point - step)
        change = (ahead.normal - behind.normal) / (2.0 * h)
        assert np.abs(change + np.einsum("kij,kj->ki", at.shape, axes[:, k])).max() < 1e-5


def test_samples_are_even_by_area():
    at = sphere(1.0).sample(4000)
    # Archimedes: the height of an evenly spread point on a sphere is uniform.
    height = np.sort(at.point[:, 2])
    assert np.abs(height - np.linspace(-1.0, 1.0, len(height))).max() < 0.02


def test_copies_answer_alike():
    surface = torus()
    copy = pickle.loads(pickle.dumps(surface))
    assert np.array_equal(copy.closest(SCATTER[:50]).point, surface.closest(SCATTER[:50]).point)
    assert copy.fingerprint == surface.fingerprint != torus(5.0, 1.9).fingerprint


def test_scale_carries_over():
    small = FormulaSurface("u", "v", "u*v", scale=1000.0)
    assert small.bounds == pytest.approx(np.array([[0, 0, 0], [1000, 1000, 1000]]))
    at = small.closest(np.array([[0.0, 0.0, 0.0]]))
    assert at.principal()[0].prod() == pytest.approx(-1e-6)


def test_empty_and_bad_points():
    from fabgeo.errors import InputError

    assert sphere().closest(np.empty((0, 3))).point.shape == (0, 3)
    with pytest.raises(InputError, match="not finite"):
        sphere().closest(np.array([[0.0, np.nan, 0.0]]))
