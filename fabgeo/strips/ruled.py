"""One ruled patch as an exact degree 3 x 1 B-spline: what every plate and every face is made on.

Glossary
--------
edge curves
    Two clamped cubic B-splines with common knots; points of equal parameter lie on one ruling.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from fabgeo import spline
from fabgeo.arrays import FARTHEST, Array, checked, checked_count, set_frozen
from fabgeo.errors import InputError
from fabgeo.strips.model import FINEST, Patch, StripModel, check_patch


@dataclass(frozen=True)
class RuledPatch:
    """The ruled surface x(u, v) = (1 - v) a(u) + v b(u) between two clamped cubic B-splines.

    Attributes
    ----------
    knots : (k + 4,) array
        Clamped cubic knots; u runs from `u0` to `u1`.
    poles : (2, k, 3) array
        Control points of the edge curves a and b.
    """

    knots: Array
    poles: Array

    def __post_init__(self) -> None:
        set_frozen(self, "knots", ("n",), most=spline.FARTHEST_U)
        set_frozen(self, "poles", (2, "k", 3), most=FARTHEST)
        if self.poles.shape[1] < 4:
            raise InputError(
                "RuledPatch.poles", f"expected 4 or more an edge, found {self.poles.shape[1]}"
            )
        if len(self.knots) != self.poles.shape[1] + 4 or np.any(np.diff(self.knots) < 0.0):
            raise InputError(
                "RuledPatch.knots",
                f"expected {self.poles.shape[1] + 4} ascending knots, found {len(self.knots)}",
            )
        _check_clamped(self.knots)

    @property
    def u0(self) -> float:
        """First parameter."""
        return float(self.knots[0])

    @property
    def u1(self) -> float:
        """Last parameter."""
        return float(self.knots[-1])

    def edges(self, u: Array, derivative: int = 0) -> Array:
        """Points or u-derivatives (2, k, 3), of order 0 to 3, of both edge curves at u (k,)."""
        u = spline.checked_parameters("RuledPatch.edges", u, 1)
        checked_count("derivative", derivative, 0, 3)
        return np.asarray(self._curves(u, derivative), dtype=np.float64).swapaxes(0, 1)

    @cached_property
    def _curves(self) -> BSpline:
        return BSpline.construct_fast(
            self.knots, np.ascontiguousarray(self.poles.swapaxes(0, 1)), 3
        )

    def points(self, u: Array, v: Array) -> Array:
        """Surface points at parameters u, v of equal shape (k,): (k, 3)."""
        a, b = self.edges(u)
        v = checked("RuledPatch.points: v", v, (len(a),), most=FARTHEST)
        return a + v[:, None] * (b - a)

    def parameters(self, per_span: int = 8) -> Array:
        """Evenly spaced parameters, `per_span` to a knot span, both ends included."""
        checked_count("per_span", per_span, 1, FINEST)
        spans = np.unique(self.knots)
        fraction = np.arange(per_span) / per_span
        inner = spans[:-1, None] + fraction * np.diff(spans)[:, None]
        return np.append(inner.ravel(), spans[-1])

    @classmethod
    def of_model(cls, model: StripModel, patch: Patch) -> Self:
        """The patch of a strip model, exactly (the spline's own pieces, knots kept)."""
        check_patch("RuledPatch.of_model", model, patch)
        index = [patch.strip, (patch.strip + 1) % model.edges]
        knots, poles = spline.clip(model.control[index], model.closed_u, patch.u0, patch.u1)
        return cls(knots, poles)

    @classmethod
    def through(cls, knots: Array, sites: Array, first: Array, second: Array) -> Self:
        """Interpolate points of both edge curves (k, 3) given at sites (k,), e.g. Greville's."""
        name, sizes = "RuledPatch.through", {}
        knots, sites = checked(name, knots, (None,)), checked(name, sites, ("k",), sizes)
        first, second = (checked(name, x, ("k", 3), sizes, FARTHEST) for x in (first, second))
        try:
            points = np.stack([first, second], axis=1)
            poles = np.asarray(make_interp_spline(sites, points, k=3, t=knots).c)
        except ValueError as error:
            raise InputError(
                "RuledPatch.through", f"no curve runs through that: {error}"
            ) from error
        return cls(knots, np.moveaxis(poles, 1, 0))


def _check_clamped(knots: Array) -> None:
    """Refuse knots whose curve does not begin and end at its first and last pole."""
    clamped = knots[0] == knots[3] and knots[-4] == knots[-1]
    if not clamped or (knots[4:] <= knots[:-4]).any():
        raise InputError(
            "RuledPatch.knots",
            "expected the first and last one fourfold, others threefold at most",
            "see spline.clamped_knots",
        )
