"""B-spline charts and trimmed faces."""

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.spatial import KDTree

from fabgeo.errors import InputError
from fabgeo.surfaces.bspline import BSplineChart, Pieces, basis_functions
from fabgeo.surfaces.inspect import inspect
from fabgeo.surfaces.nurbs import NurbsFace, NurbsSurface

RANDOM = np.random.default_rng(3)


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
def test_basis_functions_are_scipys(degree):
    knots = np.concatenate([[0.0] * (degree + 1), np.sort(RANDOM.random(5)), [1.0] * (degree + 1)])
    coefficients = RANDOM.normal(size=len(knots) - degree - 1)
    t = np.concatenate([[0.0, 1.0], RANDOM.random(60)])
    index, value = basis_functions(knots, degree, t)
    for order in range(min(degree, 2) + 1):
        mine = (coefficients[index] * value[order].T).sum(axis=1)
        theirs = BSpline(knots, coefficients, degree).derivative(order)(t)
        assert mine == pytest.approx(theirs, rel=1e-10, abs=1e-8)


@pytest.mark.parametrize("degree", [1, 2, 3, 5, 7, 9])
def test_pieces_are_the_basis_functions(degree):
    inner = np.sort(np.append(RANDOM.uniform(0.0, 300.0, 6), [120.0] * min(degree, 2)))
    knots = np.concatenate([[0.0] * (degree + 1), inner, [300.0] * (degree + 1)])
    t = np.concatenate([RANDOM.uniform(0.0, 300.0, 200), [0.0, 300.0], inner])
    index, value = basis_functions(knots, degree, t)
    acting, quick = Pieces(knots, degree)(t)
    np.testing.assert_array_equal(acting, index)
    for order in range(3):
        size = max(float(np.abs(value[order]).max()), 1e-300)
        assert np.abs(quick[:, order].T - value[order]).max() <= 1e-10 * size


