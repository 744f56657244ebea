"""Symmetric positive definite systems with a fixed pattern: banded, PARDISO, SuperLU."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.sparse.linalg import splu

from fabgeo.arrays import Array, IntArray


class Factorisation(Protocol):
    """Solves with the upper triangle given entry by entry in a fixed order."""

    def solve(self, entries: Array, shift: Array, right: Array) -> Array:
        """Solution of (A + diag(shift)) x = right."""
        ...


class BandedCholesky:
    """LAPACK's banded Cholesky (pbtrf) on the upper band."""

    def __init__(self, row: IntArray, column: IntArray, size: int, bandwidth: int) -> None:
        self._kept = row <= column
        self._at = (bandwidth + row - column)[self._kept] * size + column[self._kept]
        self._band = np.zeros((bandwidth + 1, size))

    def solve(self, entries: Array, shift: Array, right: Array) -> Array:
        """Solution of (A + diag(shift)) x = right."""
        self._band.fill(0.0)
        self._band.ravel()[self._at] = entries[self._kept]
        self._band[-1] += shift
        factor = cholesky_banded(self._band, check_finite=False)
        return cho_solve_banded((factor, False), right, check_finite=False)


class SparseLU:
    """SciPy's SuperLU in its symmetric mode, for sizes where a band costs more."""

    def __init__(self, row: IntArray, column: IntArray, size: int) -> None:
        upper = np.flatnonzero(row <= column)
        lower = np.flatnonzero(row < column)
        take = np.concatenate([upper, lower])
        i = np.concatenate([row[upper], column[lower]])
        j = np.concatenate([column[upper], row[lower]])
        # Symmetric: the rows of a CSR matrix serve as the columns of a CSC matrix.
        self._matrix, self._take = numbered_csr(i, j, take, size)

    def solve(self, entries: Array, shift: Array, right: Array) -> Array:
        """Solution of (A + diag(shift)) x = right."""
        self._matrix.data = entries[self._take]
        matrix = (self._matrix + sp.diags_array(shift)).tocsc()
        try:
            factor = splu(
                matrix,
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise np.linalg.LinAlgError(str(error)) from error
        return factor.solve(right)


@cache
def pardiso() -> Callable[[IntArray, IntArray, int], Factorisation] | None:
    """The PARDISO factorisation where the extra ``fast`` is installed, else None."""
    if importlib.util.find_spec("pypardiso") is None:
        return None
    _point_to_mkl()
    from fabgeo.fitting.pardiso import Pardiso

    return Pardiso


def _point_to_mkl() -> None:
    """Name MKL's library, for which pypardiso would search the whole environment (2 s)."""
    found = sorted(Path(sys.prefix).glob("[Ll]ib*/*mkl_rt*"))
    if found and "PYPARDISO_MKL_RT" not in os.environ:
        os.environ["PYPARDISO_MKL_RT"] = str(found[0])


def numbered_csr(
    row: IntArray, column: IntArray, take: IntArray, size: int
) -> tuple[sp.csr_array, IntArray]:
    """A sorted matrix of the pattern, and which given entry each of its data is."""
    numbered = sp.coo_array((np.arange(1.0, len(take) + 1.0), (row, column)), (size, size))
    matrix = sp.csr_array(numbered)
    matrix.sort_indices()
    return matrix, take[matrix.data.astype(np.int64) - 1]
