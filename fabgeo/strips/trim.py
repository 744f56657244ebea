"""Trim an overhanging strip model to the boundary of its design surface.

What is inside of a ruled patch is parted at its events into pieces, each a ruled patch again: its
rulings are parts of the old ones, and each of its edges runs either along the patch's own edge or
along the boundary, so that no edge has a corner. Where the boundary crosses a patch obliquely the
piece at its end is a triangle; where it touches a ruling from outside, two horns are left.

Glossary
--------
piece
    What is inside between two events, or several of them that leave its edges smooth.
tip
    Where the rulings of a piece shrink to nothing: the piece ends at its last ruling of a length
    that can be made.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fabgeo import spline
from fabgeo.arrays import Array, BoolArray, cross
from fabgeo.errors import GeometryError
from fabgeo.strips.fence import Fence
from fabgeo.strips.lanes import TESTED, Lane, corners_on, lanes_of, meet, pace
from fabgeo.strips.model import Patch, StripModel
from fabgeo.strips.ruled import RuledPatch
from fabgeo.strips.within import Depth, Span, Within
from fabgeo.surfaces.base import DesignSurface

__all__ = ["Fence", "Piece", "Rules", "Trimmed", "trim", "trimmed_ruled"]

TOLERANCE = 5e-3  # mm, of a cut edge from where the rulings meet the boundary
TOUCH = 0.03  # mm left open at least beside a ruling that the boundary touches: endless steep there
ROUNDS = 24  # of parting knot spans, until the tolerance is met
CHECKS = np.array([0.07, 0.25, 0.5, 0.75, 0.93])  # of a knot span, where it is measured
MOST_SPANS = 400


@dataclass(frozen=True)
class Rules:
    """How pieces are made.

    Attributes
    ----------
    joint : float
        Clear width between two pieces of a patch, as between panels.
    shortest : float
        A tip ends at the ruling that is so long; lengths in the model's unit.
    least : float
        Pieces that are shorter across their rulings are dropped.
    """

    joint: float = 0.0
    shortest: float = 1.0
    least: float = 1.0


@dataclass(frozen=True)
class Piece:
    """A ruled piece of a patch.

    Attributes
    ----------
    ruled : RuledPatch
        u keeps its meaning.
    cut : (bool, bool)
        Whether the first and the second edge run along the boundary; else along the patch's.
    ends : (Span, Span)
        Which part of the patch's ruling the first and the last ruling are.
    joined : (bool, bool)
        Whether another piece of the same patch begins beyond the first and the last ruling.
    breaks : (float, float)
        The u of the events that it lies between; joints and tips are taken off there.
    """

    ruled: RuledPatch
    cut: tuple[bool, bool]
    ends: tuple[Span, Span]
    joined: tuple[bool, bool] = (False, False)
    breaks: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Trimmed:
    """What is inside of a ruled patch.

    Attributes
    ----------
    pieces : tuple of Piece
        By ascending u.
    area, inside : float
        Of the patch, and of what of it is inside; pieces, joints between them, tips and dropped
        pieces add up to the second.
    dropped : int
        How many pieces were too small.
    """

    pieces: tuple[Piece, ...]
    area: float
    inside: float
    dropped: int = 0

    @property
    def whole(self) -> bool:
        """Whether nothing was cut away."""
        return len(self.pieces) == 1 and self.inside == self.area


def trim(
    model: StripModel,
    surface: DesignSurface,
    patches: Sequence[Patch] | None = None,
    rules: Rules | None = None,
) -> list[tuple[Patch, Trimmed]]:
    """What of every patch, by default of every strip, lies inside the surface's boundary."""
    fence = Fence(surface, model)
    if patches is None:
        patches = [Patch(strip, 0, 0.0, float(model.segments)) for strip in range(model.strips)]
    ruled = [RuledPatch.of_model(model, patch) for patch in patches]
    return [
        (patch, trimmed_ruled(one, fence, fence.corners, rules, patch.mark))
        for patch, one in zip(patches, ruled, strict=True)
    ]


