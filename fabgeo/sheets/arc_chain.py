"""The fewest tangent-continuous arcs along a curve: reachable directions, joint by joint.

Glossary
--------
chain
    Arcs from end to end of a curve, each leaving in the direction in which the last arrived.
    Joints lie on the curve; both end directions are free.
tube
    All points within the tolerance of the curve.
reach
    The directions in which a chain of n arcs can arrive at a joint: intervals.

An arc over the chord from p to q that leaves p in direction a arrives at q in 2 c - a, where c is
the chord's direction. The arcs over one chord are nested, so those that stay in the tube leave in
an interval of directions: the largest of the lower and the least of the upper bounds that the
samples between set. Arriving intervals, cut with leaving ones, give the reach of one arc more
(compare the smooth minimum arc paths of Maier 2014, whose joints may leave the curve). Where the
curvature changes at the rate k', arcs of length h leave k' h^3 / (72 sqrt 3) between: joints on
the curve are the best there are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array

type Index = np.ndarray[tuple[int], np.dtype[np.intp]]
type _Level = tuple[Index, Array, Array]

COARSE, FINEST = 36, 768  # intervals between joints that are tried
PER_ARC = 12  # intervals an arc are fine enough
INNER = 28  # samples an arc is checked at
STEEPEST = np.tan(np.radians(80.0))  # of an arc against its chord


@dataclass(frozen=True)
class _Reach:
    """Disjoint intervals of directions, sorted by joint and direction."""

    joint: Index
    low: Array
    high: Array


@dataclass(frozen=True)
class _Arcs:
    """All arcs between two joints that stay in the tube: joints, chord, leaving directions."""

    start: Index
    end: Index
    chord: Array
    low: Array
    high: Array


def fewest_arcs(points: Array, tangents: Array, tolerance: float) -> tuple[Array, Index] | None:
    """Chain of the fewest arcs within `tolerance` of samples of a curve.

    Parameters
    ----------
    points, tangents : (n, 2) arrays
        Dense samples of the curve and unit tangents there.
    tolerance : float
        Largest distance of a sample from the chain.

    Returns
    -------
    vertices : (k, 3) array
        x, y of every arc's start and its bulge.
    joints : (k + 1,) array
        Samples where arcs begin and the last ends. None if there is no chain through the samples.
    """
    best: tuple[Array, Index] | None = None
    last, intervals = len(points) - 1, COARSE
    turned = np.unwrap(np.arctan2(tangents[:, 1], tangents[:, 0]))
    window = 1.0  # of the curve's samples, that an arc can span
    while True:
        intervals = min(intervals, max(1, last // 2))
        joints = np.unique(np.linspace(0, last, intervals + 1).round().astype(int))
        arcs = _arcs(points, turned, joints, window, tolerance)
        made = _chain(len(joints) - 1, arcs)
        if made is not None and (best is None or len(made[0]) <= len(best[0])):
            bulges, starts = made
            own = joints[starts]
            best = np.column_stack([points[own], bulges]), np.append(own, last)
        most = 1 if best is None else len(best[0])
        enough = best is not None and intervals >= PER_ARC * most
        if enough or intervals >= min(FINEST, last // 2):
            return best
        if len(arcs.start):
            window = float(np.max(arcs.end - arcs.start) + 2) / intervals
        intervals = max(2 * intervals, PER_ARC * most)


def _arcs(points: Array, turned: Array, joints: Index, window: float, tolerance: float) -> _Arcs:
    """Every arc between two joints at most `window` of the curve apart that stays in the tube."""
    count = len(joints) - 1
    span = min(count, int(np.ceil(window * count)))
    first, step = np.meshgrid(np.arange(count), np.arange(1, span + 1), indexing="ij")
    inside = first + step <= count
    first, end = first[inside], (first + step)[inside]
    p, q = points[joints[first]], points[joints[end]]
    chord, angle = q - p, turned[joints[first]]
    size = np.maximum(np.hypot(chord[:, 0], chord[:, 1]), 1e-9 * tolerance)
    away = np.arctan2(chord[:, 1], chord[:, 0]) - angle
    direction = angle + np.remainder(away + np.pi, 2.0 * np.pi) - np.pi
    low, high = _slopes(points, joints, first, end, chord / size[:, None], size, tolerance)
    fits = low <= high
    return _Arcs(
        first[fits],
        end[fits],
        direction[fits],
        (direction + np.arctan(low))[fits],
        (direction + np.arctan(high))[fits],
    )


def _slopes(
    points: Array,
    joints: Index,
    first: Index,
    end: Index,
    along: Array,
    size: Array,
    tolerance: float,
) -> tuple[Array, Array]:
    """Least and greatest slope against their chords of arcs within the tolerance of all samples.

    An arc of slope T over a chord c is within t of the point (x, y) of the chord's frame where
    |T (x - (x^2 + y^2 - t^2) / c) - y| <= t sqrt(1 + T^2).
    """
    share = np.arange(1, INNER) / INNER
    p, q = joints[first][:, None], joints[end][:, None]
    between = p + np.round(share * (q - p)).astype(int)
    w = points[between] - points[p]
    c, s, size = along[:, None, 0], along[:, None, 1], size[:, None]
    x, y = w[..., 0] * c + w[..., 1] * s, w[..., 1] * c - w[..., 0] * s
    square = x * x + y * y
    lever = x - (square - tolerance**2) / size
    held = lever > 1e-3 * tolerance
    over = 1.0 / np.where(held, lever, 1.0)
    middle = np.where(held, y * over, 0.0)
    flat = np.maximum(np.abs(middle) - tolerance * over, 0.0)
    half = np.where(held, tolerance * over * np.sqrt(1.0 + flat * flat), np.inf)
    # Beside the ends is no lever: near them every arc is near; far off none is (a half circle).
    far = np.minimum(square, square + size * (size - 2.0 * x)) > tolerance**2
    half[~held & far] = -np.inf
    low = np.maximum((middle - half).max(axis=1), -STEEPEST)
    high = np.minimum((middle + half).min(axis=1), STEEPEST)
    return low, high


def _chain(last: int, arcs: _Arcs) -> tuple[Array, Index] | None:
    """Bulges and first joints of the fewest arcs that lead from joint 0 to the last."""
    reach = _Reach(np.zeros(1, np.intp), np.array([-np.inf]), np.array([np.inf]))
    levels: list[_Level] = []
    while last not in reach.joint:
        # Every arc with every interval of its first joint.
        begin = np.searchsorted(reach.joint, arcs.start)
        count = np.searchsorted(reach.joint, arcs.start, side="right") - begin
        which = np.repeat(np.arange(len(arcs.start)), count)
        own = np.arange(len(which)) - np.repeat(np.cumsum(count) - count - begin, count)
        low = np.maximum(arcs.low[which], reach.low[own])
        high = np.minimum(arcs.high[which], reach.high[own])
        (possible,) = np.nonzero(low <= high)
        if not len(possible) or len(levels) >= last:
            return None
        which, low, high = which[possible], low[possible], high[possible]
        turned = 2.0 * arcs.chord[which]
        levels.append((which, turned - high, turned - low))
        reach = _merged(arcs.end[which], turned - high, turned - low)
    return _back(last, arcs, levels)


def _merged(joint: Index, low: Array, high: Array) -> _Reach:
    """Unions of the intervals at every joint, sorted by joint and direction."""
    order = np.lexsort((low, joint))
    joint, low, high = joint[order], low[order], high[order]
    # A running maximum for each joint by itself: those of one joint lie far from the next's.
    apart = (
        2.0
        * float(np.ptp(high) + np.ptp(low) + np.max(high) - np.min(low) + 1.0)
        * joint.astype(float)
    )
    top = np.maximum.accumulate(high + apart) - apart
    fresh = np.append(True, (joint[1:] != joint[:-1]) | (low[1:] > top[:-1]))
    (at,) = np.nonzero(fresh)
    return _Reach(joint[at], low[at], top[np.append(at[1:], len(top)) - 1])


def _back(last: int, arcs: _Arcs, levels: list[_Level]) -> tuple[Array, Index]:
    """Walk back from the last joint, each time by the arc whose interval is met most centrally."""
    joint, arrive = last, None
    bulges, starts = [], []
    for which, low, high in reversed(levels):
        (at,) = np.nonzero(arcs.end[which] == joint)
        middle = (low[at] + high[at]) / 2.0
        wanted = middle if arrive is None else np.full(len(at), arrive)
        k = int(np.argmax(np.minimum(wanted - low[at], high[at] - wanted)))
        arc = which[at[k]]
        arrive = 2.0 * float(arcs.chord[arc]) - float(wanted[k])
        joint = int(arcs.start[arc])
        bulges.append(np.tan((float(arcs.chord[arc]) - arrive) / 2.0))
        starts.append(joint)
    return np.array(bulges[::-1]), np.array(starts[::-1])
