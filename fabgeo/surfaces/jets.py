"""Second-order Taylor arithmetic in two variables: exact first and second derivatives of formulas.

Glossary
--------
jet
    A value with its derivatives by u and v up to the second order, for many points at once:
    f, f_u, f_v, f_uu, f_uv, f_vv. Constants stay plain floats.

Source: Griewank, Walther, Evaluating Derivatives, 2nd ed., chapter 13 (Taylor coefficients).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, BoolArray

type Value = "Jet | float"


@dataclass(frozen=True, slots=True, eq=False)
class Jet:
    """A function's value f and its derivatives u, v, uu, uv, vv, each an array (k,)."""

    f: Array
    u: Array
    v: Array
    uu: Array
    uv: Array
    vv: Array

    def __neg__(self) -> Jet:
        return Jet(-self.f, -self.u, -self.v, -self.uu, -self.uv, -self.vv)

    def __add__(self, other: Value) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.f + other, self.u, self.v, self.uu, self.uv, self.vv)
        return Jet(
            self.f + other.f,
            self.u + other.u,
            self.v + other.v,
            self.uu + other.uu,
            self.uv + other.uv,
            self.vv + other.vv,
        )

    __radd__ = __add__

    def __sub__(self, other: Value) -> Jet:
        return self + (-other)

    def __rsub__(self, other: Value) -> Jet:
        return -self + other

    def __mul__(self, other: Value) -> Jet:
        if not isinstance(other, Jet):
            return Jet(
                self.f * other,
                self.u * other,
                self.v * other,
                self.uu * other,
                self.uv * other,
                self.vv * other,
            )
        a, b = self, other
        return Jet(
            a.f * b.f,
            a.u * b.f + a.f * b.u,
            a.v * b.f + a.f * b.v,
            a.uu * b.f + 2.0 * a.u * b.u + a.f * b.uu,
            a.uv * b.f + a.u * b.v + a.v * b.u + a.f * b.uv,
            a.vv * b.f + 2.0 * a.v * b.v + a.f * b.vv,
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Value) -> Jet:
        if not isinstance(other, Jet):
            return self * (1.0 / other)
        return self * reciprocal(other)

    def __rtruediv__(self, other: Value) -> Jet:
        return reciprocal(self) * other

    def __pow__(self, other: Value) -> Jet:
        if isinstance(other, Jet):
            return exp(log(self) * other)
        p = other
        if p == 0.0:
            return constant_like(self, 1.0)
        if p == 1.0:
            return self
        if p == 2.0:
            return self * self
        return chain(
            self, self.f**p, p * self.f ** (p - 1.0), p * (p - 1.0) * _power(self.f, p - 2.0)
        )

    def __rpow__(self, other: float) -> Jet:
        return exp(self * float(np.log(other)))


def _power(base: Array, exponent: float) -> Array:
    return np.ones_like(base) if exponent == 0.0 else base**exponent


def chain(a: Jet, f: Array, first: Array, second: Array) -> Jet:
    """The jet of g(a) from g, g' and g'' at a (chain rule)."""
    return Jet(
        f,
        first * a.u,
        first * a.v,
        first * a.uu + second * a.u * a.u,
        first * a.uv + second * a.u * a.v,
        first * a.vv + second * a.v * a.v,
    )


def constant_like(a: Jet, value: float) -> Jet:
    """A constant as a jet of the same size."""
    zero = np.zeros_like(a.f)
    return Jet(zero + value, zero, zero, zero, zero, zero)


def variables(u: Array, v: Array) -> tuple[Jet, Jet]:
    """The jets of u and v themselves."""
    zero, one = np.zeros_like(u), np.ones_like(u)
    return Jet(u, one, zero, zero, zero, zero), Jet(v, zero, one, zero, zero, zero)


def reciprocal(a: Jet) -> Jet:
    """1 / a."""
    r = 1.0 / a.f
    return chain(a, r, -r * r, 2.0 * r * r * r)


def exp(a: Jet) -> Jet:
    """Exponential function."""
    e = np.exp(a.f)
    return chain(a, e, e, e)


def log(a: Jet) -> Jet:
    """Natural logarithm."""
    r = 1.0 / a.f
    return chain(a, np.log(a.f), r, -r * r)


def _sqrt(a: Jet) -> Jet:
    s = np.sqrt(a.f)
    return chain(a, s, 0.5 / s, -0.25 / (s * a.f))


def _sin(a: Jet) -> Jet:
    s, c = np.sin(a.f), np.cos(a.f)
    return chain(a, s, c, -s)


def _cos(a: Jet) -> Jet:
    s, c = np.sin(a.f), np.cos(a.f)
    return chain(a, c, -s, -c)


def _tan(a: Jet) -> Jet:
    t = np.tan(a.f)
    d = 1.0 + t * t
    return chain(a, t, d, 2.0 * t * d)


def _asin(a: Jet) -> Jet:
    q = 1.0 / np.sqrt(1.0 - a.f * a.f)
    return chain(a, np.arcsin(a.f), q, a.f * q**3)


