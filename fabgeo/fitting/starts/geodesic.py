"""Start from geodesics that leave a seed curve, with conjugate rulings between them.

The strips of a geodesic model unfold to nearly straight planks (paper, "Geodesic strip models").
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from fabgeo.arrays import Array, checked, checked_count, checked_number, cross, dot, unit
from fabgeo.errors import GeometryError, InputError
from fabgeo.fitting.starts.draw import model_of_net
from fabgeo.fitting.starts.net import Net
from fabgeo.fitting.starts.overhang import uncovered
from fabgeo.fitting.starts.polyline import even, even_with_tangents
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import DesignSurface, SurfacePoints, size_of
from fabgeo.surfaces.trace import both_ways, conjugate_direction, trace_geodesics
from fabgeo.surfaces.trace_extension import Extended

LINES, STEPS = 25, 32
SQUARE = 0.9  # width over length, from which on a surface has no longer axis
MOST_MODELS = 1000  # side by side
OF_A_PIECE = 40  # chords of a seed curve that several models leave from
LEAST_LEAN = np.radians(45.0)  # between geodesics and the direction conjugate to them
ROUNDS = 4  # of seed curves that go on farther, until the surface is covered


def geodesic_start(
    surface: DesignSurface,
    strips: int | None,
    segments: int | None,
    direction: Any = None,
    seed: Any = None,
    *,
    angle: float = 90.0,
    overhang: float = 0.5,
    part: tuple[int, int] | None = None,
    **options: Any,
) -> tuple[StripModel, list[str]]:
    """Edges along geodesics that cross a seed curve, overhanging the boundary.

    Parameters
    ----------
    direction : "u", "v" or (3,) array_like, optional
        Where the geodesics run, if no seed curve is given: along the longer ("v", default) or the
        shorter axis of the surface, or along a vector. Of a surface that has no longer axis, or
        whose axes are nearly asymptotic directions, along the larger or the smaller curvature at
        its middle.
    seed : (k, 3) array_like, optional
        The curve they leave from; by default the geodesic through the middle, across `direction`.
    angle : float
        Degrees between seed curve and geodesics.
    part : (int, int), optional
        Which one, from 1, of how many models side by side that cover the surface together; each
        leaves from its piece of the seed curve.
    """
    checked_number("overhang", overhang)
    checked_number("angle", angle)
    extended = Extended(surface)
    if seed is None:
        net = _covering_net(extended, direction, angle, overhang, part)
    else:
        net = geodesic_net(extended, checked("seed", seed, (None, 3)), angle, overhang)
    model, notes = model_of_net(net, extended, strips, segments, **{"ends": "free", **options})
    return model, [f"geodesics at {angle:.0f} deg to a seed curve", *notes]


def _covering_net(
    surface: Extended,
    direction: Any,
    angle: float,
    overhang: float,
    part: tuple[int, int] | None = None,
) -> Net:
    """Geodesics across a seed curve that goes on until the outermost lie beyond the boundary.

    An edge along the boundary, now inside, now outside, would be cut in slivers. Of models side by
    side the first goes on at its begin, the last at its end.
    """

    def seed(ahead: npt.ArrayLike) -> Array:
        if part is None:
            return default_seed(surface.inner, direction, ahead)
        return part_seed(surface.inner, part, direction, ahead)

    outer = np.ones(2) if part is None else np.array([part[0] == 1, part[0] == part[1]])
    curve = seed((0.0, 0.0))
    margin = overhang * float(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum()) / LINES
    ahead = np.full(2, margin)
    net = None
    for _ in range(ROUNDS):
        longer = seed(ahead)
        if net is not None and len(longer) == len(curve):
            break  # it leads round the surface
        curve = longer
        net = geodesic_net(surface, curve, angle, overhang)
        missing = uncovered(net.points, surface)[0] * outer
        if not missing.any():
            break
        ahead = np.where(missing > 0.0, ahead + missing + margin, ahead)
    assert net is not None  # the first round found one, or raised
    return net


def geodesic_net(
    surface: Extended, curve: Array, angle: float = 90.0, overhang: float = 0.5
) -> Net:
    """Rows are geodesics, columns join points of equal arc length from the seed curve.

    Raises
    ------
    GeometryError
        If neighbouring geodesics meet within the surface.
    """
    points, tangents = even_with_tangents(curve, LINES)
    at = surface.closest(points)
    side = unit(cross(at.normal, tangents))
    turn = np.radians(angle)
    along = np.cos(turn) * tangents + np.sin(turn) * side
    step = 0.6 * size_of(surface) / STEPS
    rows, _ = both_ways(
        lambda x, d: trace_geodesics(surface, x, d, step, STEPS)[0], at.point, along
    )
    inside = surface.beyond(rows.reshape(-1, 3)).reshape(rows.shape[:2]) == 0.0
    used = np.flatnonzero(inside.any(axis=0))
    if not len(used):
        raise GeometryError("geodesic net", "the seed curve lies beside the surface", "move it")
    extra = int(np.ceil(overhang))
    rows = rows[:, max(used[0] - extra, 0) : used[-1] + extra + 1]
    width = np.linalg.norm(np.diff(rows, axis=0), axis=2)
    meeting = width < 0.1 * np.median(width)
    meeting &= inside[:-1, max(used[0] - extra, 0) : used[-1] + extra + 1]
    if meeting.any():
        i, j = np.argwhere(meeting)[0]
        x, y, z = rows[i, j]
        raise GeometryError(
            f"geodesics {i} and {i + 1}",
            f"meet near ({x:.4g}, {y:.4g}, {z:.4g})",
            "cover the surface by several models, or start from another curve",
        )
    return Net(rows)


def part_seed(
    surface: DesignSurface,
    part: tuple[int, int],
    direction: Any = None,
    ahead: npt.ArrayLike = (0.0, 0.0),
) -> Array:
    """The piece of the default seed curve that one of several models side by side leaves from.

    `ahead` is how far the first piece goes on beyond the boundary, and the last one.

    Raises
    ------
    InputError
        If there is no such part.
    """
    number, count = part
    checked_count("part", count, 1, MOST_MODELS)
    if not 1 <= number <= count:
        raise InputError("part", f"expected one from 1 to {count}, found {number}")
    line, longer = default_seed(surface, direction), default_seed(surface, direction, ahead)
    whole = even(line, OF_A_PIECE * count + 1)
    piece = whole[OF_A_PIECE * (number - 1) : OF_A_PIECE * number + 1]
    begin, end = (int(np.argmin(np.linalg.norm(longer - x, axis=1))) for x in line[[0, -1]])
    before = longer[:begin] if number == 1 else longer[:0]
    after = longer[end + 1 :] if number == count else longer[:0]
    return np.concatenate([before, piece, after])


def default_seed(
    surface: DesignSurface, direction: Any = None, ahead: npt.ArrayLike = (0.0, 0.0)
) -> Array:
    """The geodesic through the middle of the surface across a direction, within the boundary.

    `ahead` is how far it goes on beyond the boundary at its begin and its end.
    """
    at = surface.sample(400)
    centre = surface.closest(at.point.mean(axis=0)[None])
    along = _axis(at.point, centre, direction)
    across = cross(centre.normal[0], along)
    if np.linalg.norm(across) < 1e-6:
        raise InputError("direction", "is normal to the surface at its middle", "choose another")
    extended = Extended(surface)
    step = 0.6 * size_of(surface) / 64
    lines, middle = both_ways(
        lambda x, d: trace_geodesics(extended, x, d, step, 64)[0], centre.point, across[None]
    )
    line = lines[0]
    beyond, (before, after) = extended.beyond(line), np.asarray(ahead)
    back, on = beyond[middle::-1] > before, beyond[middle:] > after
    first = middle - int(np.argmax(back)) if back.any() else 0
    last = middle + int(np.argmax(on)) if on.any() else len(line) - 1
    return line[first : last + 1]


def _axis(points: Array, centre: SurfacePoints, direction: Any) -> Array:
    """Where geodesics run: a vector that is given, else along an axis of the points.

    Where the surface is about as wide as long, or its axis leads in a nearly asymptotic direction
    (no rulings lead across geodesics along one), principal directions of the middle stand in.
    """
    if direction is not None and not isinstance(direction, str):
        return unit(checked("direction", direction, (3,)))
    if direction not in (None, "u", "v"):
        raise InputError("direction", f"expected 'u', 'v' or a vector, found {direction!r}")
    _, sizes, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    which = 1 if direction == "u" else 0
    _, principal = centre.principal()
    along = unit(axes[:1] - dot(axes[:1], centre.normal)[:, None] * centre.normal)
    cosine = np.abs(principal[0] @ along[0])
    if sizes[1] > SQUARE * sizes[0]:
        return principal[0, which]  # edges along the larger curvature
    if abs(dot(conjugate_direction(centre, along), along)[0]) > np.cos(LEAST_LEAN):
        return principal[0, np.argsort(-cosine)[which]]
    return axes[which]
