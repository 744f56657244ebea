"""Rational and polynomial tensor-product B-spline charts, evaluated in numpy.

Source: Piegl, Tiller, The NURBS Book, 2nd ed., algorithms A2.2, A2.3 (basis), A4.4 (quotients).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fabgeo.arrays import Array, IntArray, frozen
from fabgeo.errors import InputError
from fabgeo.surfaces.chart import Derivatives

MOST_AS_POWERS = 7  # degree up to which powers on a knot span lose no more than rounding


class BSplineChart:
    """A B-spline patch.

    Parameters
    ----------
    poles : (n, m, 3) array_like
        Control points, first axis along u.
    knots_u, knots_v : (n + p + 1,), (m + q + 1,) array_like
        Flat knot vectors; the domain is [knots[p], knots[n]].
    degree_u, degree_v : int
    weights : (n, m) array_like, optional
        Positive; omitted: polynomial.
    closed : (bool, bool)
        Whether the patch is said to be periodic in u, v.

    Raises
    ------
    InputError
        If shapes do not fit, knots fall or a weight is not positive.
    """

    def __init__(
        self,
        poles: npt.ArrayLike,
        knots_u: npt.ArrayLike,
        knots_v: npt.ArrayLike,
        degree_u: int = 3,
        degree_v: int = 3,
        weights: npt.ArrayLike | None = None,
        closed: tuple[bool, bool] = (False, False),
    ) -> None:
        self.poles = frozen("B-spline poles", poles, (None, None, 3))
        rows, columns, _ = self.poles.shape
        self.degrees = (int(degree_u), int(degree_v))
        self.knots = tuple(
            _checked_knots(word, knots, count, degree)
            for word, knots, count, degree in zip(
                "uv", (knots_u, knots_v), (rows, columns), self.degrees, strict=True
            )
        )
        self.weights: Array | None = None
        homogeneous = self.poles
        if weights is not None:
            w = frozen("B-spline weights", weights, (rows, columns))
            if not (w > 0.0).all():
                raise InputError("B-spline weights", "expected positive weights")
            if np.ptp(w) > 1e-12 * w.max():
                self.weights = w
                homogeneous = np.concatenate([self.poles * w[..., None], w[..., None]], axis=-1)
        self._homogeneous = homogeneous
        self.domain = np.array(
            [[k[p], k[-p - 1]] for k, p in zip(self.knots, self.degrees, strict=True)]
        )
        self.closed = closed
        spans = [
            len(np.unique(k[p : len(k) - p])) - 1
            for k, p in zip(self.knots, self.degrees, strict=True)
        ]
        self.spans = (spans[0] * min(self.degrees[0], 3), spans[1] * min(self.degrees[1], 3))
        self._pieces = [Pieces(k, p) for k, p in zip(self.knots, self.degrees, strict=True)]

    def evaluate(self, u: Array, v: Array) -> Derivatives:
        """Points and exact derivatives (k, 3) at parameters (k,)."""
        (iu, bu), (iv, bv) = self._pieces[0](u), self._pieces[1](v)
        local = self._homogeneous[iu[:, :, None], iv[:, None, :]]
        k, p, q, dimension = local.shape
        # First along u for all orders, then along v: (k, order u, q + 1, d).
        along = (bu @ local.reshape(k, p, q * dimension)).reshape(k, 3, q, dimension)
        every = bv[:, None] @ along
        h = {(a, b): every[:, a, b] for a in range(3) for b in range(3 - a)}
        if self.weights is None:
            return Derivatives(h[0, 0], h[1, 0], h[0, 1], h[2, 0], h[1, 1], h[0, 2])
        return _quotient(h)


def _checked_knots(word: str, knots: npt.ArrayLike, count: int, degree: int) -> Array:
    where = f"B-spline knots {word}"
    if not 1 <= degree <= 25:
        raise InputError(where, f"expected a degree of 1 to 25, found {degree}")
    if count <= degree:
        raise InputError(where, f"degree {degree} needs {degree + 1} poles, found {count}")
    k = frozen(where, knots, (count + degree + 1,))
    if (np.diff(k) < 0.0).any() or not k[degree] < k[count]:
        raise InputError(where, "expected knots that rise")
    return k


def _quotient(h: dict[tuple[int, int], Array]) -> Derivatives:
    """Derivatives of A / w from those of (A, w), NURBS Book eq. 4.20."""
    a = {k: x[:, :3] for k, x in h.items()}
    w = {k: x[:, 3:] for k, x in h.items()}
    s = a[0, 0] / w[0, 0]
    su = (a[1, 0] - w[1, 0] * s) / w[0, 0]
    sv = (a[0, 1] - w[0, 1] * s) / w[0, 0]
    suu = (a[2, 0] - 2.0 * w[1, 0] * su - w[2, 0] * s) / w[0, 0]
    suv = (a[1, 1] - w[1, 0] * sv - w[0, 1] * su - w[1, 1] * s) / w[0, 0]
    svv = (a[0, 2] - 2.0 * w[0, 1] * sv - w[0, 2] * s) / w[0, 0]
    return Derivatives(s, su, sv, suu, suv, svv)


class Pieces:
    """The basis functions of a knot vector as polynomials on each knot span, to be quick.

    Answers (k, degree + 1) indices and (k, order, degree + 1) values.
    """

    def __init__(self, knots: Array, degree: int) -> None:
        self._knots, self._degree = knots, degree
        count = len(knots) - degree - 1
        self._last = max(int(np.searchsorted(knots, knots[count], side="left")) - 1, degree)
        if degree > MOST_AS_POWERS:
            return
        span = np.arange(degree, self._last + 1)
        self._middle = (knots[span] + knots[span + 1]) / 2.0
        self._scale = 2.0 / np.maximum(knots[span + 1] - knots[span], 1e-300)
        # Through the places of Chebyshev in [-1, 1], powers 0..degree.
        x = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
        t = self._middle[:, None] + x / self._scale[:, None]
        _, value = basis_functions(knots, degree, t.ravel())
        inverse = np.linalg.inv(np.vander(x, increasing=True))
        values = value[0].reshape(degree + 1, len(span), degree + 1)
        self._powers = np.einsum("mx,asx->sma", inverse, values)

    def __call__(self, t: Array) -> tuple[IntArray, Array]:
        """Which poles act at t (k,), and their basis functions with two derivatives."""
        degree = self._degree
        if degree > MOST_AS_POWERS:
            index, value = basis_functions(self._knots, degree, t)
            return index, np.ascontiguousarray(np.moveaxis(value, 2, 0))
        span = np.searchsorted(self._knots, t, side="right") - 1
        span = np.minimum(np.maximum(span, degree), self._last)
        at = span - degree
        scale = self._scale[at]
        x = (t - self._middle[at]) * scale
        power = np.zeros((len(t), 3, degree + 1))
        power[:, 0, 0] = 1.0
        for m in range(1, degree + 1):
            power[:, 0, m] = x * power[:, 0, m - 1]
        order = np.arange(1.0, degree + 1)
        power[:, 1, 1:] = order * power[:, 0, :-1] * scale[:, None]
        power[:, 2, 1:] = order * power[:, 1, :-1] * scale[:, None]
        return span[:, None] + np.arange(-degree, 1), power @ self._powers[at]


def basis_functions(knots: Array, degree: int, t: Array) -> tuple[IntArray, Array]:
    """Non-zero basis functions and their first two derivatives.

    Returns
    -------
    index : (k, degree + 1) int array
        Which poles act.
    value : (3, degree + 1, k) array
        Order of derivative, pole, point.
    """
    count = len(knots) - degree - 1
    last = int(np.searchsorted(knots, knots[count], side="left")) - 1
    span = np.clip(np.searchsorted(knots, t, side="right") - 1, degree, max(last, degree))
    value = np.zeros((3, degree + 1, len(t)))
    tables = _triangle(knots, degree, span, t)
    value[0] = tables[degree]
    lower = tables[degree - 1]
    value[1] = _differences(knots, degree, span, lower)
    if degree >= 2:
        first = _differences(knots, degree - 1, span, tables[degree - 2])
        value[2] = _differences(knots, degree, span, first)
    return span[:, None] + np.arange(-degree, 1), value


def _triangle(knots: Array, degree: int, span: IntArray, t: Array) -> list[Array]:
    """Basis functions of degrees 0..degree on the span: entry p is (p + 1, k)."""
    tables: list[Array] = [np.ones((1, len(t)))]
    for p in range(1, degree + 1):
        previous, new = tables[-1], np.zeros((p + 1, len(t)))
        for r in range(p):
            right, left = knots[span + r + 1], knots[span + r + 1 - p]
            share = previous[r] / np.where(right > left, right - left, 1.0)
            new[r] += (right - t) * share
            new[r + 1] += (t - left) * share
        tables.append(new)
    return tables


def _differences(knots: Array, degree: int, span: IntArray, lower: Array) -> Array:
    """Derivative of a degree's basis from (derivatives of) the basis one degree lower."""
    new = np.zeros((degree + 1, lower.shape[1]))
    for r in range(degree):
        width = knots[span + r + 1] - knots[span + r + 1 - degree]
        share = degree * lower[r] / np.where(width > 0.0, width, 1.0)
        new[r] -= share
        new[r + 1] += share
    return new
