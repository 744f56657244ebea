"""Outlines laid on solids: panels cut along a boundary end in tips whose corners are smooth."""

from __future__ import annotations

import numpy as np
import pytest

from fabgeo.arrays import Array
from fabgeo.review.flat_match import Match, match
from fabgeo.review.rails import ruling_radii
from fabgeo.review.sheet_copy import moves
from fabgeo.review.solid_plate import SAMPLES, SolidPlate

T = np.linspace(0.0, 1.0, SAMPLES)


def plate(first: Array, second: Array) -> SolidPlate:
    """A plate between two plane rails (n, 2) with rulings at its ends."""
    rails = [np.column_stack([rail, np.zeros(len(rail))]) for rail in (first, second)]
    ends = [r0 + T[:, None] * (r1 - r0) for r0, r1 in ((rails[0][-1], rails[1][-1]),
                                                       (rails[1][0], rails[0][0]))]  # fmt: skip
    edges = (rails[0], ends[0], rails[1][::-1], ends[1])
    straight = (False, True, False, True)
    return SolidPlate("P-00-00", 1.0, np.zeros(3), edges, straight, 3.0, ())


def tip(turn: float) -> SolidPlate:
    """A leaf 4 m long: its far end is cut at a ruling that carries on the rail's direction."""
    x = 4000.0 * T
    first = np.column_stack([x, 40.0 * T**2])
    end = np.array([np.cos(turn), 0.02 + np.sin(turn)])
    over = first[-1] + 300.0 * end
    start = np.array([300.0, 900.0])
    second = start + T[:, None] * (over - start) + (120.0 * T * (1.0 - T))[:, None] * [0.0, 1.0]
    return plate(first, second)


def drawn(solid: SolidPlate, begin: int = 40) -> Array:
    """The solid's outline as a DXF file may give it: turned, and begun anywhere."""
    ring = np.concatenate([edge[:-1, :2] for edge in solid.edges])
    c, s = np.cos(0.7), np.sin(0.7)
    return np.roll(ring, -begin, axis=0) @ np.array([[c, s], [-s, c]]) + [500.0, -80.0]


@pytest.mark.parametrize("degrees", [0.0, 2.0, 8.0, 40.0])
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_tip_with_smooth_corners_is_laid_on_its_solid(degrees: float, mirrored: bool) -> None:
    solid = tip(np.radians(degrees))
    outline = drawn(solid)
    outline = outline[::-1] * [1.0, -1.0] if mirrored else outline
    found = match(outline, solid)
    assert isinstance(found, Match)
    assert np.abs(found.length_errors).max() < 2e-4
    assert found.away is not None
    # The outline's chords of h = 4000 / 64 sag by kappa h^2 / 8 = 2 * 120 / 4000^2 * h^2 / 8.
    assert found.away == pytest.approx(120.0 / 64**2 / 4.0, rel=0.02)


@pytest.mark.parametrize("degrees", [0.0, 8.0, 40.0])
def test_a_scaled_tip_is_longer_on_every_edge(degrees: float) -> None:
    solid = tip(np.radians(degrees))
    found = match(1.001 * drawn(solid), solid)
    assert isinstance(found, Match)
    assert np.allclose(found.length_errors, 0.001 * solid.lengths, rtol=0.02, atol=2e-3)


def test_a_tip_s_moved_vertex_is_seen() -> None:
    solid = tip(0.0)
    outline = drawn(solid)
    across = (outline[91] - outline[89]) @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    outline[90] += 0.5 * across / np.linalg.norm(across)
    found = match(outline, solid)
    assert isinstance(found, Match)
    assert found.away is not None
    assert found.away == pytest.approx(0.5, abs=0.01)


def test_radii_at_both_ends_of_a_cone_s_rulings_are_the_cone_s() -> None:
    half, angle = np.radians(20.0), 0.4 * T
    way = np.column_stack([np.sin(half) * np.cos(angle), np.sin(half) * np.sin(angle),
                           np.full(SAMPLES, np.cos(half))])  # fmt: skip
    low, high = 3000.0 + 500.0 * T, 5000.0 - 900.0 * T**2
    radii = ruling_radii((low[:, None] * way, high[:, None] * way))
    assert radii[0] == pytest.approx(low * np.tan(half), rel=5e-4)
    assert radii[1] == pytest.approx(high * np.tan(half), rel=5e-4)


def test_a_rectangle_on_its_sheet_may_have_been_turned_either_way() -> None:
    """Its outline does not tell: by rounding alone the wrong way may come nearer; holes tell."""
    corners = np.array([[0.0, 0.0], [900.0, 0.0], [900.0, 180.0], [0.0, 180.0]])
    hole = np.array([[100.0, 60.0]])
    for turn in (0.3, 0.3 + np.pi):
        c, s = np.cos(turn), np.sin(turn)
        there = np.array([[c, s], [-s, c]])
        jitter = np.random.default_rng(1).uniform(-1e-4, 1e-4, corners.shape)
        motions = moves(corners, corners @ there + [50.0, 70.0] + jitter)
        off = [np.linalg.norm(motion(hole) - hole @ there - [50.0, 70.0]) for motion in motions]
        assert min(off) < 1e-3
        assert sum(motion.away < 1e-3 for motion in motions) == 2
