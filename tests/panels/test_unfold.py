"""Unfolding against closed forms: plane, cylinder, cone, tangent developable of a helix."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from fabgeo import spline
from fabgeo.arrays import Array
from fabgeo.errors import GeometryError
from fabgeo.panels.flat import FlatEdge, FlatPart
from fabgeo.panels.unfold import flat_polygon, smallest_rectangle, unfold
from fabgeo.panels.unfold_certificate import hermite_area, hermite_length
from fabgeo.panels.unfold_split import split_at_rulings, split_to_fit
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Hole

R = 3000.0


def ruled(
    first: Callable[[Array], Array], second: Callable[[Array], Array], spans: int = 96
) -> RuledPatch:
    knots = spline.clamped_knots(0.0, 1.0, spans)
    sites = spline.greville(knots)
    return RuledPatch.through(knots, sites, first(sites), second(sites))


def stack(*xyz: Array | float) -> Array:
    return np.stack(np.broadcast_arrays(*xyz), axis=-1)


def edge(part: FlatPart, name: str) -> FlatEdge:
    return next(e for e in part.outline if e.name == name)


def cylinder(angle: float = 0.5) -> RuledPatch:
    return ruled(
        lambda u: stack(R * np.cos(angle * u), R * np.sin(angle * u), 50.0 * u**2),
        lambda u: stack(
            R * np.cos(angle * u), R * np.sin(angle * u), 800.0 + 100.0 * np.sin(3 * u)
        ),
    )


def cone() -> RuledPatch:
    apex, slope = np.array([0.0, 0.0, 5000.0]), -5000.0

    def at(share: Callable[[Array], Array | float]) -> Callable[[Array], Array]:
        return lambda u: (
            apex
            + np.asarray(share(u))[..., None]
            * stack(R * np.cos(0.6 * u), R * np.sin(0.6 * u), slope + 0 * u)
        )

    return ruled(at(lambda u: np.full_like(u, 0.6)), at(lambda u: np.ones_like(u)))


def helix_developable(near: float = 500.0, far: float = 1500.0) -> RuledPatch:
    """Tangents of the helix (2000 cos t, 2000 sin t, 600 t), t in [0, 1]."""

    def at(reach: float) -> Callable[[Array], Array]:
        c = reach / np.hypot(2000.0, 600.0)
        return lambda u: (
            stack(2000 * np.cos(u), 2000 * np.sin(u), 600 * u)
            + c * stack(-2000 * np.sin(u), 2000 * np.cos(u), 600.0)
        )

    return ruled(at(near), at(far))


def test_plane_keeps_every_length_and_the_area() -> None:
    corners = np.array([[0.0, 0, 0], [1200, 0, 300], [100, 700, 50], [1000, 800, 0]])
    corners[3] = corners[2] + 0.7 * (corners[1] - corners[0])  # a trapezium lies in a plane
    t = np.linspace(0.0, 1.0, 4)[:, None]
    knots = np.array([0.0] * 4 + [1.0] * 4)
    mid = RuledPatch(
        knots,
        np.stack([(1 - t) * corners[0] + t * corners[1], (1 - t) * corners[2] + t * corners[3]]),
    )
    part = unfold(mid, "W-00-00", "steel", 8.0)
    expected = np.linalg.norm(corners[[1, 3, 3, 2]] - corners[[0, 1, 2, 0]], axis=-1)
    found = [e.length for e in part.outline]
    assert found == pytest.approx(expected, rel=1e-12)
    a, b = corners[1] - corners[0], corners[2] - corners[0]
    assert part.area == pytest.approx(1.7 / 2.0 * np.linalg.norm(np.cross(a, b)), rel=1e-12)
    assert part.bends == ()
    assert all(len(e.points) == 2 for e in part.outline)


def test_cylinder_unrolls_to_the_graph_of_its_height() -> None:
    part = unfold(cylinder(), "P-00-00", "al", 3.0)
    x, w = np.polynomial.legendre.leggauss(40)
    u, w = (x + 1) / 2, w / 2
    first = w @ np.hypot(0.5 * R, 100.0 * u)
    second = w @ np.hypot(0.5 * R, 300.0 * np.cos(3 * u))
    area = 0.5 * R * (w @ (800.0 + 100.0 * np.sin(3 * u) - 50.0 * u**2))
    size = 1500.0
    assert hermite_length(edge(part, "first")) == pytest.approx(first, abs=1e-6 * size)
    assert hermite_length(edge(part, "second")) == pytest.approx(second, abs=1e-6 * size)
    assert part.area == pytest.approx(area, rel=1e-8)
    # The flat edge is the graph itself: its points lie at (R phi, z) up to a motion.
    p = edge(part, "first").points
    assert np.linalg.norm(p[-1] - p[0]) == pytest.approx(np.hypot(0.5 * R, 50.0), abs=1e-6)
    assert [bend.radius for bend in part.bends] == pytest.approx([-R] * len(part.bends), rel=1e-5)


def test_cone_unrolls_to_a_ring_sector() -> None:
    part = unfold(cone(), "P-00-01", "al", 3.0)
    slant = np.hypot(R, 5000.0)
    turn = 0.6 * R / slant
    assert edge(part, "second").length == pytest.approx(slant * turn, abs=1e-6 * slant)
    assert edge(part, "first").length == pytest.approx(0.6 * slant * turn, abs=1e-6 * slant)
    assert part.area == pytest.approx(turn / 2.0 * slant**2 * (1 - 0.36), rel=1e-8)
    chord = edge(part, "second").points
    expected = 2.0 * slant * np.sin(turn / 2.0)
    assert np.linalg.norm(chord[-1] - chord[0]) == pytest.approx(expected, abs=1e-6 * slant)


def test_tangents_of_a_helix_unroll_between_concentric_circles() -> None:
    part = unfold(helix_developable(), "P-00-02", "al", 3.0)
    # The helix has curvature k and length s: its development is a circle of radius 1 / k.
    k, s = 2000.0 / (2000.0**2 + 600.0**2), np.hypot(2000.0, 600.0)
    for name, reach in (("first", 500.0), ("second", 1500.0)):
        # The edge c + reach t has speed sqrt(1 + (reach k)^2) and lies on a concentric circle.
        length, radius = s * np.hypot(1.0, reach * k), np.hypot(1.0 / k, reach)
        found = edge(part, name)
        assert hermite_length(found) == pytest.approx(length, abs=1e-6 * length)
        chord = np.linalg.norm(found.points[-1] - found.points[0])
        assert chord == pytest.approx(2 * radius * np.sin(length / radius / 2), abs=1e-6 * length)
    assert part.area == pytest.approx(k * s * (1500.0**2 - 500.0**2) / 2.0, rel=1e-8)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("made", [cylinder, cone, helix_developable])
def test_certificate_of_developables(made: Callable[[], RuledPatch], side: int) -> None:
    part = unfold(made(), "P-00-03", "al", 3.0, side=side)
    c = part.certificate
    assert c["edge_length_error_mm"] < 1e-5
    assert c["area_error_rel"] < 1e-8
    assert c["angle_error_deg"] < 1e-9
    assert c["stretch_max"] < 1e-9
    assert c["refold_error_mm"] < 0.002
    assert hermite_area(part.outline) > 0.0, "counter-clockwise on the up-side"
    ends = [e.points[-1] for e in part.outline]
    starts = [e.points[0] for e in part.outline[1:] + part.outline[:1]]
    assert np.array_equal(ends, starts)


def test_refold_coordinates_keep_distances_along_and_between_rulings() -> None:
    refold = unfold(cone(), "P-00-04", "al", 3.0).refold
    assert refold is not None
    flat, space = refold[..., :2], refold[..., 2:]
    ruling = np.linalg.norm(flat[:, 1] - flat[:, 0], axis=-1)
    assert ruling == pytest.approx(np.linalg.norm(space[:, 1] - space[:, 0], axis=-1), rel=1e-12)


def test_sides_are_mirror_images_and_bend_the_other_way() -> None:
    up, down = (unfold(cone(), "P", "al", 3.0, side=s) for s in (1, -1))
    assert up.area == pytest.approx(down.area, rel=1e-12)
    assert up.bends[0].radius == pytest.approx(-down.bends[0].radius, rel=1e-9)
    for name in ("first", "second", "start", "end"):
        assert edge(up, name).length == pytest.approx(edge(down, name).length, rel=1e-12)


def test_twisted_patch_keeps_edges_and_measures_its_stretch() -> None:
    twist = np.radians(0.5)
    mid = ruled(
        lambda u: stack(2000.0 * u, 0 * u, 0 * u),
        lambda u: stack(2000.0 * u * np.cos(twist), 600.0 + 0 * u, 2000.0 * u * np.sin(twist)),
        spans=4,
    )
    part = unfold(mid, "P-00-05", "al", 3.0)
    c = part.certificate
    assert c["edge_length_error_mm"] < 1e-6
    assert c["angle_error_deg"] < 1e-9
    # Half-way between edges whose directions differ by the twist, the plane is longer by 1 / cos.
    assert c["stretch_max"] == pytest.approx(1 / np.cos(twist / 2) - 1, rel=0.05)
    assert 0.0 < c["area_error_rel"] < c["stretch_max"]


def test_neighbours_have_the_shared_edge_equally_long() -> None:
    middle = lambda u: stack(2500.0 * u, 900.0 + 60.0 * u * u, 250.0 * np.sin(2 * u))  # noqa: E731
    lower = ruled(lambda u: middle(u) - stack(40.0 * u, 800.0 + 0 * u, 100.0 + 0 * u), middle)
    upper = ruled(middle, lambda u: middle(u) + stack(0 * u, 700.0 + 30.0 * u, -50.0 + 0 * u))
    one = unfold(lower, "P-01-00", "al", 3.0, shared={"second": "P-02-00"})
    two = unfold(upper, "P-02-00", "al", 3.0, shared={"first": "P-01-00"})
    assert edge(one, "second").shared == "P-02-00"
    gap = hermite_length(edge(one, "second")) - hermite_length(edge(two, "first"))
    assert abs(gap) < 0.02 / 100.0


def test_holes_are_carried_along() -> None:
    phi, z = 0.2, 300.0
    out = np.array([np.cos(phi), np.sin(phi), 0.0])
    centre = R * out + [0.0, 0.0, z]
    slot = Hole(centre + 2.0 * out, out, 14.0, 20.0, np.array([0.0, 0.0, 1.0]))
    part = unfold(cylinder(), "P-00-06", "al", 3.0, holes=[slot, Hole(centre, out, 18.0)])
    start = edge(part, "start")
    direction = start.points[1] - start.points[0]
    direction /= np.linalg.norm(direction)
    for hole in part.holes:
        offset = hole.centre - start.points[1]
        across = direction[0] * offset[1] - direction[1] * offset[0]
        assert across == pytest.approx(R * phi, abs=1e-4)
        assert -offset @ direction == pytest.approx(z, abs=1e-4)
    found = np.array([np.cos(part.holes[0].angle), np.sin(part.holes[0].angle)])
    assert abs(found @ direction) == pytest.approx(1.0, abs=1e-9)
    rest = 20.0 * 14.0 + np.pi * (14.0**2 + 18.0**2) / 4.0
    assert part.area == pytest.approx(hermite_area(part.outline) - rest, rel=1e-12)


def test_a_hole_beside_the_patch_is_named() -> None:
    out = np.array([1.0, 0.0, 0.0])
    with pytest.raises(GeometryError, match=r"P-00-07.*hole"):
        unfold(cylinder(), "P-00-07", "al", 3.0, holes=[Hole(R * out + [0, 0, 5000.0], out, 10.0)])


def test_crossing_rulings_are_refused() -> None:
    with pytest.raises(GeometryError, match=r"P-00-08.*cross"):
        unfold(
            ruled(
                lambda u: stack(1000 * u, 0 * u, 0 * u),
                lambda u: stack(-1000 * u, 500 + 0 * u, 0 * u),
            ),
            "P-00-08",
            "al",
            3.0,
        )


def test_length_lies_along_x_in_the_smallest_rectangle() -> None:
    part = unfold(helix_developable(), "P", "al", 3.0)
    points = np.concatenate([e.points for e in part.outline])
    angle, length, width = smallest_rectangle(points)
    assert np.sin(angle) == pytest.approx(0.0, abs=1e-9)
    assert np.ptp(points, axis=0) == pytest.approx([length, width], rel=1e-9)
    assert points.min(axis=0) == pytest.approx([0.0, 0.0], abs=1e-9)


def test_smallest_rectangle_of_a_turned_rectangle() -> None:
    c, s = np.cos(0.3), np.sin(0.3)
    corners = np.array([[0, 0], [5, 0], [5, 2], [0, 2.0]]) @ np.array([[c, s], [-s, c]])
    angle, length, width = smallest_rectangle(corners)
    assert (length, width) == pytest.approx((5.0, 2.0))
    assert np.tan(angle) == pytest.approx(np.tan(-0.3))


def test_connector_plate_from_a_polygon() -> None:
    part = flat_polygon("K-1", "steel", 10.0, np.array([[0, 0], [0, 80], [120, 80], [120, 0.0]]))
    assert hermite_area(part.outline) == pytest.approx(9600.0)


def test_pieces_between_rulings_are_the_patch_itself() -> None:
    whole = helix_developable()
    pieces = split_at_rulings(whole, np.array([0.3, 0.71]))
    for piece in pieces:
        u = np.linspace(piece.u0, piece.u1, 11)
        assert np.abs(piece.edges(u) - whole.edges(u)).max() < 1e-8
    area = sum(unfold(piece, "P", "al", 3.0).area for piece in pieces)
    assert area == pytest.approx(unfold(whole, "P", "al", 3.0).area, rel=1e-8)


def test_long_parts_fit_after_splitting() -> None:
    named = split_to_fit(cylinder(), "P-00-09", [(1000.0, 600.0)], gap=4.0)
    assert [mark for mark, _ in named] == ["P-00-09a", "P-00-09b", "P-00-09c"]
    for mark, piece in named:
        part = unfold(piece, mark, "al", 3.0)
        size = np.ptp(np.concatenate([e.points for e in part.outline]), axis=0)
        assert size[0] <= 1000.0
        assert size[1] <= 600.0
    with pytest.raises(GeometryError, match="wider stock"):
        split_to_fit(cylinder(), "P-00-09", [(5000.0, 20.0)])
