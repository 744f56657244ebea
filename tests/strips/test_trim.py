"""Trimming: the kept part has the boundary's own area, and its edges lie where they should."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import KDTree

from fabgeo.fitting.starts.net import model_through
from fabgeo.panels.unfold import unfold
from fabgeo.strips.model import Patch, StripModel
from fabgeo.strips.ruled import RuledPatch
from fabgeo.strips.trim import Fence, Piece, Rules, Trimmed, trim, trimmed_ruled
from fabgeo.surfaces.base import SurfacePoints
from fabgeo.surfaces.formula import FormulaSurface

TURN = np.radians(30.0)
C, S = np.cos(TURN), np.sin(TURN)
SHARP = Rules(joint=0.0, shortest=0.1, least=0.1)


class Square:
    """A flat square of side 2000, turned by 30 degrees: closest points in closed form."""

    name = "square"
    bounds = np.array([[-1366.0, -1366.0, 0.0], [1366.0, 1366.0, 0.0]])

    @property
    def loops(self) -> tuple[np.ndarray, ...]:
        corner = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * 1e3
        corner = np.column_stack([corner @ [[C, S], [-S, C]], np.zeros(4)])
        t = np.arange(80)[:, None] / 80.0
        after = np.roll(corner, -1, axis=0)
        return (np.concatenate([(1 - t) * a + t * b for a, b in zip(corner, after, strict=True)]),)

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
def plane() -> StripModel:
    x, y = np.linspace(-1600.0, 1600.0, 9), np.linspace(-1600.0, 1600.0, 6)
    grid = np.stack(np.broadcast_arrays(x[None, :], y[:, None], np.zeros((6, 9))), axis=2)
    return model_through(grid, False, False)


def area(ruled: RuledPatch) -> float:
    """By Gauss quadrature of |x_u x x_v| over knot spans: exact for planes."""
    x, w = np.polynomial.legendre.leggauss(8)
    total = 0.0
    for low, high in pairwise(np.unique(ruled.knots)):
        u = low + (high - low) * (x + 1.0) / 2.0
        (a, b), (da, db) = ruled.edges(u), ruled.edges(u, 1)
        for v, weight in zip((x + 1.0) / 2.0, w / 2.0, strict=True):
            size = np.linalg.norm(np.cross((1 - v) * da + v * db, b - a), axis=1)
            total += float(weight * (w / 2.0 * size).sum() * (high - low))
    return total


def cut_points(piece: Piece, per_span: int = 12) -> np.ndarray:
    edges = piece.ruled.edges(piece.ruled.parameters(per_span))
    return np.concatenate([np.empty((0, 3)), *(edges[k] for k in (0, 1) if piece.cut[k])])


def test_pieces_of_a_plane_add_up_to_the_square(plane):
    found = trim(plane, SQUARE, rules=SHARP)
    assert sum(t.inside for _, t in found) == pytest.approx(
        4e6, rel=1e-6
    )  # tips are seen from 5 mm on
    kept = sum(area(piece.ruled) for _, t in found for piece in t.pieces)
    assert kept == pytest.approx(4e6, rel=1e-6)


def test_cut_edges_run_along_the_square_and_have_no_corner(plane):
    for _, found in trim(plane, SQUARE, rules=SHARP):
        for piece in found.pieces:
            points = cut_points(piece)
            u, v = C * points[:, 0] + S * points[:, 1], -S * points[:, 0] + C * points[:, 1]
            assert np.abs(1000.0 - np.maximum(np.abs(u), np.abs(v))).max(initial=0.0) < 1e-4
            for edge in piece.ruled.edges(np.linspace(piece.ruled.u0, piece.ruled.u1, 50), 1):
                direction = edge / np.linalg.norm(edge, axis=1)[:, None]
                assert np.abs(direction - direction[0]).max() < 1e-5


def test_panels_beside_the_surface_are_cut_as_those_on_it(plane):
    """Corners of the boundary are seen along its normals: here they lie 150 mm below."""
    fence = Fence(SQUARE, plane)
    for strip in range(plane.strips):
        on = RuledPatch.of_model(plane, Patch(strip, 0, 0.0, float(plane.segments)))
        above = RuledPatch(on.knots, on.poles + np.array([0.0, 0.0, 150.0]))
        one, other = (trimmed_ruled(p, fence, fence.corners, SHARP) for p in (on, above))
        assert len(one.pieces) == len(other.pieces)
        for mine, its in zip(one.pieces, other.pieces, strict=True):
            assert mine.cut == its.cut
            assert area(its.ruled) == pytest.approx(area(mine.ruled), rel=1e-9)


def test_patches_inside_stay_exact_and_patches_outside_vanish(plane):
    (_, inside), (_, outside) = trim(plane, SQUARE, [Patch(2, 1, 3.0, 5.0), Patch(0, 0, 0.0, 1.0)])
    assert inside.whole
    u = np.linspace(3.0, 5.0, 9)
    assert np.allclose(inside.pieces[0].ruled.edges(u)[0], plane.edge(2, u), atol=1e-9)
    assert outside.pieces == ()
    assert outside.inside == 0.0


def test_joints_and_tips_are_taken_off_the_pieces(plane):
    ruled = RuledPatch.of_model(plane, Patch(1, 0, 0.0, 8.0))
    fence = Fence(SQUARE, plane)
    sharp = trimmed_ruled(ruled, fence, fence.corners, SHARP)
    rules = Rules(joint=20.0, shortest=50.0, least=100.0)
    blunt = trimmed_ruled(ruled, fence, fence.corners, rules)
    assert len(blunt.pieces) + blunt.dropped == len(sharp.pieces)
    for one, other in zip(blunt.pieces[:-1], blunt.pieces[1:], strict=True):
        assert (other.ruled.u0 - one.ruled.u1) * 400.0 == pytest.approx(20.0, abs=1e-6)
        assert one.joined[1]
        assert other.joined[0]
    ends = [np.linalg.norm(np.subtract(*p.ruled.edges(np.array([u]))[:, 0])) for p in blunt.pieces
            for u in (p.ruled.u0, p.ruled.u1)]  # fmt: skip
    assert min(ends) == pytest.approx(50.0, abs=1e-6)


def test_a_fence_parts_points_as_the_surface_does(plane):
    fence = Fence(SQUARE, plane)
    assert fence.loops == (0,)
    assert len(fence.corners) == 4
    points = np.random.default_rng(5).uniform(-1500.0, 1500.0, (4000, 3)) * [1.0, 1.0, 0.02]
    assert np.array_equal(fence(points) >= 0.0, ~SQUARE.closest(points).on_boundary)


def test_a_model_that_does_not_overhang_is_not_fenced(plane):
    small = StripModel(plane.control * 0.4)
    assert Fence(SQUARE, small).loops == ()
    assert all(found.whole for _, found in trim(small, SQUARE))


# A piece of a cylinder whose sides touch its rulings, one from outside and one from inside: the
# map from (s, t) has the determinant (600 - 32 s) R, so its area is 2400 R.
RADIUS = 5000.0
CYLINDER = FormulaSurface(
    "2000*s + 200*t", "5000*sin(a)", "5000*cos(a)", (-1.0, 1.0), (-1.0, 1.0),
    {"s": "u", "t": "v", "a": "0.3*t + 0.08*s**2 + 0.03"},
)  # fmt: skip


@pytest.fixture(scope="module")
def barrel() -> StripModel:
    """Strips whose rulings are the cylinder's, beyond the piece on all sides."""
    a, x = np.linspace(-0.6, 0.6, 49), np.linspace(-3000.0, 3000.0, 9)
    x, a = np.broadcast_arrays(x[:, None], a[None, :])
    grid = np.stack([x, RADIUS * np.sin(a), RADIUS * np.cos(a)], axis=-1)
    return model_through(grid, False, False)


