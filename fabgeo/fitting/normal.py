"""Normal equations of a least-squares problem: assembled from elements, then banded or sparse.

Which way is taken follows from the size alone: a banded Cholesky (LAPACK pbtrf) costs about
n b^2, b the bandwidth; a sparse direct solver grows more slowly but starts dearer.
"""

from __future__ import annotations

from collections.abc import Sequence
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
CHUNK = 4096  # elements whose dense products are held at a time


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
        unique = {id(s): s for s in stencils}
        self._kept = list(unique.values())  # ids stay valid while the arrays live
        pairs = np.unique(np.concatenate([_pair_keys(s, node_count) for s in self._kept]))
        place, self.bandwidth = _ordering(pairs, node_count, dim)
        first, second = np.divmod(pairs, node_count)
        upper = place[first] <= place[second]
        self._keys = pairs[upper]
        self._selections = {id(s): self._select(s, place) for s in self._kept}
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

    def _select(self, nodes: IntArray, place: IntArray) -> list[sp.csc_array]:
        """Where the products of each chunk of elements are added: one 1 in every column."""
        chunks = []
        for start in range(0, len(nodes), CHUNK):
            part = nodes[start : start + CHUNK]
            a = np.repeat(part, part.shape[1], axis=1).ravel()
            b = np.tile(part, (1, part.shape[1])).ravel()
            # Pairs of the lower triangle go to a last row that nobody reads.
            slot = np.searchsorted(self._keys, a * self.node_count + b)
            slot = np.where(place[a] <= place[b], slot, len(self._keys)).astype(np.int32)
            shape = (len(self._keys) + 1, len(slot))
            entries = (np.ones(len(slot)), slot, np.arange(len(slot) + 1, dtype=np.int32))
            chunks.append(sp.csc_array(entries, shape=shape))
        return chunks

    def assemble(self, blocks: Sequence[Block]) -> Array:
        """Set the matrix J^T J; return the gradient J^T r (node_count, dim)."""
        matrix = np.zeros((len(self._keys) + 1, self.dim**2))
        gradient = np.zeros((self.node_count, self.dim))
        together: dict[int, list[Block]] = {}
        for block in blocks:
            together.setdefault(id(block.nodes), []).append(block)
        for key, group in together.items():
            nodes = group[0].nodes
            k, w = nodes.shape
            flat = np.empty((k, w, self.dim))
            for c, selection in enumerate(self._selections[key]):
                part = slice(c * CHUNK, (c + 1) * CHUNK)
                jacobian = np.concatenate([b.jacobian[part] for b in group], axis=1)
                residual = np.concatenate([b.residual[part] for b in group], axis=1)
                transposed = np.swapaxes(jacobian, 1, 2)
                flat[part] = (transposed @ residual[:, :, None]).reshape(-1, w, self.dim)
                product = (transposed @ jacobian).reshape(-1, w, self.dim, w, self.dim)
                product = product.transpose(0, 1, 3, 2, 4).reshape(-1, self.dim**2)
                matrix += selection @ product
            for axis in range(self.dim):
                gradient[:, axis] += np.bincount(
                    nodes.ravel(), flat[:, :, axis].ravel(), self.node_count
                )
        self._matrix = matrix[:-1]
        first, second = np.divmod(self._keys, self.node_count)
        diagonal = self._matrix[first == second][:, :: self.dim + 1]
        self.diagonal = np.zeros((self.node_count, self.dim))
        self.diagonal[first[first == second]] = diagonal
        return gradient

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


def _pair_keys(nodes: IntArray, count: int) -> IntArray:
    """All ordered pairs of nodes that meet in an element, as unique keys."""
    keys = [nodes[:, a] * count + nodes[:, b] for a, b in np.ndindex((nodes.shape[1],) * 2)]
    return np.unique(np.concatenate(keys))


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
