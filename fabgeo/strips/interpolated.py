"""Cubic B-splines through curves that are no splines: Greville interpolation, measured.

Offsets, trajectories and normals are exact functions of u; parts are built on splines. Several
curves are interpolated at once on common knots; knots are halved until the error is within the
tolerance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.interpolate import BSpline
from scipy.linalg import lu_factor, lu_solve

from fabgeo import spline
from fabgeo.arrays import Array
from fabgeo.errors import GeometryError

type Curves = Callable[[Array], Array]


@dataclass(frozen=True)
class Interpolated:
    """N curves as clamped cubics on common knots.

    Attributes
    ----------
    knots : (k + 4,) array
    poles : (N, k, 3) array
    error : float
        Largest distance from the true curves, measured between the interpolation sites.
    """

    knots: Array
    poles: Array
    error: float


def interpolated(curves: Curves, knots: Array, tolerance: float, where: str) -> Interpolated:
    """Interpolate curves u (k,) -> (N, k, 3) on clamped knots, halved up to five times.

    Raises
    ------
    GeometryError
        If the tolerance can't be reached.
    """
    error = np.inf
    for _ in range(6):
        made = _through(curves, knots)
        error = made.error
        if error <= tolerance:
            return made
        knots = halved(knots)
    raise GeometryError(
        where,
        f"its curves can't be interpolated to {tolerance:g} mm (found {error:.3g})",
        "give a larger tolerance, or look for a kink or a fold there",
    )


def _through(curves: Curves, knots: Array) -> Interpolated:
    sites = spline.greville(knots)
    checks = np.sort(np.concatenate([(sites[1:] + sites[:-1]) / 2.0, np.unique(knots)]))
    values = curves(np.concatenate([sites, checks]))
    given, control = values[:, : len(sites)], values[:, len(sites) :]
    poles = _solve(knots, np.moveaxis(given, 1, 0))
    found = np.asarray(BSpline(knots, poles, 3)(checks), dtype=np.float64)
    error = np.linalg.norm(np.moveaxis(found, 0, 1) - control, axis=-1).max()
    return Interpolated(knots, np.moveaxis(poles, 1, 0), float(error))


def _solve(knots: Array, given: Array) -> Array:
    """Poles (k, N, 3) with which the splines pass through `given` at the Greville points."""
    scaled = (knots - knots[0]) / (knots[-1] - knots[0])
    factors = _factors(np.round(scaled, 12).tobytes(), len(knots))
    flat = given.reshape(len(given), -1)
    return np.asarray(lu_solve(factors, flat)).reshape(given.shape)


@lru_cache(maxsize=512)
def _factors(key: bytes, count: int) -> tuple[Any, Any]:
    """Factorised collocation matrix of a knot vector scaled to [0, 1]; many parts share one."""
    knots = np.frombuffer(key, dtype=np.float64)[:count]
    sites = np.clip(spline.greville(knots), 0.0, 1.0)
    return lu_factor(BSpline.design_matrix(sites, knots, 3).toarray())


def halved(knots: Array) -> Array:
    """Clamped knots with the middle of every span added."""
    spans = np.unique(knots)
    return np.sort(np.concatenate([knots, (spans[1:] + spans[:-1]) / 2.0]))


def knots_between(u0: float, u1: float, least: int = 2) -> Array:
    """Clamped knots on [u0, u1] with the integers between as simple knots, at least so many spans.

    A cut a hair beside an integer gives no sliver span: integers nearer than 0.02 are left out.
    """
    tiny = 0.02
    integers = np.arange(np.ceil(u0 + tiny), np.floor(u1 - tiny) + 1.0)
    knots = np.concatenate([[u0] * 4, integers, [u1] * 4])
    while len(np.unique(knots)) - 1 < least:
        knots = halved(knots)
    return knots
