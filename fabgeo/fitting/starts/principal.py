"""Start from principal curvature lines traced from a seed.

Through the seed runs one line of each family. From even places on each the lines of the other are
traced, beyond the boundary on the surface's smooth continuation; where they cross are the nodes of
a principal net. It overhangs the boundary on all sides, as a conical model must (it is trimmed
later, see `strips.trim`).
"""

from __future__ import annotations

import weakref
from typing import Any

import numpy as np

from fabgeo.arrays import Array, BoolArray, as_numbers, checked_number, cross, dot, shown, unit
from fabgeo.errors import GeometryError, InputError
from fabgeo.fitting.starts.crossings import crossings
from fabgeo.fitting.starts.draw import model_of_net
from fabgeo.fitting.starts.net import Net
from fabgeo.fitting.starts.overhang import uncovered
from fabgeo.fitting.starts.polyline import even_with_tangents
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import DesignSurface, SurfacePoints, size_of
from fabgeo.surfaces.trace import both_ways, trace_principal
from fabgeo.surfaces.trace_extension import Extended
from fabgeo.surfaces.umbilics import anisotropy, umbilics

FARTHEST_OUT = 1000.0  # overhang, in widths of the mesh
LINES = 19  # of each family, before resampling
STEPS = 44  # of a traced line, each way
STEP = 1 / 37  # of the surface's size: lines are longer than it, so that far corners cross
ROUNDS = 3  # of lines laid further out, until they cover the surface
_LAST: list[Any] = []  # the surface, what was asked of it, and the net found


def principal_start(
    surface: DesignSurface,
    strips: int | None,
    segments: int | None,
    direction: str | None = None,
    seed: Any = None,
    *,
    overhang: float = 0.5,
    **options: Any,
) -> tuple[StripModel, list[str]]:
    """Edges along one principal family, rulings along the other.

    Parameters
    ----------
    direction : "larger" or "smaller"
        Edges follow the larger principal curvature (default) or the smaller.
    seed : (3,) array_like, optional
        Where the two first lines cross; by default near the centre, where directions are clear.
    overhang : float
        How far the net reaches beyond the boundary, in widths of its own 19 x 19 mesh.
    """
    direction = "larger" if direction is None else direction
    if not isinstance(direction, str) or direction not in ("larger", "smaller"):
        problem = f"expected 'larger' or 'smaller', found {shown(direction)}"
        raise InputError("direction", problem)
    if checked_number("overhang", overhang) > FARTHEST_OUT:
        raise InputError("overhang", f"expected {FARTHEST_OUT:g} at most, found {overhang:g}")
    notes = _umbilic_notes(surface)
    net, at = _remembered(surface, seed, overhang)
    if direction == "smaller":
        net = net.turned
    options.setdefault("conjugate", False)
    model, more = model_of_net(net, Extended(surface), strips, segments, **options)
    x, y, z = at.point[0]
    notes += [f"principal lines traced from ({x:.4g}, {y:.4g}, {z:.4g})", *more]
    return model, notes


def principal_net(
    surface: DesignSurface, seed: Any = None, overhang: float = 0.5
) -> tuple[Net, SurfacePoints]:
    """A net of principal lines that covers the surface and overhangs it; rows follow the larger.

    Raises
    ------
    GeometryError
        If the lines do not form a net (an umbilic inside, or lines that close).
    """
    extended = Extended(surface)
    at = surface.closest(_seed(surface, seed))
    _, axes = at.principal()
    step = STEP * size_of(surface)
    larger, smaller = axes[:, 0], axes[:, 1]
    lines, middle = both_ways(
        lambda x, d: trace_principal(extended, x, d, step, STEPS),
        np.concatenate([at.point, at.point]),
        np.concatenate([smaller, larger]),
    )
    spine, rib = (_Spine(extended, line, middle) for line in lines)
    ahead = np.full((2, 2), 0.75 * step)  # how far spine and rib go on beyond the boundary
    best, least = None, np.inf
    for _ in range(ROUNDS):
        places = [
            even_with_tangents(x.cut(*far), LINES)
            for x, far in zip((spine, rib), ahead, strict=True)
        ]
        rows, columns = _families(extended, places, (larger, smaller), step)
        try:
            points, dropped = _largest_block(crossings(rows, columns))
        except GeometryError:
            if best is None:
                raise
            break  # further out the lines are no net
        missing = uncovered(points, extended)
        if missing.sum() < least:
            best, least = points, missing.sum()
        # Beyond lines that are no part of the net, others would not be either.
        missing = np.where(dropped, 0.0, missing)
        if best is not points or not missing.any():
            break
        ahead += np.where(missing > 0.0, missing + step, 0.0)
    assert best is not None  # the first round found one, or raised
    return Net(_cropped(best, extended, overhang)), at