def quarter_arcs() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Poles, weights, knots of the full unit circle (NURBS Book, example 7.4)."""
    poles = np.array(
        [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]], dtype=float
    )
    weights = np.array([1.0, np.sqrt(0.5)] * 4 + [1.0])
    return poles, weights, np.array([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], dtype=float)


def sphere_face(radius: float) -> NurbsFace:
    circle, w, knots = quarter_arcs()
    half = np.array([[0, -1], [1, -1], [1, 0], [1, 1], [0, 1]], dtype=float)  # radius, height
    wv = w[:5]
    poles = np.empty((9, 5, 3))
    poles[..., :2] = circle[:, None] * half[None, :, :1]
    poles[..., 2] = half[None, :, 1]
    knots_v = np.array([0, 0, 0, 1, 1, 2, 2, 2], dtype=float)
    return NurbsFace(radius * poles, w[:, None] * wv, knots, knots_v, 2, 2)


def test_rational_sphere_is_round():
    surface = NurbsSurface([sphere_face(4.0)])
    assert surface.loops == ()
    x = RANDOM.normal(size=(1000, 3)) * 4.0
    at = surface.closest(x)
    out = x / np.linalg.norm(x, axis=1)[:, None]
    assert np.abs(at.point - 4.0 * out).max() < 1e-7
    assert np.abs(at.normal - out).max() < 1e-7
    assert np.abs(at.principal()[0] + 0.25).max() < 1e-6
    assert surface.area == pytest.approx(4 * np.pi * 16.0, rel=5e-3)


def test_chart_derivatives_by_differences():
    poles = RANDOM.normal(size=(6, 7, 3))
    weights = 0.5 + RANDOM.random((6, 7))
    knots = [np.r_[[0.0] * 4, 0.3, 0.6, [1.0] * 4], np.r_[[0.0] * 4, 0.2, 0.5, 0.7, [1.0] * 4]]
    chart = BSplineChart(poles, *knots, weights=weights)
    u, v, h = np.array([0.37, 0.8]), np.array([0.41, 0.13]), 1e-5
    d = chart.evaluate(u, v)

    def p(du: float, dv: float) -> np.ndarray:
        return chart.evaluate(u + du, v + dv).point

    assert d.u == pytest.approx((p(h, 0) - p(-h, 0)) / (2 * h), rel=1e-6, abs=1e-6)
    assert d.v == pytest.approx((p(0, h) - p(0, -h)) / (2 * h), rel=1e-6, abs=1e-6)
    h = 1e-4
    assert d.uu == pytest.approx((p(h, 0) - 2 * p(0, 0) + p(-h, 0)) / h**2, rel=1e-4, abs=1e-4)
    assert d.vv == pytest.approx((p(0, h) - 2 * p(0, 0) + p(0, -h)) / h**2, rel=1e-4, abs=1e-4)
    mixed = (p(h, h) - p(h, -h) - p(-h, h) + p(-h, -h)) / (4 * h**2)
    assert d.uv == pytest.approx(mixed, rel=1e-4, abs=1e-4)


def plane_face(corner, along, across, trims=(), name="") -> NurbsFace:
    corner, along, across = (np.asarray(x, dtype=float) for x in (corner, along, across))
    poles = np.array([[corner, corner + across], [corner + along, corner + along + across]])
    knots = np.array([0.0, 0.0, 1.0, 1.0])
    return NurbsFace(poles, None, knots, knots, 1, 1, trims, name)


def ring(radius: float, count: int = 400) -> np.ndarray:
    t = np.arange(count) * 2.0 * np.pi / count
    return np.column_stack([0.5 + radius * np.cos(t), 0.5 + radius * np.sin(t)])


BOX = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def test_a_hole_is_kept_out():
    """A 10 x 10 square with a round hole of radius 3: distances are known everywhere."""
    face = plane_face([0, 0, 0], [10, 0, 0], [0, 10, 0], (BOX, ring(0.3)[::-1]))
    surface = NurbsSurface([face])
    lengths = sorted(np.linalg.norm(np.roll(x, -1, 0) - x, axis=1).sum() for x in surface.loops)
    assert lengths == pytest.approx([6.0 * np.pi, 40.0], rel=1e-4)
    x = np.column_stack([RANDOM.uniform(-3, 13, (1000, 2)), RANDOM.normal(size=1000)])
    at = surface.closest(x)
    flat = x[:, :2] - 5.0
    r = np.linalg.norm(flat, axis=1)
    hole = r < 3.0
    expected = np.clip(x[:, :2], 0.0, 10.0)
    expected[hole] = 5.0 + 3.0 * flat[hole] / r[hole, None]
    truth = np.linalg.norm(np.column_stack([expected, np.zeros(1000)]) - x, axis=1)
    # The trim is a 400-gon: up to 1e-4 inside the circle.
    assert np.abs(np.linalg.norm(at.point - x, axis=1) - truth).max() < 2e-4
    beside = hole | (np.abs(flat) > 5.0).any(axis=1)
    assert (at.on_boundary == beside).all()
    assert surface.area == pytest.approx(100.0 - 9.0 * np.pi, rel=0.02)


def test_what_lies_beyond_a_trim_along_the_charts_own_side_is_beside_it():
    """A bent face that is trimmed to one half: three of its trim's sides are curved chart sides."""
    x, y = np.meshgrid([0.0, 5.0, 10.0], [0.0, 5.0, 10.0], indexing="ij")
    z = np.array([[0.0, 3.0, 0.0], [3.0, 6.0, 3.0], [0.0, 3.0, 0.0]])
    knots = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
    half = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.0, 0.5]])
    poles = np.stack([x, y, z], axis=2)
    surface = NurbsSurface([NurbsFace(poles, None, knots, knots, 2, 2, (half,))])
    t = np.linspace(0.05, 0.95, 300)
    edge = surface.evaluate(t, 0.0 * t).point
    at = surface.closest(edge - np.array([0.0, 0.3, 0.0]))
    assert at.on_boundary.all()
    assert np.linalg.norm(at.point - edge, axis=1).max() < 0.3
    assert not surface.closest(edge - np.array([0.0, -0.3, -0.1])).on_boundary.any()


def cube_faces(turned: bool) -> list[NurbsFace]:
    """Six sides of a cube of edge 2, every other one with its normal inside if `turned`."""
    x, y, z, o = [2, 0, 0], [0, 2, 0], [0, 0, 2], [0, 0, 0]
    sides = [(o, x, y), (z, x, y), (o, x, z), (y, x, z), (o, y, z), (x, y, z)]
    return [
        plane_face(c, b, a) if turned and k % 2 else plane_face(c, a, b)
        for k, (c, a, b) in enumerate(sides)
    ]


@pytest.mark.parametrize("turned", [False, True])
def test_faces_of_a_cube_agree_and_leave_no_boundary(turned):
    surface = NurbsSurface(cube_faces(turned))
    assert surface.loops == ()
    at = surface.sample(600)
    assert ((at.normal * (at.point - 1.0)).sum(axis=1) > 0.99).all()  # all outwards
    x = RANDOM.uniform(-2, 4, (500, 3))
    found = surface.closest(x)
    inside = ((x > 0) & (x < 2)).all(axis=1)
    clipped = np.linalg.norm(x - np.clip(x, 0, 2), axis=1)
    expected = np.where(inside, np.minimum(x, 2 - x).min(axis=1), clipped)
    assert np.linalg.norm(found.point - x, axis=1) == pytest.approx(expected, abs=1e-9)
    assert not found.on_boundary.any()


