"""Levenberg-Marquardt: blocks in, status and history out. It knows nothing of strips.

Only a step that lowers the cost is accepted. The damping follows the ratio of the gain found to
the gain that the linear model predicts (Nielsen, Damping parameter in Marquardt's method, 1999).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from fabgeo.arrays import Array
from fabgeo.fitting.blocks import Problem
from fabgeo.fitting.normal import NormalEquations

type Outcome = Literal["converged", "stalled", "iterations", "interrupted"]

LARGEST_DAMPING = 1e12  # relative to the mean of the diagonal: steps are then beyond rounding
OF_A_GROUP = 10.0  # times the gain asked: what a group of residuals may still change by
SIGNIFICANT = 0.01  # of the cost: groups count as if they had at least this


@dataclass(frozen=True)
class Step:
    """One accepted step: `cost` after it, `gain` relative to the cost before, `damping` used."""

    iteration: int
    cost: float
    gain: float
    damping: float
    length: float


@dataclass(frozen=True)
class Solution:
    """What a minimisation found.

    Attributes
    ----------
    x : (nodes, dim) array
        The best unknowns seen.
    cost : float
        Half the sum of squares there.
    outcome : str
        "converged": the last steps gained less than asked; "stalled": no step lowers the cost;
        "iterations": the budget is used up; "interrupted": the listener said stop.
    steps : tuple of Step
    damping : float
        Where a continuation may start.
    factorisations : int
    """

    x: Array
    cost: float
    outcome: Outcome
    steps: tuple[Step, ...] = field(default=())
    damping: float = 1e-3
    factorisations: int = 0


def minimise(
    problem: Problem,
    x: Array,
    equations: NormalEquations,
    *,
    iterations: int = 50,
    gain: float = 1e-4,
    damping: float = 1e-4,
    listener: Callable[[Step], bool] | None = None,
) -> Solution:
    """Make the problem's sum of squares small, starting from `x`.

    Parameters
    ----------
    problem : Problem
    x : (nodes, dim) array
    equations : NormalEquations
        Made for the problem's stencils.
    iterations : int
        Largest number of accepted steps.
    gain : float
        Converged when two steps in a row lower the cost by less than this part of it, and change
        each group of it by less than ten times that part of the group.
    damping : float
        First damping, relative to the mean diagonal of J^T J.
    listener : callable, optional
        Called after every accepted step; returning False stops with the best found so far.
    """
    costs, steps, factorisations = problem.costs(x), [], 0
    cost = float(costs.sum())
    growth, small = 2.0, 0
    outcome: Outcome = "iterations"
    while len(steps) < iterations:
        gradient = equations.assemble(problem.blocks(x))
        scale = float(equations.diagonal.mean()) or 1.0
        predicted = np.inf
        while True:
            step = _step(equations, gradient, damping * scale)
            factorisations += 1
            if step is not None:
                trial = x + step
                # The linear model's cost falls by half of -g.s + mu |s|^2 for the damped step.
                predicted = 0.5 * float(np.sum(step * (damping * scale * step - gradient)))
                trial_costs = problem.costs(trial)
                found = float(trial_costs.sum())
                if found < cost and problem.admissible(trial):
                    break
            damping, growth = damping * growth, growth * 2.0
            if damping > LARGEST_DAMPING or predicted < 1e-14 * cost:
                return Solution(x, cost, "stalled", tuple(steps), damping, factorisations)
        relative = (cost - found) / cost
        change = np.abs(trial_costs - costs) / np.maximum(trial_costs, SIGNIFICANT * cost)
        steps.append(Step(len(steps) + 1, found, relative, damping, float(np.abs(step).max())))
        ratio = (cost - found) / predicted if predicted > 0.0 else 1.0
        damping = max(damping * max(1.0 / 5.0, 1.0 - (2.0 * ratio - 1.0) ** 3), 1e-13)
        growth = 2.0
        x, cost, costs = trial, found, trial_costs
        if listener is not None and not listener(steps[-1]):
            outcome = "interrupted"
            break
        settled = relative < gain and bool(change.max() < OF_A_GROUP * gain)
        small = small + 1 if settled else 0
        if small == 2:
            outcome = "converged"
            break
    return Solution(x, cost, outcome, tuple(steps), damping, factorisations)


def _step(equations: NormalEquations, gradient: Array, damping: float) -> Array | None:
    try:
        step = equations.solve(-gradient, damping)
    except np.linalg.LinAlgError:
        return None
    return step if np.isfinite(step).all() else None
