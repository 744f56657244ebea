"""Trimming: the kept part has the boundary's own area, and its edges lie where they should."""

from __future__ import annotations

import numpy as np
import pytest

from fabgeo.fitting.starts.net import model_through
from fabgeo.strips.model import Patch, StripModel
from fabgeo.strips.ruled import RuledPatch
from fabgeo.strips.trim import Fence, trim, trimmed_patch, trimmed_ruled
from fabgeo.surfaces.base import SurfacePoints

TURN = np.radians(30.0)
C, S = np.cos(TURN), np.sin(TURN)


class Square:
    """A flat square of side 2000, turned by 30 degrees: closest points in closed form."""

    name = "square"
    bounds = np.array([[-1366.0, -1366.0, 0.0], [1366.0, 1366.0, 0.0]])

    @property
    def loops(self) -> tuple[np.ndarray, ...]:
        corner = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * 1e3
        return (np.column_stack([corner @ [[C, S], [-S, C]], np.zeros(4)]),)

    def closest(self, points: np.ndarray) -> SurfacePoints:
        uv = points[:, :2] @ np.array([[C, -S], [S, C]])
        kept = np.clip(uv, -1e3, 1e3)
        y = np.column_stack([kept @ np.array([[C, S], [-S, C]]), np.zeros(len(points))])
        normal = np.tile([0.0, 0.0, 1.0], (len(points), 1))
        return SurfacePoints(y, normal, np.zeros((len(points), 3, 3)), (kept != uv).any(axis=1))

    def sample(self, count: int) -> SurfacePoints:
        return self.closest(np.zeros((count, 3)))


SQUARE = Square()


@pytest.fixture(scope="module")
def model() -> StripModel:
    x, y = np.linspace(-1600.0, 1600.0, 9), np.linspace(-1600.0, 1600.0, 6)
    grid = np.stack(np.broadcast_arrays(x[None, :], y[:, None], np.zeros((6, 9))), axis=2)
    return model_through(grid, False, False)


def area(outline: np.ndarray) -> float:
    x, y = outline.T
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def test_trimmed_patches_add_up_to_the_surface(model):
    # The square's corners are rounded within the knot spans of whole-strip patches.
    # In (u, v) a cell is 400 x 640, so areas in parameters are areas in space / 256,000.
    whole = [Patch(i, 0, 0.0, 8.0) for i in range(5)]
    kept = [trimmed_patch(model, p, SQUARE, least=1e-3) for p in whole]
    total = sum(area(p.outline) for p in kept if p is not None) * 400.0 * 640.0
    assert total == pytest.approx(4e6, rel=6e-3)
    shares = sum(p.share for p in kept if p is not None) * 3200.0 * 640.0
    assert shares == pytest.approx(4e6, rel=6e-3)


def test_trimmed_edges_lie_on_edge_curves_or_on_the_boundary(model):
    piece = trimmed_patch(model, Patch(3, 0, 0.0, 8.0), SQUARE)
    assert piece is not None
    assert not piece.whole
    points = piece.ruled.edges(piece.ruled.parameters(6)).reshape(-1, 3)
    on_edge = np.min(np.abs(points[:, 1:2] - np.linspace(-1600.0, 1600.0, 6)), axis=1)
    u, v = C * points[:, 0] + S * points[:, 1], -S * points[:, 0] + C * points[:, 1]
    on_border = 1000.0 - np.maximum(np.abs(u), np.abs(v))
    assert on_border.min() > -1.0
    assert np.minimum(on_edge, np.abs(on_border)).max() < 5.0  # a corner of the square is rounded


def test_rulings_of_a_trimmed_patch_are_the_strip_s_own(model):
    piece = trimmed_patch(model, Patch(1, 0, 0.0, 8.0), SQUARE)
    assert piece is not None
    a, b = piece.ruled.edges(piece.ruled.parameters(4))
    assert np.abs(a[:, 0] - b[:, 0]).max() < 1e-6  # rulings run in y


def test_patches_inside_stay_exact_and_patches_outside_vanish(model):
    inside = trimmed_patch(model, Patch(2, 1, 3.0, 5.0), SQUARE)
    assert inside is not None
    assert inside.whole
    u = np.linspace(3.0, 5.0, 9)
    assert np.allclose(inside.ruled.edges(u)[0], model.edge(2, u), atol=1e-9)
    assert trimmed_patch(model, Patch(0, 0, 0.0, 1.0), SQUARE) is None


def test_intervals_of_strips_end_where_the_square_ends(model):
    found = trim(model, SQUARE, 2)
    assert len(found) == 5
    # The middle strip covers y = -320 to 320; its last inside point is where the square's right
    # side x = 1000 / C - y tan(30) meets y = -320.
    last = (1000.0 / C + 320.0 * np.tan(TURN) + 1600.0) / 400.0
    assert found[2].intervals[0][1] == pytest.approx(last, abs=1e-3)


class Fine(Square):
    """The same with boundary points every 25 mm, as surfaces give them."""

    @property
    def loops(self) -> tuple[np.ndarray, ...]:
        corner = super().loops[0]
        t = np.arange(80)[:, None] / 80.0
        after = np.roll(corner, -1, axis=0)
        return (np.concatenate([(1 - t) * a + t * b for a, b in zip(corner, after, strict=True)]),)


def test_a_fence_parts_points_as_the_surface_does(model):
    fence = Fence(Fine(), model)
    assert fence.loops == (0,)
    points = np.random.default_rng(5).uniform(-1500.0, 1500.0, (4000, 3)) * [1.0, 1.0, 0.02]
    assert np.array_equal(fence(points), ~SQUARE.closest(points).on_boundary)


def test_a_model_that_does_not_overhang_is_not_fenced(model):
    small = StripModel(model.control * 0.4)
    assert Fence(Fine(), small).loops == ()
    ruled = RuledPatch.of_model(small, Patch(2, 0, 0.0, 8.0))
    found = trimmed_ruled(ruled, Fence(Fine(), small))
    assert found is not None
    assert found.whole


def test_kept_and_lost_areas_add_up_to_what_is_inside(model):
    fence = Fence(Fine(), model)
    kept = lost = 0.0
    for strip in range(5):
        whole = RuledPatch.of_model(model, Patch(strip, 0, 0.0, 8.0))
        found = trimmed_ruled(whole, fence, 0.25, 8.0)
        assert found is not None
        kept += found.share * 3200.0 * 640.0
        lost += found.lost
    assert lost > 0.0
    assert kept + lost == pytest.approx(4e6, rel=5e-3)
