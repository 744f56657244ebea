"""Antiderivatives of smooth functions on [0, m] by Gauss quadrature, exact to rounding.

Every construction that follows a curve (trajectories, rotation-minimising normals, conversions)
is one quadrature: u -> s0 + integral of f from 0 to u.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fabgeo.arrays import Array

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)


def antiderivative(
    function: Callable[[Array], Array], segments: int, pieces: int = 4
) -> Callable[[Array], Array]:
    """The antiderivative of `function` that vanishes at u = 0.

    Parameters
    ----------
    function : callable
        (k,) parameters -> (..., k) values, smooth within each knot span.
    segments : int
        Number of unit knot spans.
    pieces : int
        Gauss intervals to a span.

    Returns
    -------
    callable
        (k,) parameters in [0, segments], a little beyond included -> (..., k) integrals.
    """
    count = segments * pieces
    step = 1.0 / pieces
    start = np.arange(count) * step
    sites = start[:, None] + (_NODES + 1.0) * step / 2.0
    values = function(sites.ravel())
    values = values.reshape(*values.shape[:-1], count, len(_NODES))
    parts = np.einsum("...kq,q->...k", values, _WEIGHTS) * step / 2.0
    total = np.concatenate([np.zeros((*parts.shape[:-1], 1)), np.cumsum(parts, axis=-1)], axis=-1)

    def integral(u: Array) -> Array:
        u = np.atleast_1d(np.asarray(u, dtype=np.float64))
        piece = np.clip(np.floor(u * pieces).astype(np.int64), 0, count - 1)
        left = piece * step
        half = (u - left) / 2.0
        inner = left[:, None] + half[:, None] * (_NODES + 1.0)
        rest = function(inner.ravel())
        rest = rest.reshape(*rest.shape[:-1], len(u), len(_NODES))
        return total[..., piece] + np.einsum("...kq,q->...k", rest, _WEIGHTS) * half

    return integral
