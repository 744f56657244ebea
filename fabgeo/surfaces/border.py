"""The border of a surface of many faces: what is shared, what is free, and how faces turn.

Glossary
--------
border
    The trimming loops of all faces as one list of short segments in space.
shared
    A segment along which another face (or the same face, at a seam) continues.
free
    A segment that is not shared: together they are the surface's boundary loops.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from fabgeo.arrays import Array, BoolArray, IntArray, dot, unit
from fabgeo.errors import InputError
from fabgeo.surfaces.chart import Chart
from fabgeo.surfaces.trims import Trim, chords, resampled

OF_ITS_OWN, OF_ANOTHER = 24, 4  # nearest segments of a loop that are looked at


@dataclass(frozen=True, eq=False)
class Border:
    """Segments k of all loops: from point[k] to end[k], parameters uv[k] to uv_end[k] of face[k].

    Attributes
    ----------
    point, end : (k, 3) arrays
    uv, uv_end : (k, 2) arrays
    face : (k,) int array
    loop : (k,) int array
        Running number of the trimming loop; segments of one loop follow each other.
    free : (k,) bool array
    partner : (k,) int array
        The segment of another loop, or farther on in the same one, that runs along it; else -1.
    sign : (faces,) array
        +1 or -1: factors that turn all faces the same way.
    loops : tuple of (k, 3) arrays
        Free boundary loops.
    """

    point: Array
    end: Array
    uv: Array
    uv_end: Array
    face: IntArray
    loop: IntArray
    free: BoolArray
    partner: IntArray
    sign: Array
    loops: tuple[Array, ...]

    @classmethod
    def of(
        cls,
        charts: Sequence[Chart],
        trims: Sequence[Trim],
        size: float,
        tol: float,
        name: str = "surface",
    ) -> Border:
        """The border of charts with trims; segments are at most size / 300 long.

        Raises
        ------
        InputError
            If all loops are points beside the size: some point lies far off.
        """
        uv: list[Array] = []
        uv_end: list[Array] = []
        face: list[IntArray] = []
        loop: list[IntArray] = []
        count = 0
        for i, (chart, trim) in enumerate(zip(charts, trims, strict=True)):
            for polyline in trim.loops:
                dense = resampled(chart, polyline, size / 300.0)
                uv.append(dense)
                uv_end.append(np.roll(dense, -1, axis=0))
                face.append(np.full(len(dense), i))
                loop.append(np.full(len(dense), count))
                count += 1
        a, b = np.concatenate(uv), np.concatenate(uv_end)
        f, n = np.concatenate(face), np.concatenate(loop)
        point, end = chords(charts, f, a), chords(charts, f, b)
        keep = np.linalg.norm(end - point, axis=1) > 1e-9 * size  # no segments inside a pole
        if not keep.any():
            cure = "look for points far off the others, and take them out"
            raise InputError(name, f"its border is a point beside its size of {size:.3g} mm", cure)
        a, b, f, n, point, end = a[keep], b[keep], f[keep], n[keep], point[keep], end[keep]
        middle = chords(charts, f, (a + b) / 2.0)
        partner = _partners(point, end, middle, f, n, tol)
        free = (partner < 0) & ~_seams(charts, f, (a + b) / 2.0)
        free = _without_crumbs(free, n, np.linalg.norm(end - point, axis=1), size / 150.0)
        sign = _signs(len(charts), point, end, f, partner)
        loops = _chained(point, end, n, free, sign[f], size / 100.0)
        return cls(point, end, a, b, f, n, free, partner, sign, loops)

    @cached_property
    def _tree(self) -> KDTree:
        return KDTree((self.point + self.end) / 2.0)

    def nearest(self, x: Array) -> tuple[IntArray, Array, Array, BoolArray]:
        """Nearest border points of x (k, 3): face, parameters, distance, whether free."""
        count = min(4, len(self.point))
        _, near = self._tree.query(x, k=count)
        near = near.reshape(len(x), count)
        t, distance = _to_segments(x[:, None], self.point[near], self.end[near])
        pick = np.argmin(distance, axis=1)
        rows = np.arange(len(x))
        segment = near[rows, pick]
        s = t[rows, pick][:, None]
        uv = self.uv[segment] + s * (self.uv_end[segment] - self.uv[segment])
        return self.face[segment], uv, distance[rows, pick], self.free[segment]


def _to_segments(x: Array, a: Array, b: Array) -> tuple[Array, Array]:
    """Parameter in [0, 1] of the closest point on segments a b, and the distance."""
    along = b - a
    t = np.clip(dot(x - a, along) / np.maximum(dot(along, along), 1e-300), 0.0, 1.0)
    return t, np.linalg.norm(a + t[..., None] * along - x, axis=-1)


def _partners(
    point: Array, end: Array, middle: Array, face: IntArray, loop: IntArray, tol: float
) -> IntArray:
    """For every segment another one that runs along the same curve, or -1.

    Each loop is compared with each whose box it meets: however long or short their segments are,
    a few nearest of the other loop are enough.
    """
    sag = np.linalg.norm(middle - (point + end) / 2.0, axis=1)
    along = unit(end - point)
    best, distance = np.full(len(point), -1), np.full(len(point), np.inf)
    members = [np.flatnonzero(loop == n) for n in range(int(loop.max()) + 1)]
    members = [rows for rows in members if len(rows)]
    trees = [KDTree((point[rows] + end[rows]) / 2.0) for rows in members]
    reach = [tol + 2.0 * float(sag[rows].max()) for rows in members]
    boxes = np.array([[point[rows].min(axis=0), point[rows].max(axis=0)] for rows in members])
    for a, mine in enumerate(members):
        for b, theirs in enumerate(members):
            far = reach[a] + reach[b]
            low, high = boxes[b, 0] - far, boxes[b, 1] + far
            rows = mine[((middle[mine] >= low) & (middle[mine] <= high)).all(axis=1)]
            if not len(rows):
                continue
            count = min(OF_ITS_OWN if a == b else OF_ANOTHER, len(theirs))
            near = theirs[trees[b].query(middle[rows], k=count)[1].reshape(len(rows), -1)]
            _, gap = _to_segments(middle[rows, None], point[near], end[near])
            fits = np.abs(dot(along[rows, None], along[near])) > 0.9
            fits &= gap < tol + 2.0 * np.maximum(sag[near], sag[rows, None])
            if a == b:  # not the segments next to it
                apart = np.abs(near - rows[:, None])
                apart = np.minimum(apart, len(mine) - apart)
                fits &= apart > min(5, len(mine) // 4)
            gap = np.where(fits, gap, np.inf)
            pick = np.argmin(gap, axis=1)
            least = gap[np.arange(len(rows)), pick]
            closer = least < distance[rows]
            best[rows[closer]] = near[np.arange(len(rows)), pick][closer]
            distance[rows[closer]] = least[closer]
    return best


def _without_crumbs(free: BoolArray, loop: IntArray, length: Array, short: float) -> BoolArray:
    """Flags with short runs between long ones of the other kind turned over.

    Where more than two faces meet, or an export left a gap, a few segments find no partner.
    """
    cleaned = free.copy()
    for n in np.unique(loop):
        rows = np.flatnonzero(loop == n)
        for kind in (True, False):
            flags = cleaned[rows] == kind
            if flags.all() or not flags.any():
                continue
            first = int(np.flatnonzero(~flags)[0])
            turned, flags = np.roll(rows, -first), np.roll(flags, -first)
            run = np.cumsum(np.diff(flags, prepend=False) != 0)
            total = np.bincount(run, length[turned])
            cleaned[turned[flags & (total[run] < short)]] = not kind
    return cleaned


def _seams(charts: Sequence[Chart], face: IntArray, middle: Array) -> BoolArray:
    """Segments along the side at which a periodic chart closes on itself."""
    seam = np.zeros(len(face), dtype=bool)
    for i, chart in enumerate(charts):
        for axis in (0, 1):
            if chart.closed[axis]:
                low, high = chart.domain[axis]
                at, reach = middle[:, axis], 1e-9 * (high - low)
                seam |= (face == i) & ((np.abs(at - low) < reach) | (np.abs(at - high) < reach))
    return seam


def _signs(faces: int, point: Array, end: Array, face: IntArray, partner: IntArray) -> Array:
    """Loops have their face on the left, so equal turn means opposite directions along an edge."""
    vote = np.zeros((faces, faces))
    rows = np.flatnonzero(partner >= 0)
    other = partner[rows]
    same = -dot(end[rows] - point[rows], unit(end[other] - point[other]))
    np.add.at(vote, (face[rows], face[other]), same)
    vote = vote + vote.T
    np.fill_diagonal(vote, 0.0)
    sign = np.zeros(faces)
    for seed in range(faces):
        if sign[seed]:
            continue
        sign[seed], queue = 1.0, [seed]
        while queue:
            i = queue.pop()
            for j in np.flatnonzero(vote[i]):
                if not sign[j]:
                    sign[j] = sign[i] * np.sign(vote[i, j])
                    queue.append(int(j))
    return sign


def _chained(
    point: Array, end: Array, loop: IntArray, free: BoolArray, sign: Array, reach: float
) -> tuple[Array, ...]:
    """Runs of free segments joined end to start into closed loops."""
    runs: list[Array] = []
    closed: list[Array] = []
    for n in np.unique(loop):
        rows = np.flatnonzero(loop == n)
        flags = free[rows]
        if flags.all():
            closed.append(point[rows] if sign[rows[0]] > 0 else point[rows][::-1])
            continue
        if not flags.any():
            continue
        first = int(np.flatnonzero(~flags)[0])
        rows, flags = np.roll(rows, -first), np.roll(flags, -first)
        starts = np.flatnonzero(flags & ~np.roll(flags, 1))
        for s in starts:
            stop = s + int(np.argmax(np.append(~flags[s:], True)))
            line = np.concatenate([point[rows[s:stop]], end[rows[stop - 1 : stop]]])
            runs.append(line if sign[rows[s]] > 0 else line[::-1])
    while runs:
        chain = runs.pop(0)
        while runs:
            gaps = [float(np.linalg.norm(r[0] - chain[-1])) for r in runs]
            best = int(np.argmin(gaps))
            home = float(np.linalg.norm(chain[0] - chain[-1]))
            if gaps[best] > reach or home <= gaps[best]:
                break
            joined = runs.pop(best)
            chain = np.concatenate([chain, joined[1:] if gaps[best] < 1e-6 * reach else joined])
        if np.linalg.norm(chain[0] - chain[-1]) < 1e-3 * reach and len(chain) > 3:
            chain = chain[:-1]
        closed.append(chain)
    return tuple(closed)
