"""Where straight lines meet a ruled patch, which goes on straight beyond its ends."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array
from fabgeo.strips.ruled import RuledPatch


def pierce(mid: RuledPatch, points: Array, axes: Array, u: Array) -> tuple[Array, Array, Array]:
    """Where lines points + h axes meet a ruled patch: u, v, h (k,) each, by Newton's method.

    Parameters
    ----------
    points, axes : (k, 3) array
    u : (k,) array
        First guess; u and v of the result may lie outside the patch. Beyond u0 and u1 the edges
        go on along their tangents: Newton's method ends there as well.
    """
    u, v, h = np.array(u, dtype=np.float64), np.full(len(u), 0.5), np.zeros(len(u))
    for _ in range(20):
        at = np.clip(u, mid.u0, mid.u1)
        a, b = mid.edges(at)
        da, db = mid.edges(at, 1)
        beyond = (u - at)[:, None]
        a, b = a + beyond * da, b + beyond * db
        chord: Array = b - a
        miss = a + v[:, None] * chord - points - h[:, None] * axes
        along: Array = da + v[:, None] * (db - da)
        jacobian = np.stack([along, chord, -axes], axis=-1)
        step = np.linalg.solve(jacobian, -miss[..., None])[..., 0]
        u, v, h = u + step[:, 0], v + step[:, 1], h + step[:, 2]
        if np.linalg.norm(miss, axis=-1).max() < 1e-9:
            break
    return u, v, h