def test_shared_edges_are_not_boundary():
    faces = [
        plane_face([0, 0, 0], [2, 0, 0], [0, 1, 0]),
        plane_face([2, 0, 0], [0, 0, 3], [0, 1, 0]),
    ]
    surface = NurbsSurface(faces)
    assert len(surface.loops) == 1
    (loop,) = surface.loops
    assert np.linalg.norm(np.roll(loop, -1, 0) - loop, axis=1).sum() == pytest.approx(12.0)
    fold = (np.abs(loop[:, 0] - 2) < 1e-9) & (loop[:, 2] < 1e-9)
    assert not (fold & (np.abs(loop[:, 1] - 0.5) < 0.4)).any()
    at = surface.closest(np.array([[2.5, 0.5, -0.5], [-1.0, 0.5, 0.0]]))
    assert at.point == pytest.approx(np.array([[2.0, 0.5, 0.0], [0.0, 0.5, 0.0]]), abs=1e-9)
    assert at.on_boundary.tolist() == [False, True]


def test_a_face_that_is_there_twice_is_taken_once():
    """Else none of its edges would be free, and the surface without boundary."""
    face = plane_face([0, 0, 0], [2, 0, 0], [0, 1, 0], name="slab")
    beside = plane_face([2, 0, 0], [2, 0, 0], [0, 1, 0])
    again = plane_face([0, 0, 0], [2, 0, 0], [0, 1, 0], name="slab again")
    surface = NurbsSurface([face, beside, again, face])
    assert surface.faces == (face, beside)
    (loop,) = surface.loops
    assert np.linalg.norm(np.roll(loop, -1, 0) - loop, axis=1).sum() == pytest.approx(10.0)
    found = inspect(surface)
    assert found.area_m2 == pytest.approx(4.0e-6)
    assert any("left out: slab again, slab" in note for note in found.notes)


def test_against_dense_samples():
    i, j = np.meshgrid(np.arange(6.0), np.arange(6.0), indexing="ij")
    poles = np.stack([i, j, RANDOM.normal(size=(6, 6)) * 0.8], axis=-1)
    knots = np.r_[[0.0] * 4, 1 / 3, 2 / 3, [1.0] * 4]
    face = NurbsFace(poles, None, knots, knots, 3, 3, (ring(0.45),))
    surface = NurbsSurface([face])
    x = surface.sample(400).point
    x = x + RANDOM.normal(size=x.shape) * 0.3
    distance = np.linalg.norm(surface.closest(x).point - x, axis=1)
    dense = KDTree(surface.sample(200000).point).query(x)[0]
    assert (distance < dense + 1e-4).all()
    assert (dense - distance).max() < 0.02


def test_a_crossing_trim_is_refused():
    eight = np.array([[0.1, 0.1], [0.9, 0.9], [0.9, 0.1], [0.1, 0.9]])
    face = plane_face([0, 0, 0], [1, 0, 0], [0, 1, 0], (eight,), "sail")
    with pytest.raises(InputError, match=r"nurbs, sail: a trimming loop .* crosses itself"):
        NurbsSurface([face])


@pytest.mark.parametrize("end", [(0.9, 0.5), (0.9, 0.9)])
def test_a_trim_without_area_is_refused(end: tuple[float, float]):
    there = np.linspace([0.1, 0.5], end, 5)
    face = plane_face(
        [0, 0, 0], [1, 0, 0], [0, 1, 0], (np.vstack([there, there[-2:0:-1]]),), "line"
    )
    with pytest.raises(InputError, match="nurbs, line: its trimming loops enclose no area"):
        NurbsSurface([face])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"knots_u": [0.0, 1.0, 0.0, 1.0]}, "expected knots that rise"),
        ({"knots_u": [0.0, 0.0, 1.0]}, "expected shape"),
        ({"weights": [[1.0, 1.0], [0.0, 1.0]]}, "positive weights"),
        ({"degree_u": 2}, "needs 3 poles"),
    ],
)
def test_bad_splines_are_refused(change, message):
    plain = {"knots_u": [0.0, 0.0, 1.0, 1.0], "weights": None, "degree_u": 1} | change
    with pytest.raises(InputError, match=message):
        BSplineChart(np.zeros((2, 2, 3)), knots_v=[0.0, 0.0, 1.0, 1.0], degree_v=1, **plain)


def test_no_face():
    with pytest.raises(InputError, match="holds no face"):
        NurbsSurface([], "empty.step")


def test_samples_are_even_where_parameters_are_not():
    # Nine tenths of a flat square lie in one hundredth of the parameters.
    x = np.array([0.0, 9e3, 10e3])
    poles = np.stack(
        [np.column_stack([x, np.full(3, y), np.zeros(3)]) for y in (0.0, 10e3)], axis=1
    )
    knots = np.array([0.0, 0.0, 0.01, 1.0, 1.0])
    face = NurbsFace(poles, None, knots, np.array([0.0, 0.0, 1.0, 1.0]), 1, 1)
    surface = NurbsSurface([face])
    assert surface.area == pytest.approx(1e8, rel=1e-3)
    at = surface.sample(2000)
    assert np.mean(at.point[:, 0] < 9e3) == pytest.approx(0.9, abs=0.01)
    assert np.histogram(at.point[:, 0], 10, (0.0, 10e3))[0].min() > 150
