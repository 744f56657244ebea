"""Linear and integer programmes by HiGHS, limited by counts of work and never by the clock.

One thread and one seed each, so that the same programme has the same solution on every machine,
however busy; several programmes run side by side in threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from heapq import heappop, heappush

import highspy
import numpy as np
from scipy.sparse import csr_array

from fabgeo.arrays import Array, BoolArray, IntArray

_Settings = dict[str, str | bool | int | float]
_SAME: _Settings = {
    "output_flag": False,
    "threads": 1,
    "random_seed": 0,
    "mip_rel_gap": 1e-4,
}
# Features come in units of their limits: scaled anew, or with perturbed costs, some programmes
# take minutes of refactoring where these take tenths of a second.
_BRANCHED: _Settings = {
    "presolve": "off",
    "simplex_scale_strategy": 0,
    "dual_simplex_cost_perturbation_multiplier": 0.0,
}
_JOINING = 30  # rows that join at once
_BROKEN = 1e-7  # of what rows are in: below it HiGHS takes them for kept


@dataclass(frozen=True)
class Programme:
    """Minimise ``cost x`` where ``low <= matrix x <= high``, ``lower <= x <= upper``.

    Attributes
    ----------
    cost : (n,) array
    matrix : (m, n) sparse array
    low, high : (m,) arrays
    lower, upper : (n,) arrays
    whole : (n,) bool array
        Which x are zero or one.
    behind : (n,) int array or None
        The binary without which a column is zero (a binary: itself), where we branch here.
    small : bool
        Whether to branch here: preparing the integer search takes HiGHS ten times as long as the
        few linear programmes that a small one needs. Only integers may have costs then.
    dive : bool
        Look for solutions, where we branch here, rather than for a high bound.
    nodes, iterations : int
        Most nodes of the integer search, and most steps of the simplex method in each of them
        where we branch here.
    seconds : float or None
        Limit by the clock, for who prefers it to repeatable results.
    """

    cost: Array
    matrix: csr_array
    low: Array
    high: Array
    lower: Array
    upper: Array
    whole: BoolArray
    behind: IntArray | None = None
    small: bool = True
    dive: bool = False
    nodes: int = 16
    iterations: int = 2000
    seconds: float | None = None


@dataclass(frozen=True)
class Solution:
    """What became of a programme.

    Attributes
    ----------
    x : (n,) array or None
        The best found; None: none.
    bound : float
        Proven: no x costs less; infinite if there is none, minus infinity if nothing is proven.
    status : str
        "optimal", "infeasible", "node limit" or "time limit".
    """

    x: Array | None
    bound: float
    status: str


def solved(programme: Programme, guess: Array | None = None) -> Solution:
    """Solve a programme, from a known solution if there is one."""
    if programme.small:
        return _branched(programme)
    asked: _Settings = {"mip_max_nodes": programme.nodes}
    if programme.seconds is not None:
        asked["time_limit"] = programme.seconds
    highs = _loaded(programme, asked)
    kinds = (highspy.HighsVarType.kContinuous, highspy.HighsVarType.kInteger)
    every = np.arange(len(programme.cost), dtype=np.int32)
    highs.changeColsIntegrality(
        len(every), every, np.array([kinds[int(whole)] for whole in programme.whole])
    )
    if guess is not None:
        known = highspy.HighsSolution()
        known.col_value = guess.tolist()
        highs.setSolution(known)
    highs.run()
    status, info = highs.getModelStatus(), highs.getInfo()
    if status == highspy.HighsModelStatus.kInfeasible:
        return Solution(None, np.inf, "infeasible")
    word = "node limit"
    if status == highspy.HighsModelStatus.kOptimal:
        word = "optimal"
    elif status == highspy.HighsModelStatus.kTimeLimit:
        word = "time limit"
    found = int(info.primal_solution_status) == int(highspy.kSolutionStatusFeasible)
    x = np.array(highs.getSolution().col_value) if found else None
    return Solution(x, float(info.mip_dual_bound), word)


def _loaded(programme: Programme, asked: _Settings) -> highspy.Highs:
    """The solver with a programme, all of it continuous."""
    model = highspy.HighsLp()
    matrix = programme.matrix.tocsc()
    model.num_row_, model.num_col_ = len(programme.low), len(programme.cost)
    model.col_cost_ = programme.cost
    model.col_lower_, model.col_upper_ = programme.lower, programme.upper
    model.row_lower_, model.row_upper_ = programme.low, programme.high
    model.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    model.a_matrix_.start_ = matrix.indptr.astype(np.int32)
    model.a_matrix_.index_ = matrix.indices.astype(np.int32)
    model.a_matrix_.value_ = matrix.data
    highs = highspy.Highs()
    for name, value in (_SAME | asked).items():
        highs.setOptionValue(name, value)
    highs.passModel(model)
    return highs


def _branched(programme: Programme) -> Solution:
    """Branch and bound, best bound first, each linear programme from the basis of the one before.

    Costs of choices are multiples of what divides all prices: bounds are rounded up to them.
    """
    rowwise = _Rowwise(programme)
    highs = rowwise.highs
    whole = np.flatnonzero(programme.whole).astype(np.int32)
    step = divisor(programme.cost[whole])
    best, x, lost = np.inf, None, np.inf
    # By bound, less a step for every choice made where solutions matter more: (order, number of
    # the node, bound, depth, bounds of the binaries).
    stack = [(-np.inf, 0, -np.inf, 0, programme.lower[whole], programme.upper[whole])]
    for node in range(programme.nodes):
        while stack and stack[0][2] >= best - 1e-6:
            heappop(stack)
        if not stack:
            return Solution(x, min(best, lost), "infeasible" if x is None else "optimal")
        _, _, bound, depth, lower, upper = heappop(stack)
        if len(whole):
            _narrow(highs, programme, lower, upper)
        status = rowwise.run()
        if status == highspy.HighsModelStatus.kInfeasible:
            continue
        if status != highspy.HighsModelStatus.kOptimal:
            lost = min(lost, bound)  # nothing is known of this branch beyond its parent
            continue
        least = highs.getInfo().objective_function_value
        if len(whole):
            least = np.ceil((least - 1e-6) / step) * step
        found = np.array(highs.getSolution().col_value)
        off = np.abs(found[whole] - np.round(found[whole]))
        if off.max(initial=0.0) < 1e-6:
            if least < best:
                best, x = float(least), found
            continue
        k = int(off.argmax())
        near = np.round(found[whole][k])
        order = float(least) - programme.dive * step * (depth + 1)
        for value in (near, 1.0 - near):
            below, above = lower.copy(), upper.copy()
            below[k] = above[k] = value
            number = -2 * node - int(value == near)
            heappush(stack, (order, number, float(least), depth + 1, below, above))
    open_ = min((one[2] for one in stack), default=np.inf)
    return Solution(x, min(best, lost, open_), "node limit")


class _Rowwise:
    """The linear programmes of a search, whose rows join as solutions break them.

    Most rows never matter, and the simplex method takes time by their number. Equations are there
    from the start; without binaries, whose steps have bounds, so is everything.
    """

    def __init__(self, programme: Programme) -> None:
        self._programme = programme
        self._missing = (programme.low < programme.high) & programme.whole.any()
        there = np.flatnonzero(~self._missing)
        low, high = programme.low[there], programme.high[there]
        first = replace(programme, matrix=programme.matrix[there], low=low, high=high)
        self.highs = _loaded(first, _BRANCHED | {"simplex_iteration_limit": programme.iterations})

    def run(self) -> highspy.HighsModelStatus:
        """Solve; with the rows most broken, solve again until none is."""
        while True:
            self.highs.run()
            status = self.highs.getModelStatus()
            if status != highspy.HighsModelStatus.kOptimal:
                return status
            worst = self._broken(np.array(self.highs.getSolution().col_value))
            if len(worst) == 0:
                return status
            self._missing[worst] = False
            rows = csr_array(self._programme.matrix[worst])
            low, high = self._programme.low[worst], self._programme.high[worst]
            start, column = rows.indptr[:-1].astype(np.int32), rows.indices.astype(np.int32)
            self.highs.addRows(len(worst), low, high, rows.nnz, start, column, rows.data)

    def _broken(self, x: Array) -> IntArray:
        """The missing rows that x breaks most, in ascending order."""
        missing = np.flatnonzero(self._missing)
        value = (self._programme.matrix @ x)[missing]
        off = np.maximum(
            value - self._programme.high[missing], self._programme.low[missing] - value
        )
        broken = np.flatnonzero(off > _BROKEN)
        if len(broken) > _JOINING:
            broken = np.sort(broken[np.argpartition(-off[broken], _JOINING)[:_JOINING]])
        return missing[broken]


def _narrow(highs: highspy.Highs, programme: Programme, lower: Array, upper: Array) -> None:
    """Give binaries other bounds, and what is behind those that are zero no room.

    Otherwise rows alone hold it at zero: that many at once that the simplex method gets lost.
    """
    low, high = programme.lower.copy(), programme.upper.copy()
    low[programme.whole], high[programme.whole] = lower, upper
    if programme.behind is not None:
        off = (high[programme.behind] == 0.0) & ~programme.whole
        low[off] = high[off] = 0.0
    highs.changeColsBounds(len(low), np.arange(len(low), dtype=np.int32), low, high)


def divisor(prices: Array) -> float:
    """The largest number, of four decimals, that all prices are multiples of."""
    found = int(np.gcd.reduce(np.round(prices * 1e4).astype(np.int64), initial=0))
    rounded = np.abs(prices * 1e4 - np.round(prices * 1e4)).max(initial=0.0) > 1e-6
    return 1e-6 if rounded or found == 0 else found / 1e4


def all_solved(programmes: Sequence[Programme], jobs: int | None = None) -> list[Solution]:
    """Solve programmes in `jobs` threads (None: in this one); HiGHS lets go of Python's lock."""
    if jobs is None:
        return [solved(programme) for programme in programmes]
    with ThreadPoolExecutor(jobs) as pool:
        return list(pool.map(solved, programmes))
