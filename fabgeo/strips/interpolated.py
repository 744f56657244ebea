"""Cubic B-splines through curves that are no splines: Greville interpolation, measured.

Offsets, trajectories and normals are exact functions of u; parts are built on splines. Several
curves are interpolated at once on common knots; knots are halved until the error is within the
tolerance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import BSpline

from fabgeo import spline
from fabgeo.arrays import Array
from fabgeo.errors import GeometryError

type Curves = Callable[[Array], Array]

HALVINGS = 5  # of all knot spans
CLOSER = 5  # further ones, of those where the error is


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

    Then only spans that are still off are halved: beside knots of the model where a second
    derivative enters, as in envelopes, curves have kinks of thousandths of a degree.

    Raises
    ------
    GeometryError
        If the tolerance can't be reached.
    """
    error = np.inf
    for attempt in range(HALVINGS + CLOSER):
        made, at, away = _through(curves, knots)
        error = made.error
        if error <= tolerance:
            return made
        knots = halved(knots, at[away > tolerance] if attempt >= HALVINGS else None)
    raise GeometryError(
        where,
        f"its curves can't be interpolated to {tolerance:g} mm (found {error:.3g})",
        "look for a kink or a fold of the model there; more segments make its curves smoother",
    )


def _through(curves: Curves, knots: Array) -> tuple[Interpolated, Array, Array]:
    """The curves on these knots, and how far they are off at which u."""
    scaled = np.round((knots - knots[0]) / (knots[-1] - knots[0]), 12)
    rule = _rule(scaled.tobytes())
    sites = knots[0] + rule.sites * (knots[-1] - knots[0])
    values = curves(sites)
    count = len(knots) - 4
    poles = np.einsum("pk,nkd->npd", rule.inverse, values[:, :count])
    found = np.einsum("kp,npd->nkd", rule.checks, poles)
    away = np.linalg.norm(found - values[:, count:], axis=-1).max(axis=0)
    return Interpolated(knots, poles, float(away.max())), sites[count:], away


@dataclass(frozen=True)
class _Rule:
    """Interpolation on one knot vector scaled to [0, 1]; many parts share one.

    Attributes
    ----------
    sites : (k + c,) array
        Greville points, then c points between them at which the error is measured.
    inverse : (k, k) array
        From points at Greville points to poles.
    checks : (c, k) array
        From poles to points at the checks.
    """

    sites: Array
    inverse: Array
    checks: Array


@lru_cache(maxsize=512)
def _rule(key: bytes) -> _Rule:
    knots = np.frombuffer(key, dtype=np.float64)
    given = np.clip(spline.greville(knots), 0.0, 1.0)
    checks = np.sort(np.concatenate([(given[1:] + given[:-1]) / 2.0, np.unique(knots)]))
    collocation = BSpline.design_matrix(given, knots, 3).toarray()
    return _Rule(
        np.concatenate([given, checks]),
        np.linalg.inv(collocation),
        BSpline.design_matrix(checks, knots, 3).toarray(),
    )


def halved(knots: Array, at: Array | None = None) -> Array:
    """Clamped knots with the middle of every span added, or of those in which some u lie."""
    spans = np.unique(knots)
    middles = (spans[1:] + spans[:-1]) / 2.0
    if at is not None:
        tiny = 1e-9 * (spans[-1] - spans[0])
        places = np.concatenate([np.searchsorted(spans, at + step) - 1 for step in (-tiny, tiny)])
        middles = middles[np.unique(np.clip(places, 0, len(middles) - 1))]
    return np.sort(np.concatenate([knots, middles]))


def knots_between(u0: float, u1: float, least: int = 2, multiplicity: int = 1) -> Array:
    """Clamped knots on [u0, u1] with the integers between as knots, at least so many spans.

    What is made of a model's tangents is smooth but at the model's own knots, where only its first
    derivative is continuous: with `multiplicity` 2 there, few spans reach a tolerance.

    A cut a hair beside an integer gives no sliver span: integers nearer than 0.02 are left out.
    """
    tiny = 0.02
    integers = np.arange(np.ceil(u0 + tiny), np.floor(u1 - tiny) + 1.0)
    knots = np.concatenate([[u0] * 4, np.repeat(integers, multiplicity), [u1] * 4])
    while len(np.unique(knots)) - 1 < least:
        knots = halved(knots)
    return knots
