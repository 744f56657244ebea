"""The solver on problems that have nothing to do with strips."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from fabgeo.fitting.blocks import Block
from fabgeo.fitting.levenberg import minimise
from fabgeo.fitting.linear import pardiso
from fabgeo.fitting.normal import NormalEquations

METHODS = ["banded", "superlu", *(["pardiso"] if pardiso() else [])]


@dataclass
class Rosenbrock:
    """A chain of Rosenbrock valleys: residuals 10 (y - x^2) and 1 - x; least at (1, 1)."""

    node_count: int = 5
    dim: int = 2
    stencils: list = field(default_factory=list)

    def __post_init__(self):
        self.stencils = [np.arange(self.node_count)[:, None]]

    def residual(self, x):
        return np.stack([10.0 * (x[:, 1] - x[:, 0] ** 2), 1.0 - x[:, 0]], axis=1)

    def costs(self, x):
        return 0.5 * np.sum(self.residual(x) ** 2, axis=0)

    def blocks(self, x):
        jacobian = np.zeros((2, len(x), 2, 1))
        jacobian[0, :, 0, 0], jacobian[1, :, 0, 0] = -20.0 * x[:, 0], 10.0
        jacobian[0, :, 1, 0] = -1.0
        return [Block(self.stencils[0], self.residual(x), jacobian)]

    def admissible(self, x):
        return True


@dataclass
class Wall(Rosenbrock):
    """The same, but x above 0.5 is forbidden."""

    def admissible(self, x):
        return bool(np.all(x[:, 0] <= 0.5))


def equations(problem, method="banded"):
    return NormalEquations(problem.stencils, problem.node_count, problem.dim, method)


def start(problem):
    return np.tile([-1.2, 1.0], (problem.node_count, 1))


@pytest.mark.parametrize("method", METHODS)
def test_finds_the_valleys_ends_with_falling_cost(method):
    problem = Rosenbrock()
    found = minimise(problem, start(problem), equations(problem, method), iterations=100)
    np.testing.assert_allclose(found.x, 1.0, atol=1e-6)
    costs = [problem.costs(start(problem)).sum(), *(s.cost for s in found.steps)]
    assert np.all(np.diff(costs) < 0.0)


def test_stops_with_the_best_so_far_when_told():
    problem = Rosenbrock()
    found = minimise(
        problem, start(problem), equations(problem), listener=lambda s: s.iteration < 3
    )
    assert found.outcome == "interrupted"
    assert len(found.steps) == 3
    assert problem.costs(found.x).sum() == found.steps[-1].cost == found.cost


def test_never_accepts_what_is_not_admissible():
    problem = Wall()
    found = minimise(problem, start(problem), equations(problem), iterations=60)
    assert np.all(found.x[:, 0] <= 0.5)
    assert found.cost < problem.costs(start(problem)).sum()


def test_an_empty_budget_changes_nothing():
    problem = Rosenbrock()
    found = minimise(problem, start(problem), equations(problem), iterations=0)
    np.testing.assert_array_equal(found.x, start(problem))


@pytest.mark.parametrize("method", METHODS)
def test_normal_equations_are_those_of_the_dense_jacobian(method):
    rng = np.random.default_rng(3)
    nodes = [np.array([[0, 3, 1], [5, 2, 4], [1, 6, 2], [0, 6, 5]]), np.array([[6, 0], [3, 4]])]
    blocks = [
        Block(n, rng.standard_normal((len(n), 4)), rng.standard_normal((3, len(n), 4, n.shape[1])))
        for n in (*nodes, nodes[0])
    ]
    equations = NormalEquations(nodes, 7, 3, method)
    gradient = equations.assemble(blocks)
    dense, right = [], []
    for block in blocks:
        for k, at in enumerate(block.nodes):
            rows = np.zeros((4, 7, 3))
            for w, node in enumerate(at):
                rows[:, node] += block.jacobian[:, k, :, w].T
            dense.append(rows.reshape(4, 21))
            right.append(block.residual[k])
    jacobian, residual = np.concatenate(dense), np.concatenate(right)
    np.testing.assert_allclose(gradient.ravel(), jacobian.T @ residual, atol=1e-12)
    matrix = jacobian.T @ jacobian + 0.1 * np.eye(21)
    expected = np.linalg.solve(matrix, gradient.ravel())
    np.testing.assert_allclose(equations.solve(gradient, 0.1).ravel(), expected, atol=1e-10)
    np.testing.assert_allclose(equations.diagonal.ravel(), np.diag(jacobian.T @ jacobian))


@pytest.mark.parametrize("method", METHODS)
def test_an_indefinite_matrix_is_refused(method):
    if method == "superlu":
        pytest.skip("LU does not ask for definiteness")
    problem = Rosenbrock()
    equation = equations(problem, method)
    gradient = equation.assemble(problem.blocks(start(problem)))
    with pytest.raises(np.linalg.LinAlgError):
        equation.solve(gradient, -1e6)


def test_chains_stay_banded_and_large_grids_go_sparse():
    chain = np.arange(3000)[:, None] + np.arange(2)
    assert NormalEquations([chain], 3001, 3).method == "banded"
    i, j = np.meshgrid(np.arange(140), np.arange(140), indexing="ij")
    corner = (i * 141 + j).ravel()
    grid = corner[:, None] + np.array([0, 1, 141, 142])
    assert NormalEquations([grid], 141 * 141, 3).method != "banded" or pardiso() is None
