"""Unfolding: a developable ruled patch becomes a flat part with a certificate (issue 6).

Glossary
--------
up-side
    The side seen in the drawing. `side` = +1: the side of x_u cross x_v of the mid-surface (u along
    the edge curves, v from the first to the second); -1: the other. Panels: the outer side.
certificate
    Lengths, area, angles, stretch and refolding, each measured by a second route.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fabgeo.arrays import Array, checked, unit
from fabgeo.errors import InputError
from fabgeo.panels.flat import BendLine, FlatEdge, FlatHole, FlatPart
from fabgeo.panels.unfold_certificate import certificate, hermite_area, normals
from fabgeo.panels.unfold_develop import Development, develop
from fabgeo.panels.unfold_holes import HoleLike, flat_holes, hole_area, images
from fabgeo.strips.ruled import RuledPatch

GRAINS = ("free", "along", "steps")
STRAIGHT = 1e-7  # mm: an edge closer to its chord is delivered as two points


def unfold(
    mid: RuledPatch,
    mark: str,
    material: str,
    thickness: float,
    holes: Sequence[HoleLike] = (),
    shared: Mapping[str, str] | None = None,
    grain: str = "steps",
    side: int = 1,
    tolerance: float = 1e-4,
    bend_spacing: float = 100.0,
) -> FlatPart:
    """Lay a developable ruled patch flat at its mid-surface.

    Parameters
    ----------
    mid : RuledPatch
        Net mid-surface in mm: plane, cylinder, cone or any developable.
    mark, material, thickness
        Of the part.
    holes : sequence of Hole
        In space; each goes along its axis to the mid-surface and with it into the plane.
    shared : mapping, optional
        Marks of the neighbours at "first", "second", "start", "end".
    grain : str
        "free", "along" or "steps".
    side : int
        +1 or -1: the up-side (see the glossary).
    tolerance : float
        mm: of the integration and of the outline as cubic Hermite curves.
    bend_spacing : float
        mm: largest distance between bend lines along the middle; none on a plane.

    Returns
    -------
    FlatPart
        Its length along x, its lower left corner at the origin; outline counter-clockwise on the
        up-side, in the order first, end, second, start (side = +1).

    Raises
    ------
    GeometryError
        If rulings cross or have no length, or a hole misses the patch.
    """
    if grain not in GRAINS or side not in (1, -1):
        raise InputError(mark, f"expected grain in {GRAINS} and side 1 or -1")
    flat = _placed(develop(mid, mark, tolerance), side)
    outline = _outline(flat, shared or {}, side)
    drilled = flat_holes(mid, flat, holes, mark)
    net = hermite_area(outline) - sum(hole_area(hole) for hole in drilled)
    return FlatPart(
        mark=mark,
        material=material,
        thickness=thickness,
        outline=outline,
        holes=drilled,
        bends=_bends(mid, flat, side, bend_spacing),
        area=net,
        grain=grain,
        certificate=certificate(mid, flat, outline, side),
        refold=np.concatenate(
            [np.moveaxis(flat.edges, 0, 1), np.moveaxis(mid.edges(flat.rule.breaks), 0, 1)], axis=-1
        ),
    )


def flat_polygon(
    mark: str,
    material: str,
    thickness: float,
    corners: Array,
    holes: Sequence[FlatHole] = (),
    grain: str = "free",
) -> FlatPart:
    """Return a flat part with straight edges (connector plates): corners (k, 2) in mm, in order."""
    corners = checked(mark, corners, ("k", 2))
    x, y = corners.T
    if float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) < 0.0:
        corners = corners[::-1]
    following = np.roll(corners, -1, axis=0)
    outline = tuple(
        _straight(f"side {k + 1}", p, q, "")
        for k, (p, q) in enumerate(zip(corners, following, strict=True))
    )
    area = hermite_area(outline) - sum(hole_area(hole) for hole in holes)
    return FlatPart(mark, material, thickness, outline, tuple(holes), area=area, grain=grain)


def smallest_rectangle(points: Array) -> tuple[float, float, float]:
    """Angle, length and width of the smallest rectangle around points (k, 2).

    The angle turns the points so that the length lies along x. One side of the smallest rectangle
    lies on a side of the convex hull (Freeman and Shapira 1975).
    """
    from scipy.spatial import ConvexHull

    hull = points[ConvexHull(points).vertices]
    sides = np.roll(hull, -1, axis=0) - hull
    sides = sides[np.linalg.norm(sides, axis=-1) > 1e-9]
    angles = np.arctan2(sides[:, 1], sides[:, 0])
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    along = c * hull[:, 0] + s * hull[:, 1]
    over = -s * hull[:, 0] + c * hull[:, 1]
    length, width = np.ptp(along, axis=1), np.ptp(over, axis=1)
    best = int(np.argmin(length * width))
    angle = -float(angles[best])
    if length[best] < width[best]:
        return angle + np.pi / 2.0, float(width[best]), float(length[best])
    return angle, float(length[best]), float(width[best])


def _placed(flat: Development, side: int) -> Development:
    """Seen from the up-side, in its smallest rectangle with the length along x."""
    edges, tangents, theta = flat.edges, flat.tangents, flat.theta
    if side < 0:
        mirror = np.array([-1.0, 1.0])
        edges, tangents, theta = edges * mirror, tangents * mirror, np.pi - theta
    angle, _, _ = smallest_rectangle(edges.reshape(-1, 2))
    # Of the two turns that lay it along x, the one that keeps growing u towards growing x.
    chord = edges[:, -1].mean(axis=0) - edges[:, 0].mean(axis=0)
    if np.cos(angle) * chord[0] - np.sin(angle) * chord[1] < -1e-9:
        angle += np.pi
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, s], [-s, c]])
    edges = edges @ turn
    low = edges.reshape(-1, 2).min(axis=0)
    return Development(flat.rule, edges - low, tangents @ turn, flat.arcs, theta + angle)


def _outline(flat: Development, shared: Mapping[str, str], side: int) -> tuple[FlatEdge, ...]:
    (a, b), (ta, tb), (sa, sb) = flat.edges, flat.tangents, flat.arcs
    name = {key: shared.get(key, "") for key in ("first", "second", "start", "end")}

    def curve(key: str, points: Array, tangents: Array, arc: Array, forward: bool) -> FlatEdge:
        if not forward:
            points, tangents, arc = points[::-1], -tangents[::-1], arc[-1] - arc[::-1]
        chord = np.linalg.norm(points[-1] - points[0])
        if arc[-1] - chord < STRAIGHT**2 / max(arc[-1], 1.0) or _is_straight(points):
            return _straight(key, points[0], points[-1], name[key])
        return FlatEdge(key, points, tangents, arc, name[key])

    forward = side > 0
    first = curve("first", a, ta, sa, forward)
    second = curve("second", b, tb, sb, not forward)
    if forward:
        end, start = (a[-1], b[-1]), (b[0], a[0])
        return (
            first,
            _straight("end", *end, name["end"]),
            second,
            _straight("start", *start, name["start"]),
        )
    start, end = (a[0], b[0]), (b[-1], a[-1])
    return (
        _straight("start", *start, name["start"]),
        second,
        _straight("end", *end, name["end"]),
        first,
    )


def _is_straight(points: Array) -> bool:
    chord = unit(points[-1] - points[0])
    offset = points - points[0]
    return bool(np.abs(offset[:, 0] * chord[1] - offset[:, 1] * chord[0]).max() < STRAIGHT)


def _straight(key: str, start: Array, end: Array, shared: str) -> FlatEdge:
    length = float(np.linalg.norm(end - start))
    tangent = unit(end - start)
    return FlatEdge(
        key, np.stack([start, end]), np.stack([tangent, tangent]), np.array([0.0, length]), shared
    )


def _bends(mid: RuledPatch, flat: Development, side: int, spacing: float) -> tuple[BendLine, ...]:
    """Rulings evenly spaced along the middle, with the radius there."""
    middle = flat.edges.mean(axis=0)
    way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(middle, axis=0), axis=-1)))
    _, rate, speed = normals(mid, flat.rule.breaks)
    total = np.trapezoid(np.abs(rate), flat.rule.breaks)
    if total < 1e-6:  # radians: a plane
        return ()
    count = max(3, int(np.ceil(way[-1] / spacing)) - 1)
    at = np.linspace(0.0, way[-1], count + 2)[1:-1]
    u = np.interp(at, way, flat.rule.breaks)
    ends = images(mid, flat, np.stack([u, u]), np.array([[0.0], [1.0]]))
    _, rate, speed = normals(mid, u)
    # n turns by `rate` towards growing u where the patch bends away from its normal.
    curvature = -side * rate / speed
    radius = np.where(
        np.abs(curvature) > 1e-9, 1.0 / np.where(curvature == 0, 1, curvature), np.inf
    )
    return tuple(BendLine(p, q, float(r)) for p, q, r in zip(ends[0], ends[1], radius, strict=True))