@pytest.fixture(scope="module")
def cut(barrel) -> list[tuple[Patch, Trimmed]]:
    patches = [Patch(i, k, 12.0 * k, 12.0 * k + 12.0) for i in range(8) for k in range(4)]
    return trim(barrel, CYLINDER, patches, SHARP)


def boundary(count: int = 20_000) -> np.ndarray:
    """Dense points of the exact boundary."""
    w, one = np.linspace(-1.0, 1.0, count), np.ones(count)
    sides = [(w, one), (w, -one), (one, w), (-one, w)]
    out = []
    for s, t in sides:
        a = 0.3 * t + 0.08 * s**2 + 0.03
        out.append(np.stack([2e3 * s + 200 * t, RADIUS * np.sin(a), RADIUS * np.cos(a)], axis=-1))
    return np.concatenate(out)


def test_pieces_and_rest_add_up_to_the_cylinder(cut):
    whole, inside = 2400.0 * RADIUS, sum(found.inside for _, found in cut)
    assert inside == pytest.approx(whole, rel=2e-4)  # by chords
    kept = sum(area(piece.ruled) for _, found in cut for piece in found.pieces)
    assert kept == pytest.approx(whole, rel=1e-4)  # what TOUCH leaves beside touched rulings
    assert kept < whole


def test_cut_edges_lie_on_the_boundary_and_cover_it(cut):
    exact = boundary()
    made = np.concatenate([cut_points(p, 40) for _, found in cut for p in found.pieces])
    assert KDTree(exact).query(made)[0].max() < 0.15  # 0.1 mm, and half the exact points' step
    ends = [p.ruled.edges(np.array([u]))[:, 0] for _, found in cut for p in found.pieces
            for u in (p.ruled.u0, p.ruled.u1)]  # fmt: skip
    t = np.linspace(0.0, 1.0, 400)[:, None]
    ends = [a + t * (b - a) for a, b in ends]  # rulings along which the boundary just touches
    off = KDTree(np.concatenate([made, *ends])).query(exact)[0]
    assert np.mean(off < 10.0) > 0.99