def trimmed_ruled(
    ruled: RuledPatch,
    depth: Depth,
    corners: Array | None = None,
    rules: Rules | None = None,
    mark: str = "patch",
) -> Trimmed:
    """The pieces of a ruled patch that are inside.

    Parameters
    ----------
    depth : callable
        Signed depth of points (k, 3), such as a `Fence`.
    corners : (k, 2, 3) array, optional
        Corners of the boundary, with the surface's unit normals there.
    mark : str
        Its name in messages.

    Raises
    ------
    GeometryError
        If a cut edge can't be followed within the tolerance.
    """
    rules = rules or Rules()
    within, u = Within(ruled, depth), ruled.parameters(TESTED)
    area = _area(ruled, u, np.zeros(len(u)), np.ones(len(u)))
    at = corners_on(ruled, corners) if corners is not None and len(corners) else np.empty((0, 2))
    events = within.events(np.unique(np.concatenate([u, at[:, 0]])))
    if not len(events):
        spans = within.spans(u[[0, len(u) // 2, -1]])
        if all(s == [(0.0, 1.0)] for s in spans):
            whole = Piece(ruled, (False, False), ((0.0, 1.0), (0.0, 1.0)))
            return Trimmed((whole,), area, area)
    breaks = np.unique(np.concatenate([u[[0, -1]], events, at[:, 0]]))
    keep = np.append(True, np.diff(breaks) > 1e-7 * (u[-1] - u[0]))
    breaks = breaks[keep]
    breaks[-1] = u[-1]
    lanes = lanes_of(within, breaks, at, mark)
    inside = sum(_area(ruled, *lane.limits(lane.dense())) for lane in lanes)
    pieces = [p for lane in lanes if (p := _piece(lane, lanes, rules, mark)) is not None]
    return Trimmed(tuple(pieces), area, float(inside), len(lanes) - len(pieces))


def _piece(lane: Lane, lanes: Sequence[Lane], rules: Rules, mark: str) -> Piece | None:
    """The piece made of a lane: joints to the next ones and tips taken off."""
    ruled = lane.within.ruled
    ends, joined = [lane.u0, lane.u1], [False, False]
    for k, (u, sign) in enumerate(((lane.u0, 1.0), (lane.u1, -1.0))):
        if u in (ruled.u0, ruled.u1):
            continue
        beyond = [o for o in lanes if o is not lane and (o.u1, o.u0)[k] == u and meet(o, lane, u)]
        joined[k] = bool(beyond)
        twins = [o for o in lanes if o is not lane and (o.u0, o.u1)[k] == u]
        touched = len(beyond) != 1 or any(meet(o, b, u) for b in beyond for o in twins)
        step = max(rules.joint / 2.0, TOUCH if touched else 0.0) if joined[k] else 0.0
        ends[k] = u + sign * step / pace(ruled, u)
    if ends[1] - ends[0] <= 0.0:
        return None
    u = np.unique(np.concatenate([np.linspace(ends[0], ends[1], 33), lane.u]))
    u = u[(u >= ends[0]) & (u <= ends[1])]
    enough = lane.widths(u) >= rules.shortest
    if not enough.any():
        return None
    begin, end = _longest(enough)
    low = ends[0] if begin == 0 else _shrunk(lane, u[begin], u[begin - 1], rules.shortest)
    high = ends[1] if end == len(u) else _shrunk(lane, u[end - 1], u[end], rules.shortest)
    if pace(ruled, (low + high) / 2.0) * (high - low) < rules.least:
        return None
    made = _through(lane, float(low), float(high), mark)
    _, at_low, at_high = lane.limits(np.array([low, high]))
    spans = tuple((float(a), float(b)) for a, b in zip(at_low, at_high, strict=True))
    between = (lane.u0, lane.u1)
    return Piece(made, lane.cut, (spans[0], spans[1]), (joined[0], joined[1]), between)


def _shrunk(lane: Lane, good: float, bad: float, least: float) -> float:
    """Where the rulings of a lane are as long as the least between two u."""
    for _ in range(6):
        u = np.linspace(good, bad, 17)
        k = int(np.argmin(lane.widths(u)[1:] >= least))
        good, bad = float(u[k]), float(u[k + 1])
    return good


def _through(lane: Lane, u0: float, u1: float, mark: str) -> RuledPatch:
    """Both edges interpolated, knot spans parted where they leave the boundary."""
    own = lane.within.ruled.knots
    tiny = 1e-3 * (u1 - u0) if any(lane.cut) else 0.0  # no slivers of spans but on exact parts
    knots = np.concatenate([[u0] * 4, own[(own > u0 + tiny) & (own < u1 - tiny)], [u1] * 4])
    off = np.inf
    for _ in range(ROUNDS):
        sites = np.clip(spline.greville(knots), u0, u1)
        spans = np.unique(knots)
        checks = spans[:-1, None] + CHECKS * np.diff(spans)[:, None]
        points = _ends(lane, np.concatenate([sites, checks.ravel()]))
        made = RuledPatch.through(knots, sites, *points[:, : len(sites)])
        away = np.linalg.norm(made.edges(checks.ravel()) - points[:, len(sites) :], axis=-1)
        error = away.max(axis=0).reshape(checks.shape).max(axis=1)
        off = float(error.max())
        if off <= TOLERANCE:
            return made
        if len(spans) > MOST_SPANS:
            break
        bad, parts = error > TOLERANCE, np.where(error > 16.0 * TOLERANCE, 3, 2)
        fresh = [
            np.linspace(spans[k], spans[k + 1], int(parts[k]) + 1)[1:-1]
            for k in np.flatnonzero(bad)
        ]
        knots = np.sort(np.concatenate([knots, *fresh]))
    raise GeometryError(
        mark,
        f"its edge along the boundary can't be followed to {TOLERANCE:g} mm (found {off:.3g})",
        "smooth the boundary there, or leave the panel whole: panels.trim = false",
    )


def _ends(lane: Lane, u: Array) -> Array:
    """Points (2, k, 3) of both edges."""
    _, low, high = lane.limits(u)
    a, b = lane.within.ruled.edges(u)
    return np.stack([a + low[:, None] * (b - a), a + high[:, None] * (b - a)])


def _longest(good: BoolArray) -> tuple[int, int]:
    """Begin and end (exclusive) of the longest run of True."""
    step = np.diff(np.concatenate([[0], good.astype(np.int64), [0]]))
    begin, end = np.flatnonzero(step == 1), np.flatnonzero(step == -1)
    k = int(np.argmax(end - begin))
    return int(begin[k]), int(end[k])


def _area(ruled: RuledPatch, u: Array, low: Array, high: Array) -> float:
    """Area between v = low and v = high, by triangles."""
    a, b = ruled.edges(u)
    first, second = a + low[:, None] * (b - a), a + high[:, None] * (b - a)
    p, q, r, s = first[:-1], first[1:], second[:-1], second[1:]
    halves = cross(q - p, r - p), cross(r - s, q - s)
    return float(sum(np.linalg.norm(h, axis=1).sum() for h in halves) / 2.0)
