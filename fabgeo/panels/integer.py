"""The integer choice: one candidate a panel, least cost, no pair beyond a limit (HiGHS).

Binary x_c for every candidate, ``sum over a panel's candidates = 1``, and for every set C of one
panel's candidates that share the same set I of candidates they cannot stand beside across a joint,
``sum over C + sum over I <= 1``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, vstack

from fabgeo.arrays import Array, IntArray
from fabgeo.panels.highs import Programme, solved
from fabgeo.panels.pairs import Pairs

NODES = 1000  # of the search for one choice


@dataclass(frozen=True)
class IntegerChoice:
    """Solution of one integer programme.

    Attributes
    ----------
    chosen : (p,) int array
        Candidate of every panel.
    cost : float
        Its cost.
    bound : float
        Proven: no choice among these candidates costs less.
    status : str
        "optimal", "node limit" or "time limit".
    """

    chosen: IntArray
    cost: float
    bound: float
    status: str


def solve(
    panel: IntArray, cost: Array, pairs: Pairs, incumbent: IntArray, seconds: float | None = None
) -> IntegerChoice:
    """Choose one candidate a panel.

    Parameters
    ----------
    panel : (c,) int array
        Panel of every candidate; every panel has one at least.
    cost : (c,) array
    incumbent : (p,) int array
        A choice that keeps the limits: returned where no better one is found.
    seconds : float, optional
        Limit by the clock; by default the work is limited (NODES), which is repeatable.
    """
    count, panels = len(panel), int(panel.max()) + 1
    one = csr_array((np.ones(count), (panel, np.arange(count))), shape=(panels, count))
    conflicts = _conflicts(pairs, count)
    low = np.concatenate([np.ones(panels), np.full(len(conflicts.indptr) - 1, -np.inf)])
    zeros, ones = np.zeros(count), np.ones(count)
    guess = zeros.copy()
    guess[incumbent] = 1.0
    found = solved(
        Programme(
            cost,
            csr_array(vstack([one, conflicts])),
            low,
            np.ones(len(low)),
            zeros,
            ones,
            whole=ones > 0.0,
            small=False,
            nodes=NODES,
            seconds=seconds,
        ),
        guess,
    )
    chosen = incumbent
    if found.x is not None:
        picked = np.flatnonzero(found.x > 0.5)
        candidate = np.empty(panels, dtype=np.int64)
        candidate[panel[picked]] = picked
        if cost[candidate].sum() <= cost[incumbent].sum():
            chosen = candidate
    least = np.full(panels, np.inf)
    np.minimum.at(least, panel, cost)
    bound = max(float(least.sum()), found.bound)
    return IntegerChoice(chosen, float(cost[chosen].sum()), bound, found.status)


def _conflicts(pairs: Pairs, count: int) -> csr_array:
    """Rows of the conflict constraints over the candidates.

    Sets are told apart by the sum of random 64-bit numbers, one a candidate.
    """
    bad = ~pairs.holds
    if not bad.any():
        return csr_array((0, count))
    joint, first, second = pairs.joint[bad], pairs.first[bad], pairs.second[bad]
    names = np.random.default_rng(0).integers(1, 2**63, count, dtype=np.uint64)
    rows, columns, before = [], [], 0
    for these, those in ((first, second), (second, first)):
        row, column, number = _cliques(joint, these, those, names)
        rows.append(row + before)
        columns.append(column)
        before += number
    row, column = np.concatenate(rows), np.concatenate(columns)
    name = np.zeros(before, dtype=np.uint64)
    np.add.at(name, row, names[column])
    _, kept = np.unique(name, return_index=True)
    rank = np.full(before, -1, dtype=np.int64)
    rank[kept] = np.arange(len(kept))
    use = rank[row] >= 0
    at = (rank[row[use]], column[use])
    return csr_array((np.ones(use.sum()), at), shape=(len(kept), count))


def _cliques(
    joint: IntArray, these: IntArray, those: IntArray, names: NDArray[np.uint64]
) -> tuple[IntArray, IntArray, int]:
    """Candidates of one panel grouped by the candidates they exclude, with those excluded.

    Entries as row and column, and the number of rows.
    """
    order = np.lexsort((these, joint))
    joint, these, those = joint[order], these[order], those[order]
    new = (np.diff(joint, prepend=-1) != 0) | (np.diff(these, prepend=-1) != 0)
    starts = np.flatnonzero(new)
    slot = np.cumsum(new) - 1
    key = np.empty(len(starts), dtype=[("joint", np.int64), ("name", np.uint64)])
    key["joint"], key["name"] = joint[starts], np.add.reduceat(names[those], starts)
    _, leader, group = np.unique(key, return_index=True, return_inverse=True)
    shown = leader[group[slot]] == slot  # the pairs of one candidate stand for the group's
    row = np.concatenate([group, group[slot[shown]]])
    return row, np.concatenate([these[starts], those[shown]]), len(leader)
