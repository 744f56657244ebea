"""Lines through a ruled patch: the point lies on both, beyond the ends on the patch's tangents."""

from __future__ import annotations

import numpy as np

from fabgeo.strips.pierce import pierce
from fabgeo.strips.ruled import RuledPatch


def bent() -> RuledPatch:
    """A patch that bends and twists a little, u from 0 to 1."""
    s = np.linspace(0.0, 900.0, 4)
    edges = [np.stack([s, 0 * s + y, 2e-4 * s**2 + 0.01 * y], axis=-1) for y in (0.0, 300.0)]
    return RuledPatch(np.repeat([0.0, 1.0], 4), np.array(edges))


def test_a_line_meets_the_patch_where_it_was_sent_through() -> None:
    mid, rng = bent(), np.random.default_rng(1)
    u, v = rng.uniform(0.0, 1.0, (2, 20))
    axes = np.array([0.1, -0.2, 1.0]) + 0.1 * rng.normal(size=(20, 3))
    points = mid.points(u, v) - 70.0 * axes
    found = pierce(mid, points, axes, np.full(20, 0.5))
    assert np.allclose(found, [u, v, np.full(20, 70.0)], atol=1e-9)


def test_beyond_its_ends_the_patch_goes_on_straight() -> None:
    mid = bent()
    beyond, v, axis = np.array([-0.1, 0.2]), np.array([0.3, 0.6]), np.array([0.0, 0.0, 1.0])
    ends = np.array([0.0, 1.0])
    a, b = mid.edges(ends) + beyond[:, None] * mid.edges(ends, 1)
    points = a + v[:, None] * (b - a) - 40.0 * axis
    found = pierce(mid, points, np.tile(axis, (2, 1)), np.array([0.2, 0.8]))
    assert np.allclose(found, [ends + beyond, v, [40.0, 40.0]], atol=1e-9)
