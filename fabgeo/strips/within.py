"""What of the rulings of a ruled patch lies inside a boundary, and where that changes its kind.

Glossary
--------
depth
    How far inside points (k, 3) lie, signed, exact near the boundary: see `fabgeo.strips.fence`.
span
    An interval of v, low to high, in which a ruling lies inside.
pattern
    For every span of a ruling, whether each of its ends is cut by the boundary, or is the
    ruling's own end.
event
    A u at which the pattern changes: the boundary crosses an edge curve, touches a ruling, or has
    a corner. Between events all ends of spans are smooth functions of u.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import elementwise

from fabgeo.arrays import Array, BoolArray, IndexArray
from fabgeo.strips.ruled import RuledPatch

type Depth = Callable[[Array], Array]
type Span = tuple[float, float]
type Pattern = tuple[tuple[bool, bool], ...]

ACROSS = 17  # places of a ruling that are tested
FINER = 8  # times as many where it comes close to the boundary and leaves again
LEAP = 0.1  # of a ruling: more between neighbours is looked into
ROUNDS = 8  # of halving there: where the boundary runs along rulings ends of spans move fast
SAME = 1e-9  # of the patch's u-interval: events are known to it


@dataclass(frozen=True)
class Within:
    """A ruled patch and the depth of its points."""

    ruled: RuledPatch
    depth: Depth

    def depths(self, u: Array, v: Array) -> Array:
        """Depth (k, m) of the points at v (m,) on the rulings at u (k,)."""
        a, b = self.ruled.edges(u)
        points = a[:, None] + v[:, None] * (b - a)[:, None]
        return self.depth(points.reshape(-1, 3)).reshape(len(u), len(v))

    def spans(self, u: Array) -> list[list[Span]]:
        """The spans of the rulings at u (k,), in ascending order."""
        out: list[list[Span]] = [[] for _ in u]
        for rows, v, depth in self._tested(u):
            inside = depth >= 0.0
            row, at = np.nonzero(inside[:, 1:] != inside[:, :-1])
            roots = self._roots(u[rows], row, v[at], v[at + 1])
            for k, place in enumerate(rows):
                own = roots[row == k].tolist()
                ends = ([0.0] if inside[k, 0] else []) + own + ([1.0] if inside[k, -1] else [])
                out[place] = list(zip(ends[::2], ends[1::2], strict=True))
        return out

    def patterns(self, u: Array) -> list[Pattern]:
        """The patterns of the rulings at u (k,)."""
        out: list[Pattern] = [() for _ in u]
        for rows, _, depth in self._tested(u):
            inside = depth >= 0.0
            count = (inside[:, 1:] != inside[:, :-1]).sum(axis=1)
            for k, place in enumerate(rows):
                first, last = bool(inside[k, 0]), bool(inside[k, -1])
                cut = [False] * first + [True] * int(count[k]) + [False] * last
                out[place] = tuple(zip(cut[::2], cut[1::2], strict=True))
        return out

    def _tested(self, u: Array) -> Iterator[tuple[IndexArray, Array, Array]]:
        """Rows of u, places v and depths there: most rulings coarsely, some finely."""
        v = np.linspace(0.0, 1.0, ACROSS)
        depth = self.depths(u, v)
        close = self._comes_close(u, depth)
        (far,), (near,) = np.nonzero(~close), np.nonzero(close)
        if len(far):
            yield far, v, depth[far]
        if len(near):
            fine = np.linspace(0.0, 1.0, FINER * (ACROSS - 1) + 1)
            yield near, fine, self.depths(u[near], fine)

    def _comes_close(self, u: Array, depth: Array) -> BoolArray:
        """Whether a ruling may cross the boundary and come back between two tested places."""
        a, b = self.ruled.edges(u)
        step = np.linalg.norm(b - a, axis=1) / (ACROSS - 1)
        size, side = np.abs(depth), np.sign(depth)
        inner = size[:, 1:-1]
        turns = (inner <= size[:, :-2]) & (inner <= size[:, 2:])
        alike = (side[:, 1:-1] == side[:, :-2]) & (side[:, 1:-1] == side[:, 2:])
        return (turns & alike & (inner < step[:, None])).any(axis=1)

    def _roots(self, u: Array, row: IndexArray, low: Array, high: Array) -> Array:
        if not len(row):
            return np.empty(0)
        a, b = self.ruled.edges(u)

        def depth(v: Array, k: Array) -> Array:
            at = k.astype(np.intp)
            return self.depth(a[at] + v[:, None] * (b - a)[at])

        found = elementwise.find_root(
            depth, (low, high), args=(row,), tolerances={"xatol": 1e-10, "xrtol": 0.0}
        )
        return np.asarray(found.x, dtype=np.float64)

    def events(self, u: Array) -> Array:
        """All events between the first and the last of ascending u (k,), where any is seen."""
        u = self._closer(u)
        seen = self.patterns(u)
        least = SAME * (u[-1] - u[0])
        todo = [
            (u[k], u[k + 1], seen[k], seen[k + 1])
            for k in range(len(u) - 1)
            if seen[k] != seen[k + 1]
        ]
        found: list[float] = []
        while todo:
            low, high = np.array([t[0] for t in todo]), np.array([t[1] for t in todo])
            after = [t[3] for t in todo]
            while np.any(high - low > least):
                middle = (low + high) / 2.0
                now = self.patterns(middle)
                same = np.array([p == t[2] for p, t in zip(now, todo, strict=True)])
                after = [old if s else new for s, old, new in zip(same, after, now, strict=True)]
                low, high = np.where(same, middle, low), np.where(same, high, middle)
            found += high.tolist()
            todo = [
                (h, t[1], new, t[3])
                for h, t, new in zip(high.tolist(), todo, after, strict=True)
                if new != t[3] and t[1] - h > least
            ]
        return np.unique(found)

    def _closer(self, u: Array) -> Array:
        """Ascending u (k,) with more between neighbours whose spans leap.

        Two spans may appear and join between two rulings that show one span each, or one and
        none: beside a corner where the boundary comes to run along the rulings.
        """
        for _ in range(ROUNDS):
            spans = self.spans(u)
            leaps = [_leap(here, there) > LEAP for here, there in pairwise(spans)]
            if not any(leaps):
                break
            u = np.sort(np.concatenate([u, ((u[1:] + u[:-1]) / 2.0)[leaps]]))
        return u


def _leap(here: list[Span], there: list[Span]) -> float:
    """How far an end of a span goes between two rulings, or how much more of one is inside."""
    if len(here) == len(there) > 0:
        return float(np.abs(np.subtract(there, here)).max())
    return abs(sum(high - low for low, high in here) - sum(high - low for low, high in there))