def _remembered(surface: DesignSurface, seed: Any, overhang: float) -> tuple[Net, SurfacePoints]:
    """The net, or its refusal, traced once for edges along either family."""
    asked = repr(seed), overhang
    if not _LAST or _LAST[0]() is not surface or _LAST[1] != asked:
        found: tuple[Net, SurfacePoints] | GeometryError
        try:
            found = principal_net(surface, seed, overhang)
        except GeometryError as error:
            found = error
        _LAST[:] = weakref.ref(surface), asked, found
    if isinstance(_LAST[2], GeometryError):
        raise _LAST[2]
    return _LAST[2]


class _Spine:
    """The principal line through the seed, both ways and beyond the boundary."""

    def __init__(self, surface: Extended, line: Array, middle: int) -> None:
        self.line, self.middle = line, middle
        self.beyond = surface.beyond(line)

    def cut(self, before: float, after: float) -> Array:
        """The line (k, 3) up to distances beyond the boundary at its begin and its end."""
        first = np.flatnonzero(self.beyond[: self.middle] > before)
        last = np.flatnonzero(self.beyond[self.middle :] > after)
        start = first[-1] if len(first) else 0
        stop = self.middle + last[0] + 1 if len(last) else len(self.line)
        return self.line[start:stop]


def _families(
    surface: Extended,
    places: list[tuple[Array, Array]],
    along: tuple[Array, Array],
    step: float,
) -> tuple[Array, Array]:
    """Lines across spine and rib, in the senses of `along` at the seed: (N, k, 3) each.

    All are traced at once, as each closest point costs less among many.
    """
    points, ways = [], []
    for (x, tangents), sense in zip(places, along, strict=True):
        across = unit(cross(surface.closest(x).normal, tangents))
        turn = np.copysign(1.0, dot(across[len(x) // 2], sense[0]))
        points.append(x)
        ways.append(turn * across)
    lines, _ = both_ways(
        lambda x, d: trace_principal(surface, x, d, step, STEPS),
        np.concatenate(points),
        np.concatenate(ways),
    )
    count = len(points[0])
    return lines[:count], lines[count:]


def _largest_block(nodes: Array) -> tuple[Array, BoolArray]:
    """The rows and columns around the middle in which every node exists.

    And (rows, columns) x (first, last): whether lines were dropped on that side.
    """
    good = np.isfinite(nodes).all(axis=2)
    i0 = j0 = 0
    i1, j1 = good.shape
    while not good[i0:i1, j0:j1].all() and min(i1 - i0, j1 - j0) > 4:
        block = ~good[i0:i1, j0:j1]
        # Drop the outer line with the largest share of missing nodes.
        shares = [block[0].mean(), block[-1].mean(), block[:, 0].mean(), block[:, -1].mean()]
        worst = int(np.argmax(shares))
        if shares[worst] == 0.0:
            break
        i0, i1 = i0 + (worst == 0), i1 - (worst == 1)
        j0, j1 = j0 + (worst == 2), j1 - (worst == 3)
    if not good[i0:i1, j0:j1].all() or min(i1 - i0, j1 - j0) < 4:
        bad = np.argwhere(~good[i0:i1, j0:j1])[0]
        raise GeometryError(
            "principal net",
            f"lines {i0 + int(bad[0])} and {j0 + int(bad[1])} of the two families do not cross",
            "move the seed away from umbilics, or choose another start",
        )
    rows, columns = good.shape
    dropped = np.array([[i0 > 0, i1 < rows], [j0 > 0, j1 < columns]])
    return nodes[i0:i1, j0:j1], dropped


def _cropped(points: Array, surface: Extended, overhang: float) -> Array:
    """Without the outer lines that lie wholly beyond the boundary, but for the overhang."""
    beyond = surface.beyond(points.reshape(-1, 3)).reshape(points.shape[:2])
    inside = beyond == 0.0
    for axis in (0, 1):
        used = np.flatnonzero(inside.any(axis=1 - axis))
        if not len(used):
            raise GeometryError("principal net", "no node lies on the surface", "move the seed")
        extra = int(np.ceil(overhang))
        low, high = max(used[0] - extra, 0), min(used[-1] + extra, points.shape[axis] - 1)
        index = np.arange(low, high + 1)
        points, inside = np.take(points, index, axis), np.take(inside, index, axis)
    return points


def _seed(surface: DesignSurface, seed: Any) -> Array:
    if seed is not None:
        try:
            point = as_numbers("seed", seed)
        except InputError:
            point = np.empty(0)
        if point.shape != (3,) or not np.isfinite(point).all():
            raise InputError("seed", f"expected a point (x, y, z), found {shown(seed)}")
        return point[None]
    at = surface.sample(400)
    low, high = surface.bounds
    away = np.linalg.norm(at.point - at.point.mean(axis=0), axis=1) / np.linalg.norm(high - low)
    return at.point[np.argmax(anisotropy(at) * np.exp(-((away / 0.2) ** 2)))][None]


def _umbilic_notes(surface: DesignSurface) -> list[str]:
    at = surface.sample(600)
    share = float(np.mean(anisotropy(at) < 0.05))
    if share > 0.3:
        return [f"principal directions are hardly defined on {100 * share:.0f} % of the surface"]
    return [str(u) for u in umbilics(surface)]
