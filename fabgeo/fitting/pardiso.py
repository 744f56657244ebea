"""MKL PARDISO for symmetric positive definite systems (extra ``fast``).

The analysis of the pattern is done once; every solve is a numerical factorisation and one
substitution.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from pypardiso import PyPardisoSolver
from pypardiso.pardiso_wrapper import PyPardisoError

from fabgeo.arrays import Array, IntArray
from fabgeo.fitting.linear import numbered_csr

POSITIVE_DEFINITE = 2  # PARDISO's matrix type
ANALYSE, FACTORISE_AND_SOLVE = 11, 23


class Pardiso:
    """Cholesky factorisation of the upper triangle by PARDISO."""

    def __init__(self, row: IntArray, column: IntArray, size: int) -> None:
        upper = np.flatnonzero(row <= column)
        self._matrix, self._take = numbered_csr(row[upper], column[upper], upper, size)
        starts, columns = self._matrix.indptr[:-1], self._matrix.indices
        self._diagonal = starts[columns[starts] == np.arange(size)]
        self._solver = PyPardisoSolver(mtype=POSITIVE_DEFINITE)
        self._analysed = False

    def solve(self, entries: Array, shift: Array, right: Array) -> Array:
        """Solution of (A + diag(shift)) x = right."""
        self._matrix.data = entries[self._take]
        self._matrix.data[self._diagonal] += shift
        try:
            if not self._analysed:
                self._solver.set_phase(ANALYSE)
                self._solver._call_pardiso(self._matrix, right)
                self._analysed = True
            self._solver.set_phase(FACTORISE_AND_SOLVE)
            return self._solver._call_pardiso(self._matrix, right)
        except PyPardisoError as error:
            raise np.linalg.LinAlgError(f"PARDISO: {error}") from error

    def __del__(self) -> None:
        if getattr(self, "_analysed", False):
            self._solver.set_phase(-1)
            self._solver._call_pardiso(sp.csr_matrix((0, 0)), np.zeros(0))
