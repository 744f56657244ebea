"""Numbers that depend on small steps nearly linearly, with a bound of what is not (Taylor forms).

Glossary
--------
form
    A function f of steps s in the cube ``|s_j| <= 1``: ``value + slope . s + s . bend s / 2`` and
    a number `rest` that it is never further off.
linear form
    The same without the quadratic part, its rest so much larger.

Sums are exact; of a product only what is of third order goes into the rest, of a function of one
form (a root, a quotient) what its third derivative allows over the form's range. Rounding, some
1e-13 of the values, is left out.

Source: Makino and Berz, Taylor models and other validated functional inclusion methods (2003).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fabgeo.arrays import Array, IntArray

type Function = Callable[[Array], Array]


@dataclass(frozen=True)
class Linear:
    """Linear forms.

    Attributes
    ----------
    value, rest : (...) arrays
    slope : (..., f) array
    """

    value: Array
    slope: Array
    rest: Array

    def some(self, index: IntArray) -> Linear:
        """Those of an index into the first axis."""
        return Linear(self.value[index], self.slope[index], self.rest[index])


@dataclass(frozen=True)
class Form:
    """Forms.

    Attributes
    ----------
    value, rest : (...) arrays
    slope : (..., f) array
    bend : (..., f, f) array
        Symmetric.
    """

    value: Array
    slope: Array
    bend: Array
    rest: Array

    @classmethod
    def of(cls, value: Array, slope: Array) -> Form:
        """Exactly linear ones."""
        bend = np.zeros((*slope.shape, slope.shape[-1]))
        return cls(value, slope, bend, np.zeros(value.shape))

    @classmethod
    def constant(cls, value: Array, steps: int) -> Form:
        """What no step changes."""
        return cls.of(value, np.zeros((*value.shape, steps)))

    @classmethod
    def joined(cls, forms: Sequence[Form]) -> Form:
        """Forms (p, ...) side by side along their second axis."""
        names = ("value", "slope", "bend", "rest")
        return cls(*(np.concatenate([getattr(f, n) for f in forms], axis=1) for n in names))

    def __getitem__(self, index: tuple) -> Form:
        """Some of the forms, or with new axes among theirs."""
        steps = (slice(None),)
        return Form(
            self.value[index],
            self.slope[index + steps],
            self.bend[index + 2 * steps],
            self.rest[index],
        )

    def shaped(self, *shape: int) -> Form:
        """The forms in another shape (p, ...)."""
        steps = self.slope.shape[-1:]
        shape = (len(self.value), *shape)
        value = self.value.reshape(shape)
        shape = value.shape
        return Form(
            value,
            self.slope.reshape(shape + steps),
            self.bend.reshape(shape + 2 * steps),
            self.rest.reshape(shape),
        )

    @cached_property
    def first(self) -> Array:
        """What the linear part is at most."""
        return np.abs(self.slope).sum(axis=-1)

    @cached_property
    def second(self) -> Array:
        """What all beyond the linear part is at most."""
        return 0.5 * np.abs(self.bend).sum(axis=(-1, -2)) + self.rest

    @cached_property
    def most(self) -> Array:
        """Largest absolute value."""
        return np.abs(self.value) + self.first + self.second

    @property
    def linear(self) -> Linear:
        """Linear forms: a square of a step is between zero and one, a product between -1 and 1."""
        own = np.diagonal(self.bend, axis1=-2, axis2=-1) / 4.0
        all_ = 0.5 * np.abs(self.bend).sum(axis=(-1, -2))
        return Linear(
            self.value + own.sum(axis=-1), self.slope, all_ - np.abs(own).sum(axis=-1) + self.rest
        )

    def __add__(self, other: Form | Array | float) -> Form:
        if not isinstance(other, Form):
            return Form(self.value + other, self.slope, self.bend, self.rest)
        return Form(
            self.value + other.value,
            self.slope + other.slope,
            self.bend + other.bend,
            self.rest + other.rest,
        )

    def __neg__(self) -> Form:
        return self.scaled(-1.0)

    def __sub__(self, other: Form) -> Form:
        return self + (-other)

    def scaled(self, factor: Array | float) -> Form:
        """The forms times known numbers."""
        by = np.asarray(factor, dtype=float)
        return Form(
            self.value * by,
            self.slope * by[..., None],
            self.bend * by[..., None, None],
            self.rest * np.abs(by),
        )

    def wider(self, rest: Array | float) -> Form:
        """The forms with that much more left open."""
        return Form(self.value, self.slope, self.bend, self.rest + rest)

    def __mul__(self, other: Form) -> Form:
        v, w = self.value, other.value
        both = self.slope[..., :, None] * other.slope[..., None, :]
        bend = w[..., None, None] * self.bend + v[..., None, None] * other.bend
        a, b = self.first, other.first
        p, q = self.second - self.rest, other.second - other.rest
        return Form(
            v * w,
            w[..., None] * self.slope + v[..., None] * other.slope,
            bend + both + np.swapaxes(both, -1, -2),
            a * q + b * p + p * q + self.most * other.rest + other.most * self.rest,
        )

    def function(self, f: Function, by: Function, twice: Function, third: Function) -> Form:
        """A function of the forms, from its derivatives.

        Parameters
        ----------
        f, by, twice : callables
            The function and its first two derivatives.
        third : callable
            Its largest third derivative from the lower ends of the forms' ranges on.
        """
        one, two = by(self.value), twice(self.value)
        a, p = self.first, self.second
        square = self.slope[..., :, None] * self.slope[..., None, :]
        rest = np.abs(one) * self.rest + np.abs(two) * (a * p + p * p / 2.0)
        return Form(
            f(self.value),
            one[..., None] * self.slope,
            one[..., None, None] * self.bend + two[..., None, None] * square,
            rest + third(self.value - a - p) * (a + p) ** 3 / 6.0,
        )

    def root(self) -> Form:
        """Square root, of positive forms."""
        return self.function(
            np.sqrt,
            lambda x: 0.5 * x**-0.5,
            lambda x: -0.25 * x**-1.5,
            lambda low: 0.375 * _positive(low) ** -2.5,
        )

    def inverse(self) -> Form:
        """Reciprocal, of positive forms."""
        return self.function(
            lambda x: 1.0 / x,
            lambda x: -(x**-2.0),
            lambda x: 2.0 * x**-3.0,
            lambda low: 6.0 * _positive(low) ** -4.0,
        )

    def series(self, coefficients: Sequence[float], beyond: float) -> Form:
        """An alternating power series of forms, cut short.

        Parameters
        ----------
        coefficients : sequence of float
            From the constant on.
        beyond : float
            The first that is left out, absolute.
        """
        total = self.scaled(0.0) + coefficients[-1]
        for c in coefficients[-2::-1]:
            total = total * self + c
        return total.wider(1.1 * beyond * self.most ** len(coefficients))


def _positive(low: Array) -> Array:
    """Lower ends; where a form may vanish nothing is known of its functions."""
    return np.where(low > 0.0, low, np.nan)


def arc(square: Form) -> Form:
    """``arctan(x) / x`` by ``w = x^2``: the integral of ``1 / (1 + w t^2)`` from 0 to 1."""

    def f(w: Array) -> Array:
        x = np.sqrt(np.maximum(w, 1e-6))
        return np.where(w > 1e-6, np.arctan(x) / x, 1.0 - w / 3.0)

    def by(w: Array) -> Array:
        v = np.maximum(w, 1e-2)
        exact = (1.0 / (1.0 + v) - f(v)) / (2.0 * v)
        return np.where(w > 1e-2, exact, _powers(w, (-1 / 3, 2 / 5, -3 / 7, 4 / 9, -5 / 11)))

    def twice(w: Array) -> Array:
        v = np.maximum(w, 1e-2)
        exact = -((1.0 + v) ** -2.0 + by(v)) / (2.0 * v) - by(v) / v
        return np.where(w > 1e-2, exact, _powers(w, (2 / 5, -6 / 7, 12 / 9, -20 / 11, 30 / 13)))

    def third(low: Array) -> Array:
        return 6.0 / 7.0 * _positive(1.0 + np.minimum(low, 0.0)) ** -4.0

    # Powers cut short are off by less than 4 w^5 for w up to 0.01.
    return square.function(f, by, twice, third).wider(1e-9)


def sine(square: Form) -> Form:
    """``sin(x) / x`` by ``w = x^2``."""
    return square.series((1.0, -1 / 6, 1 / 120, -1 / 5040), 1 / 362880)


def versine(square: Form) -> Form:
    """``(1 - cos x) / x^2`` by ``w = x^2``."""
    return square.series((1 / 2, -1 / 24, 1 / 720, -1 / 40320), 1 / 3628800)


def _powers(w: Array, coefficients: Sequence[float]) -> Array:
    total = np.zeros_like(w)
    for c in coefficients[::-1]:
        total = total * w + c
    return total
