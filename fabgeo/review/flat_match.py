"""Which corner of a flat outline is which corner of the solid, and how well the two agree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fabgeo.arrays import Array, cross
from fabgeo.review.flat_holes import openings_off
from fabgeo.review.measured import FlatFile
from fabgeo.review.rings import distances
from fabgeo.review.solid_plate import SolidPlate, developed

CORNER = np.radians(6.0)  # turn of an outline that may be a corner
SHARP = np.radians(9.0)  # turn of a solid's edges that is a corner of its outline for certain


ALIKE = 0.05  # mm: ways to lay an outline that are equally good


@dataclass(frozen=True)
class Match:
    """An outline laid on a solid.

    Attributes
    ----------
    length_errors : (n,) array
        Outline's edge less solid's edge, mm.
    away : float or None
        Largest distance between the outline and the solid's development; None: not four-sided.
    at : (2,) array
        Where on the outline.
    arcs : Array
        Arc length along the outline at which each of the solid's edges begins, in its sense.
    sense : int
        +1 if the solid's edges run with the outline.
    rails : two (n, 2) arrays, optional
        The solid's rails developed into the drawing.
    """

    length_errors: Array
    away: float | None
    at: Array
    arcs: Array
    sense: int
    rails: tuple[Array, Array] | None = None


def match(
    outline: Array, plate: SolidPlate, rims: Sequence[Array] = (), up: Array | None = None
) -> Match | None:
    """The best of all ways to lay the solid's edges along the outline; None: no corner fits.

    Sharp corners of the solid lie at corners of the outline. Where edges of the solid meet
    smoothly, as at the tip of a panel that is cut along a boundary, the outline shows no corner:
    the edges on both sides share the length between the sharp corners around them. An outline with
    an axis of symmetry is laid as its holes (their contours: `rims`) are, and seen from the side
    that `up` (3,) points to.
    """
    arc, length = _arcs(outline)
    corners = np.flatnonzero(_turns(outline) > CORNER)
    sharp = np.flatnonzero(plate.turns > SHARP)
    if len(sharp) < 2 or len(corners) < len(sharp):
        return None
    found: list[tuple[float, Match]] = []
    steps = np.append(0.0, np.cumsum(plate.lengths)[:-1])
    for sense in (1, -1):
        for start in corners:
            wanted = arc[start] + sense * (steps - steps[sharp[0]])
            away = (arc[corners][None] - wanted[sharp, None] + length / 2) % length - length / 2
            nearest = np.abs(away).argmin(axis=1)
            if len(set(nearest.tolist())) < len(nearest):
                continue
            moved = away[np.arange(len(sharp)), nearest]
            arcs = (wanted + np.interp(steps, *_around(steps[sharp], moved, plate))) % length
            own = (sense * (np.roll(arcs, -1) - arcs)) % length
            errors = own - plate.lengths
            found.append(
                (float(np.abs(errors).max()), Match(errors, None, outline[0], arcs, sense))
            )
    if not found:
        return None
    least = min(score for score, _ in found)
    close = [m for score, m in found if score <= least + 0.2]
    compared = [_compared(outline, plate, m) for m in close]
    away = [m.away if m.away is not None else 0.0 for m in compared]
    alike = [m for m, own in zip(compared, away, strict=True) if own <= min(away) + ALIKE]
    if len(alike) < 2:
        return compared[int(np.argmin(away))]
    return min(alike, key=lambda m: (_holes_off(plate, m, rims), is_mirrored(plate, m, up)))


def _holes_off(plate: SolidPlate, m: Match, rims: Sequence[Array]) -> float:
    """How far holes are off, in steps that tell one way to lay an outline from another."""
    off = [] if m.rails is None or not rims else openings_off(plate, m.rails, rims)
    return max((round(away / ALIKE) for away, _ in off), default=0)


def is_mirrored(plate: SolidPlate, m: Match, up: Array | None) -> bool:
    """Whether the outline is the part seen from the side that `up` points away from."""
    if m.rails is None or up is None:
        return False
    (a, b), (flat_a, flat_b) = plate.four_sided, m.rails
    space = float(cross(a[-1] - a[0], b[0] - a[0]) @ up)
    along, across = flat_a[-1] - flat_a[0], flat_b[0] - flat_a[0]
    return space * float(along[0] * across[1] - along[1] * across[0]) < 0.0


def _around(sites: Array, values: Array, plate: SolidPlate) -> tuple[Array, Array]:
    """Sites and values at sharp corners, once more before and after the closed outline."""
    whole = float(plate.lengths.sum())
    return (
        np.concatenate([sites[-1:] - whole, sites, sites[:1] + whole]),
        np.concatenate([values[-1:], values, values[:1]]),
    )


def point_at(outline: Array, positions: Array) -> Array:
    """Points (k, 2) at arc lengths along a closed outline."""
    arc, length = _arcs(outline)
    closed = np.concatenate([outline, outline[:1]])
    s = np.append(arc, length)
    wrapped = np.asarray(positions) % length
    return np.stack([np.interp(wrapped, s, closed[:, d]) for d in range(2)], axis=-1)


def refold(flat: FlatFile, plate: SolidPlate, found: Match) -> float:
    """How far the pieces between bend lines come to lie off the solid's mid-surface, in mm."""
    import shapely

    length = _arcs(flat.outline)[1]
    ring = shapely.LinearRing(flat.outline)
    ends = shapely.points(flat.bends.reshape(-1, 2))
    off = distances(flat.bends.reshape(-1, 2), flat.outline)
    near = (off <= 1.0).reshape(-1, 2).all(axis=1)
    if not near.any():
        return np.inf
    places = shapely.line_locate_point(ring, ends).reshape(-1, 2)[near]
    plane = flat.bends[near]
    space = _on_solid(places, length, plate, found)
    sizes = [np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) for lines in (plane, space)]
    worst = float(np.abs(sizes[0] - sizes[1]).max())
    if len(plane) > 1:
        pieces = [np.stack([own[:-1], own[1:]], axis=1) for own in (plane, space)]
        worst = max(worst, _rigid(*(own.reshape(len(own), 4, -1) for own in pieces)))
    return worst


