"""Antiderivatives of smooth functions on [0, m] by Gauss quadrature.

Every construction that follows a curve (trajectories, rotation-minimising normals, conversions)
is one quadrature: u -> s0 + integral of f from 0 to u.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from fabgeo.arrays import Array
from fabgeo.errors import GeometryError

_NODES, _WEIGHTS = (np.asarray(x, dtype=np.float64) for x in np.polynomial.legendre.leggauss(4))


def antiderivative(
    function: Callable[[Array], Array], segments: int, pieces: int = 16
) -> Callable[[Array], Array]:
    """The antiderivative of `function` that vanishes at u = 0.

    Integrals to the ends of all pieces are exact to rounding; between them the cubic Hermite
    interpolant with the exact slopes stands in, with an error of the fourth power of the piece.

    Parameters
    ----------
    function : callable
        (k,) parameters -> (..., k) values, continuous, and smooth within each knot span.
    segments : int
        Number of unit knot spans.
    pieces : int
        Gauss intervals to a span.

    Returns
    -------
    callable
        (k,) parameters in [0, segments], a little beyond included -> (..., k) integrals.

    Raises
    ------
    GeometryError
        If the function has no finite value somewhere; names u.
    """
    count = segments * pieces
    step = 1.0 / pieces
    ends: Array = np.arange(count + 1, dtype=np.float64) * step
    sites = ends[:-1, None] + (_NODES + 1.0) * step / 2.0
    at = np.concatenate([sites.ravel(), ends])
    values = function(at)
    lacking = ~np.isfinite(values).reshape(-1, len(at)).all(axis=0)
    if lacking.any():
        raise GeometryError(
            f"strip model at u = {at[lacking][0]:.6g}",
            "what follows its edges has no finite direction there",
            "move control points apart",
        )
    inner, slopes = values[..., : sites.size], values[..., sites.size :]
    inner = inner.reshape(*inner.shape[:-1], count, len(_NODES))
    parts = np.einsum("...kq,q->...k", inner, _WEIGHTS) * step / 2.0
    total = np.concatenate([np.zeros((*parts.shape[:-1], 1)), np.cumsum(parts, axis=-1)], axis=-1)
    curve = CubicHermiteSpline(ends, total, slopes, axis=-1)
    return lambda u: np.asarray(curve(np.atleast_1d(u)), dtype=np.float64)
