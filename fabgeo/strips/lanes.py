"""Spans of rulings followed along a patch: lanes, whose ends are smooth functions of u.

Glossary
--------
lane
    One span between two events, or over several that leave its ends smooth. Lanes part where the
    boundary crosses an edge curve, touches a ruling, or has a corner.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.errors import GeometryError
from fabgeo.strips.ruled import RuledPatch
from fabgeo.strips.within import Within

TESTED = 8  # rulings tested in a knot span


@dataclass
class Lane:
    """One span followed from u0 to u1, its ends smooth and of one kind each."""

    within: Within
    cut: tuple[bool, bool]
    u: Array  # tested, with the spans found there
    low: Array
    high: Array
    u0: float
    u1: float

    def limits(self, u: Array) -> tuple[Array, Array, Array]:
        """Parameters u and the span's ends there."""
        spans = self.within.spans(u)
        middle = np.interp(u, self.u, (self.low + self.high) / 2.0)
        out = np.empty((2, len(u)))
        for k, own in enumerate(spans):
            alike = [span for span in own if (span[0] > 0.0, span[1] < 1.0) == self.cut]
            near = alike or [span for span in own if span[0] <= middle[k] <= span[1]]
            if not near:  # a tip's own ruling
                out[:, k] = middle[k] if all(self.cut) else float(self.cut[0])
                continue
            off = [max(low - middle[k], middle[k] - high) for low, high in near]
            out[:, k] = near[int(np.argmin(off))]
        for row, cut, end in zip(out, self.cut, (0.0, 1.0), strict=True):
            if not cut:
                row[:] = end
        return u, out[0], out[1]

    def dense(self, count: int = 65) -> Array:
        """Parameters that are close together at both ends."""
        t = (1.0 - np.cos(np.linspace(0.0, np.pi, count))) / 2.0
        return self.u0 + (self.u1 - self.u0) * t

    def widths(self, u: Array) -> Array:
        """Lengths of its rulings."""
        _, low, high = self.limits(u)
        a, b = self.within.ruled.edges(u)
        return (high - low) * np.linalg.norm(b - a, axis=1)


def lanes_of(within: Within, breaks: Array, corners: Array, mark: str) -> list[Lane]:
    """All spans, followed over events that leave their ends smooth."""
    done: list[Lane] = []
    open_: list[Lane] = []
    for low, high in pairwise(breaks):
        t = (np.arange(9) + 0.5) / 9.0
        u = low + (high - low) * t
        every = within.spans(u)
        count = len(every[4])
        if any(len(spans) != count for spans in every):
            raise GeometryError(
                mark,
                f"the boundary winds about its rulings between u = {low:.6g} and {high:.6g}",
                "cut shorter panels, or smooth the boundary",
            )
        fresh = []
        for k in range(count):
            ends = np.array([spans[k] for spans in every])
            cut = (bool(ends[4, 0] > 0.0), bool(ends[4, 1] < 1.0))
            fresh.append(Lane(within, cut, u, ends[:, 0], ends[:, 1], float(low), float(high)))
        here = corners[np.abs(corners[:, 0] - low) < 1e-6 * (breaks[-1] - breaks[0])]
        still: list[Lane] = []
        for lane in fresh:
            before = next((o for o in open_ if _runs_on(o, lane, here[:, 1])), None)
            if before is None:
                still.append(lane)
                continue
            open_.remove(before)
            still.append(Lane(
                within, lane.cut, np.append(before.u, lane.u), np.append(before.low, lane.low),
                np.append(before.high, lane.high), before.u0, lane.u1,
            ))  # fmt: skip
        done += open_
        open_ = still
    return sorted(done + open_, key=lambda lane: (lane.u0, lane.low[0]))


def _runs_on(before: Lane, lane: Lane, corners: Array) -> bool:
    """Whether a lane is the one before it continued, with no corner of the boundary between."""
    if before.cut != lane.cut:
        return False
    at, step = lane.u0, 1e-6 * (lane.u1 - before.u0)
    _, low0, high0 = before.limits(np.array([at - step]))
    _, low1, high1 = lane.limits(np.array([at + step]))
    ends = np.array([low1[0], high1[0]])
    if np.abs(ends - [low0[0], high0[0]]).max() > 1e-2:
        return False
    near = np.abs(corners[:, None] - ends) < 0.02
    return not bool((near & np.array(lane.cut)).any())


def meet(one: Lane, other: Lane, u: float) -> bool:
    """Whether two lanes have a part of the ruling at u in common."""
    spans = []
    for lane in (one, other):
        step = 1e-6 * (lane.u1 - lane.u0)
        _, low, high = lane.limits(np.array([np.clip(u, lane.u0 + step, lane.u1 - step)]))
        spans.append((low[0], high[0]))
    return bool(min(spans[0][1], spans[1][1]) - max(spans[0][0], spans[1][0]) > 1e-3)


def pace(ruled: RuledPatch, u: float) -> float:
    """The slower of both edges' speeds across the ruling at u."""
    at = np.array([u])
    a, b = ruled.edges(at)
    e, velocity = unit(b - a), ruled.edges(at, 1)
    return float(np.linalg.norm(velocity - dot(velocity, e)[..., None] * e, axis=-1).min())


def corners_on(ruled: RuledPatch, corners: Array) -> Array:
    """Parameters (k, 2) of the boundary's corners on the patch, seen along the surface's normals.

    Depth is seen that way too: where the boundary runs along the rulings up to its corner, a
    corner beside the last ruling that ends there would leave a leap in the lane's end.
    """
    u = ruled.parameters(TESTED)
    a, b = ruled.edges(u)
    size = float(np.linalg.norm(b - a, axis=1).mean())
    out = []
    for corner, normal in corners:
        if np.linalg.norm(np.concatenate([a, b]) - corner, axis=1).min() > 4.0 * size:
            continue
        side = _beyond(ruled, corner, normal, u)
        (change,) = np.nonzero((side[1:] >= 0.0) != (side[:-1] >= 0.0))
        for k in change:
            low, high = u[k], u[k + 1]
            for _ in range(60):
                middle = (low + high) / 2.0
                here = _beyond(ruled, corner, normal, np.array([middle]))[0]
                low, high = (middle, high) if (here >= 0.0) == (side[k] >= 0.0) else (low, middle)
            p, q = ruled.edges(np.array([low]))[:, 0]
            flat = q - p - dot(q - p, normal) * normal
            v = float((corner - p) @ flat / (flat @ flat))
            off = float(np.linalg.norm(corner - p - v * (q - p)))
            if 0.0 < v < 1.0 and off < size:  # panels at an offset lie beside the surface
                out.append((low, v))
    return np.array(out).reshape(-1, 2)


def _beyond(ruled: RuledPatch, point: Array, normal: Array, u: Array) -> Array:
    """How far a point lies beside the rulings at u, seen along a normal."""
    a, b = ruled.edges(u)
    return dot(point - a, unit(cross(normal, b - a)))