def _arcs(outline: Array) -> tuple[Array, float]:
    steps = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1)
    total = np.cumsum(steps)
    return np.append(0.0, total[:-1]), float(total[-1])


def _turns(outline: Array) -> Array:
    """Absolute turning angle at every point."""
    after = np.roll(outline, -1, axis=0) - outline
    before = np.roll(after, 1, axis=0)
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.abs(np.arctan2(cross, np.einsum("ij,ij->i", before, after)))


def _compared(outline: Array, plate: SolidPlate, m: Match) -> Match:
    """The match with its largest distance between outline and development, both ways."""
    rails = plate.rails()
    if rails is None:
        return m
    flat_a, flat_b = developed(*rails)
    contour = np.concatenate([flat_a, flat_b[::-1]])
    corners = np.array([flat_a[0], flat_a[-1], flat_b[-1], flat_b[0]])
    # The solid's corners in the order of its edges: the rails' ends found among them.
    order = [
        int(np.linalg.norm(plate.corners - x, axis=1).argmin())
        for x in (rails[0][0], rails[0][-1], rails[1][-1], rails[1][0])
    ]
    target = point_at(outline, m.arcs)[order]
    moved = _moved(corners, target, contour)
    off, back = distances(outline, moved), distances(moved, outline)
    flat = moved[: len(flat_a)], moved[len(flat_a) :][::-1]
    away, at = max((float(d.max()), points[int(d.argmax())])
                   for d, points in ((off, outline), (back, moved)))  # fmt: skip
    return replace(m, away=away, at=at, rails=flat)


def _moved(source: Array, target: Array, points: Array) -> Array:
    """`points` by the motion (mirrored if that is better) that takes source onto target best."""
    best, least = points, np.inf
    for flip in (1.0, -1.0):
        s, p = source * [1.0, flip], points * [1.0, flip]
        cs, ct = s.mean(axis=0), target.mean(axis=0)
        u, _, vt = np.linalg.svd((s - cs).T @ (target - ct))
        turn = u @ np.diag([1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
        error = float(np.abs((s - cs) @ turn + ct - target).max())
        if error < least:
            best, least = (p - cs) @ turn + ct, error
    return best


def _on_solid(places: Array, length: float, plate: SolidPlate, m: Match) -> Array:
    """Points (..., 3) of the solid's mid-edges at arc lengths (...) of the outline."""
    ways = (m.sense * (places[..., None] - m.arcs)) % length
    edge = ways.argmin(axis=-1)
    # Edges agree in length within the tolerance; the fraction maps one onto the other.
    own = (m.sense * (np.roll(m.arcs, -1) - m.arcs)) % length
    fraction = np.take_along_axis(ways, edge[..., None], -1)[..., 0] / own[edge]
    space = np.zeros((*places.shape, 3))
    for k in np.unique(edge):
        space[edge == k] = _along(plate.edges[k], fraction[edge == k])
    return space


def _along(edge: Array, fraction: Array) -> Array:
    """Points at fractions of an edge's length, by a cubic through its samples."""
    from scipy.interpolate import CubicSpline

    steps = np.linalg.norm(np.diff(edge, axis=0), axis=1)
    arc = np.append(0.0, np.cumsum(steps))
    return np.asarray(CubicSpline(arc, edge)(fraction * arc[-1]))


def _rigid(plane: Array, space: Array) -> float:
    """Largest distance left after the best motion of each plane piece (p, k, 2) into space."""
    p = np.concatenate([plane, np.zeros((*plane.shape[:2], 1))], axis=-1)
    p, s = p - p.mean(axis=1, keepdims=True), space - space.mean(axis=1, keepdims=True)
    u, _, vt = np.linalg.svd(np.swapaxes(p, 1, 2) @ s)
    u[:, :, 2] *= np.sign(np.linalg.det(u @ vt))[:, None]
    return float(np.linalg.norm(p @ (u @ vt) - s, axis=-1).max())
