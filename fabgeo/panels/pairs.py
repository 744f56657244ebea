"""All pairs of candidates across joints, and which of them keep the limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import BoolArray, IntArray
from fabgeo.panels.joints import Joints, compare, made_boundary
from fabgeo.panels.limits import Costs, Tolerances
from fabgeo.panels.pool import Pool

_CHUNK = 40000


@dataclass(frozen=True)
class Pairs:
    """Pairs of candidates across joints.

    Attributes
    ----------
    joint, first, second : (n,) int arrays
        Joint, and the candidates of its first and second panel.
    holds : (n,) bool array
        Whether gap and added kink are within their limits.
    candidates : int
        How many candidates the pool had.
    """

    joint: IntArray
    first: IntArray
    second: IntArray
    holds: BoolArray
    candidates: int

    def among(self, index: IntArray) -> Pairs:
        """Those of some candidates (in ascending order), numbered by their place there."""
        place = np.full(self.candidates, -1, dtype=np.int64)
        place[index] = np.arange(len(index))
        first, second = place[self.first], place[self.second]
        kept = (first >= 0) & (second >= 0)
        return Pairs(self.joint[kept], first[kept], second[kept], self.holds[kept], len(index))


def pairs_of(
    pool: Pool, joints: Joints, tolerances: Tolerances, known: Pairs | None = None
) -> Pairs:
    """All pairs; those of a smaller pool that this one begins with are taken over."""
    old = known.candidates if known else 0
    joint, first, second = _combinations(pool, joints, old)
    holds = np.empty(len(joint), dtype=bool)
    # A boundary is needed once for every joint, side and candidate: number them.
    slots = []
    for side, candidate in ((0, first), (1, second)):
        key, where = np.unique(joint * len(pool) + candidate, return_inverse=True)
        j, c = np.divmod(key, len(pool))
        made = made_boundary(
            pool.carriers[c],
            pool.replaced[c],
            joints.points[j],
            joints.normals[side, j],
            joints.ends[j],
        )
        slots.append((made, where))
    own = joints.own
    for begin in range(0, len(joint), _CHUNK):
        part = slice(begin, begin + _CHUNK)
        sides = [(made[0][at[part]], made[1][at[part]]) for made, at in slots]
        holds[part] = tolerances.holds(*compare(sides[0], sides[1], own[joint[part]]))
    if known:
        joint = np.concatenate([known.joint, joint])
        first = np.concatenate([known.first, first])
        second = np.concatenate([known.second, second])
        holds = np.concatenate([known.holds, holds])
    # Two panels as fitted keep every limit by definition: nothing was added.
    holds |= ~pool.replaced[first] & ~pool.replaced[second]
    return Pairs(joint, first, second, holds, len(pool))


def _combinations(pool: Pool, joints: Joints, old: int) -> tuple[IntArray, IntArray, IntArray]:
    """Every joint with every candidate of either side, one of the two at least not `old`."""
    order = np.argsort(pool.panel, kind="stable")
    count = np.bincount(pool.panel)
    start = np.concatenate([[0], np.cumsum(count)])
    a, b = joints.panels[:, 0], joints.panels[:, 1]
    number = count[a] * count[b]
    joint = np.repeat(np.arange(len(joints)), number)
    within = np.arange(number.sum()) - np.repeat(np.cumsum(number) - number, number)
    i, j = np.divmod(within, count[b][joint])
    first, second = order[start[a[joint]] + i], order[start[b[joint]] + j]
    keep = (first >= old) | (second >= old)
    keep &= (a != b)[joint] | (first == second)  # a ring of one panel meets itself
    return joint[keep], first[keep], second[keep]


def greedy(pool: Pool, pairs: Pairs, costs: Costs) -> IntArray:
    """Candidate of every panel chosen panel by panel, (p,).

    In the order of the panels each takes its cheapest candidate (the closest among equals) that
    keeps the limits beside its neighbours: those before it as chosen, those after it as fitted,
    so that each of them still can stay as it is.
    """
    fitted = np.flatnonzero(~pool.replaced)
    chosen = np.empty(len(fitted), dtype=np.int64)
    chosen[pool.panel[fitted]] = fitted
    bad = ~pairs.holds
    excluded: dict[int, list[int]] = {}
    for a, b in zip(pairs.first[bad].tolist(), pairs.second[bad].tolist(), strict=True):
        excluded.setdefault(a, []).append(b)
        excluded.setdefault(b, []).append(a)
    picked = np.zeros(len(pool), dtype=bool)
    picked[chosen] = True
    for c in np.lexsort((pool.bound, costs.of(pool), pool.panel)):
        p = pool.panel[c]
        if picked[c] and not pool.replaced[c]:
            continue  # nothing cheaper was found before it
        if not pool.replaced[chosen[p]] and not picked[excluded.get(int(c), [])].any():
            picked[chosen[p]] = False
            chosen[p] = c
            picked[c] = True
    return chosen