def test_neighbours_keep_the_same_part_of_their_common_edge(cut):
    def kept(strip: int, side: int) -> float:
        pieces = [p for patch, found in cut if patch.strip == strip for p in found.pieces]
        return sum(p.ruled.u1 - p.ruled.u0 for p in pieces if not p.cut[side])

    for strip in range(7):
        assert kept(strip, 1) == pytest.approx(kept(strip + 1, 0), abs=0.02)


def test_pieces_are_developable_as_their_patches_and_unfold_exactly(cut):
    sides = 0
    for patch, found in cut:
        for k, piece in enumerate(found.pieces):
            u = piece.ruled.parameters(8)
            (a, b), (da, db) = piece.ruled.edges(u), piece.ruled.edges(u, 1)
            assert np.abs(a[:, 1:] - b[:, 1:]).max() < 1e-3  # the cylinder's own rulings
            if min(np.linalg.norm(b - a, axis=1)) < 20.0:
                continue
            first, second = np.cross(da, b - a), np.cross(db, b - a)
            sine = np.linalg.norm(np.cross(first, second), axis=1) / (
                np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)
            )
            assert np.degrees(sine.max()) < 0.01
            flat = unfold(piece.ruled, f"{patch.mark}-{k}", "steel", 2.0)
            assert flat.certificate["edge_length_error_mm"] < 0.01
            assert flat.certificate["area_error_rel"] < 1e-6
            sides += 1
    assert sides > 15


@pytest.mark.parametrize(("begin", "lean", "bulge"), [(495.0, 17.0, 16.6), (577.5, 2.0, 4.0)])
def test_horns_between_two_tested_rulings_are_found(begin: float, lean: float, bulge: float):
    """Beside a corner the boundary bulges along the rulings: one span, two, one within 13 of 125.

    It comes in along x = f(y) and leaves along y = 944; of the second nothing is inside before.
    """

    def depth(points: np.ndarray) -> np.ndarray:
        t = points[:, 1] / 944.0
        along = points[:, 0] - begin - lean * t - bulge * np.sin(np.pi * t)
        return np.minimum(along, 944.0 - points[:, 1])

    knots, sites = np.repeat([0.0, 1000.0], 4), np.linspace(0.0, 1000.0, 4)
    first = np.column_stack([sites, np.zeros((4, 2))])
    ruled = RuledPatch.through(knots, sites, first, first + np.array([0.0, 1000.0, 0.0]))
    corner = np.array([[[begin + lean, 944.0, 0.0], [0.0, 0.0, 1.0]]])
    found = trimmed_ruled(ruled, depth, corner, SHARP)
    expected = 944.0 * (1000.0 - begin - lean / 2.0 - bulge * 2.0 / np.pi)
    assert found.inside == pytest.approx(expected, rel=1e-4)
    left = expected - sum(area(piece.ruled) for piece in found.pieces)
    assert 0.0 <= left < 2.0 * 0.03 * 944.0 + 1.0  # beside the ruling that the boundary touches
    assert [piece.cut for piece in found.pieces] == [(False, True), (True, True), (False, True)]
