"""The cheapest mix of known sheets that holds all pieces: in shares, or in whole sheets.

Glossary
--------
mix
    How much of every known sheet is bought, in fractions: a linear programme. Its duals are prices
    of the pieces (Gilmore and Gomory 1961).
due
    What one more sheet of a stock that is short would save: its own dual.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fabgeo.arrays import Array

type Index = np.ndarray[tuple[int], np.dtype[np.intp]]

MISSING = 20.0  # dearest sheets that a piece without sheet costs
PIVOTS = 5  # for every row and column; what needs more is left to the interior point method
NODES = 100  # of the search for whole sheets where no time is given


@dataclass(frozen=True)
class Mix:
    """Cost of a mix, price of every kind of piece, due of every stock, share of every sheet."""

    cost: float
    prices: Array
    dues: Array
    shares: Array


def cheapest_mix(counts: Array, own: Index, costs: Array, demand: Array, stocked: Array) -> Mix:
    """Solve the linear programme.

    Parameters
    ----------
    counts : (n, k) array
        How many pieces of each kind every known sheet holds.
    own : (n,) array
        Number of its stock.
    costs, stocked : (s,) arrays
        Of one sheet of every stock; how many there are (infinite: any number).
    demand : (k,) array
    """
    from scipy.optimize import linprog

    cost, rows, bound, open_, short = _rows(counts, own, costs, demand, stocked)
    found = linprog(
        cost,
        A_ub=rows,
        b_ub=bound,
        method="highs-ds",
        options={"maxiter": PIVOTS * sum(rows.shape)},
    )
    if found.status != 0:
        found = linprog(cost, A_ub=rows, b_ub=bound, method="highs-ipm")
    prices, dues, unit = np.zeros(len(demand)), np.zeros(len(stocked)), costs.max()
    prices[open_] = -found.ineqlin.marginals[: len(open_)] * unit
    dues[short] = -found.ineqlin.marginals[len(open_) :] * unit
    return Mix(float(found.fun) * unit, prices, dues, found.x[: len(own)])


def cheapest_choice(
    counts: Array,
    own: Index,
    costs: Array,
    demand: Array,
    stocked: Array,
    seconds: float | None,
) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """How many of every known sheet to buy (n,), found in so many seconds (or `NODES` nodes)."""
    from scipy.optimize import milp

    cost, rows, bound, open_, _ = _rows(counts, own, costs, demand, stocked)
    found = milp(
        cost,
        constraints=(rows, -np.inf, bound),
        integrality=np.append(np.ones(len(own)), np.zeros(len(open_))),
        options={"node_limit": NODES} if seconds is None else {"time_limit": seconds},
    )
    if found.x is None:
        return np.zeros(len(own), dtype=np.intp)
    return np.round(found.x[: len(own)]).astype(np.intp)


def _rows(
    counts: Array, own: Index, costs: Array, demand: Array, stocked: Array
) -> tuple[Array, Any, Array, Index, Index]:
    """Cost, rows <= bound of all sheets and of pieces left out; open kinds; stocks in short.

    Costs are in units of the dearest sheet: HiGHS takes reduced costs below 1e-7 for zero, whatever
    their unit, and with square millimetres (3e7 a sheet) rounding alone is more than that: it then
    mends its solution for ever.
    """
    from scipy.sparse import csr_array, eye_array, hstack, vstack

    (open_,) = np.nonzero(demand > 0.0)
    (short,) = np.nonzero(np.isfinite(stocked))
    out = np.full(len(open_), MISSING)
    held = csr_array(counts[:, open_].T)
    used = csr_array((own[None, :] == short[:, None]).astype(np.float64))
    none = csr_array((len(short), len(open_)))
    rows = vstack([-hstack([held, eye_array(len(open_))]), hstack([used, none])]).tocsc()
    bound = np.append(-demand[open_], stocked[short])
    return np.append(costs[own] / costs.max(), out), rows, bound, open_, short
