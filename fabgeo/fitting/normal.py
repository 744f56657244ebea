"""Normal equations of a least-squares problem: assembled from elements, then banded or sparse.

Which way is taken follows from the size alone: a banded Cholesky (LAPACK pbtrf) costs about
n b^2, b the bandwidth; a sparse direct solver grows more slowly but starts dearer.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import reverse_cuthill_mckee

from fabgeo.arrays import Array, IntArray
from fabgeo.fitting.blocks import Block
from fabgeo.fitting.linear import BandedCholesky, Factorisation, SparseLU, pardiso

type Method = Literal["auto", "banded", "pardiso", "superlu"]

# Work n b^2 up to which the banded solver is quicker, measured on two cores: against PARDISO
# about 6,000 unknowns of a strip model, against SuperLU about 20,000.
BANDED_BEATS_PARDISO = 6e8
BANDED_BEATS_SUPERLU = 1.2e10


class NormalEquations:
    """J^T J and J^T r of problems that share one pattern.

    Parameters
    ----------
    stencils : sequence of (k, w) int arrays
        The nodes of every element.
    node_count, dim : int
        Number of nodes and coordinates of each.
    method : {"auto", "banded", "pardiso", "superlu"}
    """

    def __init__(
        self, stencils: Sequence[IntArray], node_count: int, dim: int, method: Method = "auto"
    ) -> None:
        self.node_count, self.dim = node_count, dim
        pairs = _pair_keys({id(s): s for s in stencils}.values(), node_count)
        place, self.bandwidth = _ordering(pairs, node_count, dim)
        first, second = np.divmod(pairs, node_count)
        upper = place[first] <= place[second]
        self._keys = pairs[upper]
        self._selections: dict[int, tuple[IntArray, IntArray]] = {}
        row, column = place[first[upper]], place[second[upper]]
        self.method = self._choose(method)
        self._place = place
        self._factor = self._make(row, column)

    def _choose(self, method: Method) -> str:
        if method != "auto":
            return method
        work = self.node_count * self.dim * float(self.bandwidth) ** 2
        if work <= BANDED_BEATS_PARDISO:
            return "banded"
        if pardiso() is not None:
            return "pardiso"
        return "banded" if work <= BANDED_BEATS_SUPERLU else "superlu"

    def _make(self, row: IntArray, column: IntArray) -> Factorisation:
        size = self.node_count * self.dim
        local = np.arange(self.dim)
        i = (row[:, None, None] * self.dim + local[:, None]) + 0 * local
        j = (column[:, None, None] * self.dim + local) + 0 * local[:, None]
        if self.method == "banded":
            return BandedCholesky(i.ravel(), j.ravel(), size, self.bandwidth)
        solver = pardiso() if self.method == "pardiso" else SparseLU
        return (solver or SparseLU)(i.ravel(), j.ravel(), size)

    def _slots(self, nodes: IntArray) -> IntArray:
        """Where the product of each pair of an element's nodes is added, (k, w, w).

        Pairs of the lower triangle go to one last slot that nobody reads.
        """
        a, b = nodes[:, :, None], nodes[:, None, :]
        slot = np.searchsorted(self._keys, a * self.node_count + b)
        return np.where(self._place[a] <= self._place[b], slot, len(self._keys))

    def assemble(self, blocks: Sequence[Block]) -> Array:
        """Set the matrix J^T J; return the gradient J^T r (node_count, dim)."""
        dim, count = self.dim, len(self._keys) + 1
        matrix = np.zeros((dim, dim, count))
        gradient = np.zeros((dim, self.node_count))
        together: dict[int, list[Block]] = {}
        for block in blocks:
            together.setdefault(id(block.nodes), []).append(block)
        for group in together.values():
            nodes, slots = group[0].nodes, self._slots_of(group[0].nodes)
            jacobian = np.concatenate([b.jacobian for b in group], axis=2)
            residual = np.concatenate([b.residual for b in group], axis=1)[:, :, None]
            transposed = np.swapaxes(jacobian, 2, 3)
            for c in range(dim):
                right = (transposed[c] @ residual).ravel()
                gradient[c] += np.bincount(nodes.ravel(), right, self.node_count)
                for e in range(dim):
                    product = (transposed[c] @ jacobian[e]).ravel()
                    matrix[c, e] += np.bincount(slots, product, count)
        self._matrix = np.ascontiguousarray(matrix[:, :, :-1].transpose(2, 0, 1))
        first, second = np.divmod(self._keys, self.node_count)
        same = first == second
        self.diagonal = np.zeros((self.node_count, dim))
        self.diagonal[first[same]] = np.einsum("kcc->kc", self._matrix[same])
        return gradient.T

    def _slots_of(self, nodes: IntArray) -> IntArray:
        """The slots of a stencil, found once; the array is kept so that its id stays its own."""
        if id(nodes) not in self._selections:
            self._selections[id(nodes)] = (nodes, self._slots(nodes).ravel())
        return self._selections[id(nodes)][1]

    def solve(self, right: Array, damping: Array | float) -> Array:
        """Solution of (J^T J + damping) step = right, all (node_count, dim).

        Raises
        ------
        numpy.linalg.LinAlgError
            If the damped matrix is not positive definite to working precision.
        """
        order = np.argsort(self._place)
        shift = np.broadcast_to(damping, right.shape)[order].ravel()
        solution = self._factor.solve(self._matrix.ravel(), shift, right[order].ravel())
        return solution.reshape(-1, self.dim)[self._place]


def _pair_keys(stencils: Iterable[IntArray], count: int) -> IntArray:
    """All ordered pairs of nodes that meet in an element, as ascending keys."""
    rows = [
        sp.csr_array(
            (np.ones(n.size, dtype=np.int32), n.ravel(), np.arange(0, n.size + 1, n.shape[1])),
            shape=(len(n), count),
        )
        for n in stencils
    ]
    incidence = sp.csr_array(sp.vstack(rows))
    graph = sp.csr_array(incidence.T @ incidence)
    graph.sort_indices()
    first = np.repeat(np.arange(count), np.diff(graph.indptr))
    return first * count + graph.indices.astype(np.int64)


def _ordering(pairs: IntArray, count: int, dim: int) -> tuple[IntArray, int]:
    """The place of every node in the order of elimination, and the scalar bandwidth.

    The given order, the reverse Cuthill-McKee order of the graph: whichever is narrower.
    """
    first, second = np.divmod(pairs, count)
    graph = sp.csr_array((np.ones(len(pairs), dtype=np.int8), (first, second)), (count, count))
    order = reverse_cuthill_mckee(graph, symmetric_mode=True)
    cuthill = np.empty(count, dtype=np.int64)
    cuthill[order] = np.arange(count)
    candidates = [np.arange(count), cuthill]
    widths = [int(np.abs(p[first] - p[second]).max()) for p in candidates]
    best = int(np.argmin(widths))
    return candidates[best], (widths[best] + 1) * dim - 1
