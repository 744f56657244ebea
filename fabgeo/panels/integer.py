"""The integer choice: one candidate a panel, least cost, no pair beyond a limit (HiGHS).

Binary x_c for every candidate, ``sum over a panel's candidates = 1``, and for every set C of one
panel's candidates that share the same set I of candidates they cannot stand beside across a joint,
``sum over C + sum over I <= 1``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_array

from fabgeo.arrays import Array, IntArray
from fabgeo.panels.pairs import Pairs


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
        "optimal", or "time limit".
    """

    chosen: IntArray
    cost: float
    bound: float
    status: str


def solve(
    panel: IntArray, cost: Array, pairs: Pairs, incumbent: IntArray, seconds: float = 20.0
) -> IntegerChoice:
    """Choose one candidate a panel.

    Parameters
    ----------
    panel : (c,) int array
        Panel of every candidate; every panel has one at least.
    cost : (c,) array
    incumbent : (p,) int array
        A choice that keeps the limits: returned where the time ends before a better one is found.
    seconds : float
        Time limit.
    """
    count, panels = len(panel), int(panel.max()) + 1
    one = csr_array((np.ones(count), (panel, np.arange(count))), shape=(panels, count))
    constraints = [LinearConstraint(one, 1.0, 1.0)]  # pyright: ignore[reportArgumentType]
    conflicts = _conflicts(pairs, count)
    if conflicts.shape[0]:
        constraints.append(LinearConstraint(conflicts, -np.inf, 1.0))  # pyright: ignore[reportArgumentType]
    found = milp(
        cost,
        integrality=np.ones(count),
        bounds=Bounds(0.0, 1.0),
        constraints=constraints,
        options={"time_limit": seconds, "mip_rel_gap": 1e-4},
    )
    chosen, status = incumbent, "time limit"
    if found.x is not None:
        picked = np.flatnonzero(found.x > 0.5)
        candidate = np.empty(panels, dtype=np.int64)
        candidate[panel[picked]] = picked
        if cost[candidate].sum() <= cost[incumbent].sum():
            chosen = candidate
        status = "optimal" if found.status == 0 else "time limit"
    bound = found.mip_dual_bound
    least = np.full(panels, np.inf)
    np.minimum.at(least, panel, cost)
    bound = float(least.sum()) if bound is None or not np.isfinite(bound) else float(bound)
    return IntegerChoice(chosen, float(cost[chosen].sum()), bound, status)


def _conflicts(pairs: Pairs, count: int) -> csr_array:
    """Rows of the conflict constraints over the candidates."""
    bad = ~pairs.holds
    if not bad.any():
        return csr_array((0, count))
    joint, first, second = pairs.joint[bad], pairs.first[bad], pairs.second[bad]
    rows: list[IntArray] = []
    order = np.argsort(joint, kind="stable")
    joint, first, second = joint[order], first[order], second[order]
    starts = np.flatnonzero(np.diff(joint, prepend=-1))
    for a, b in zip(starts, np.append(starts[1:], len(joint)), strict=True):
        rows += _cliques(first[a:b], second[a:b])
        rows += _cliques(second[a:b], first[a:b])
    unique = list({row.tobytes(): row for row in rows}.values())
    index = np.repeat(np.arange(len(unique)), [len(row) for row in unique])
    column = np.concatenate(unique)
    return csr_array((np.ones(len(column)), (index, column)), shape=(len(unique), count))


def _cliques(these: IntArray, those: IntArray) -> list[IntArray]:
    """Candidates of one panel grouped by the candidates they exclude, with those excluded."""
    one, row = np.unique(these, return_inverse=True)
    other, column = np.unique(those, return_inverse=True)
    excludes = np.zeros((len(one), len(other)), dtype=bool)
    excludes[row, column] = True
    groups: dict[bytes, list[int]] = {}
    for r, key in enumerate(map(bytes, excludes)):
        groups.setdefault(key, []).append(r)
    return [np.sort(np.concatenate([one[r], other[excludes[r[0]]]])) for r in groups.values()]