def _acos(a: Jet) -> Jet:
    q = 1.0 / np.sqrt(1.0 - a.f * a.f)
    return chain(a, np.arccos(a.f), -q, -a.f * q**3)


def _atan(a: Jet) -> Jet:
    q = 1.0 / (1.0 + a.f * a.f)
    return chain(a, np.arctan(a.f), q, -2.0 * a.f * q * q)


def _sinh(a: Jet) -> Jet:
    s, c = np.sinh(a.f), np.cosh(a.f)
    return chain(a, s, c, s)


def _cosh(a: Jet) -> Jet:
    s, c = np.sinh(a.f), np.cosh(a.f)
    return chain(a, c, s, c)


def _tanh(a: Jet) -> Jet:
    t = np.tanh(a.f)
    d = 1.0 - t * t
    return chain(a, t, d, -2.0 * t * d)


def _abs(a: Jet) -> Jet:
    return a * _where(a.f < 0.0, -1.0, 1.0, a)


def _where(condition: BoolArray, yes: Value, no: Value, like: Jet) -> Jet:
    y = yes if isinstance(yes, Jet) else constant_like(like, yes)
    n = no if isinstance(no, Jet) else constant_like(like, no)
    pairs = zip(_parts(y), _parts(n), strict=True)
    return Jet(*(np.where(condition, p, q) for p, q in pairs))


def _parts(a: Jet) -> tuple[Array, ...]:
    return a.f, a.u, a.v, a.uu, a.uv, a.vv


def _value(a: Value) -> Array | float:
    return a.f if isinstance(a, Jet) else a


def _extreme(sign: float) -> Callable[..., Value]:
    def extreme(*values: Value) -> Value:
        best = values[0]
        for other in values[1:]:
            like = other if isinstance(other, Jet) else best
            keep = sign * _value(best) >= sign * _value(other)
            if isinstance(like, Jet):
                best = _where(np.asarray(keep), best, other, like)
            else:
                best = best if keep else other
        return best

    return extreme


def _hypot(*values: Value) -> Value:
    total: Value = 0.0
    for a in values:
        total = a * a + total
    return _sqrt(total) if isinstance(total, Jet) else float(np.sqrt(total))


def _atan2(y: Value, x: Value) -> Value:
    """Angle of (x, y); derivatives by the formula that is regular everywhere but at 0."""
    if not isinstance(y, Jet) and not isinstance(x, Jet):
        return float(np.arctan2(y, x))
    like = y if isinstance(y, Jet) else x
    if not isinstance(like, Jet):  # for the type checker: one of them is
        return float("nan")
    b = y if isinstance(y, Jet) else constant_like(like, y)
    a = x if isinstance(x, Jet) else constant_like(like, x)
    square = a * a + b * b
    # d = (a db - b da) / (a^2 + b^2), differentiated once more.
    du = (_derived(b, "u") * a - _derived(a, "u") * b) / square
    dv = (_derived(b, "v") * a - _derived(a, "v") * b) / square
    return Jet(np.arctan2(b.f, a.f), du.f, dv.f, du.u, du.v, dv.v)


def _derived(a: Jet, by: str) -> Jet:
    """The first derivative as a jet of first order (its second derivatives aren't used)."""
    nought = np.zeros_like(a.f)
    if by == "u":
        return Jet(a.u, a.uu, a.uv, nought, nought, nought)
    return Jet(a.v, a.uv, a.vv, nought, nought, nought)


def _one(jet: Callable[[Jet], Jet], plain: Callable[[float], float]) -> Callable[[Value], Value]:
    def function(a: Value) -> Value:
        return jet(a) if isinstance(a, Jet) else float(plain(a))

    return function


# Name in a formula: function and the number of its arguments (least, most).
FUNCTIONS: dict[str, tuple[Callable[..., Value], int, int]] = {
    "sin": (_one(_sin, np.sin), 1, 1),
    "cos": (_one(_cos, np.cos), 1, 1),
    "tan": (_one(_tan, np.tan), 1, 1),
    "asin": (_one(_asin, np.arcsin), 1, 1),
    "acos": (_one(_acos, np.arccos), 1, 1),
    "atan": (_one(_atan, np.arctan), 1, 1),
    "sinh": (_one(_sinh, np.sinh), 1, 1),
    "cosh": (_one(_cosh, np.cosh), 1, 1),
    "tanh": (_one(_tanh, np.tanh), 1, 1),
    "sqrt": (_one(_sqrt, np.sqrt), 1, 1),
    "exp": (_one(exp, np.exp), 1, 1),
    "log": (_one(log, np.log), 1, 1),
    "abs": (_one(_abs, abs), 1, 1),
    "atan2": (_atan2, 2, 2),
    "hypot": (_hypot, 2, 3),
    "min": (_extreme(-1.0), 2, 8),
    "max": (_extreme(1.0), 2, 8),
}
CONSTANTS: dict[str, float] = {"pi": float(np.pi), "e": float(np.e)}
