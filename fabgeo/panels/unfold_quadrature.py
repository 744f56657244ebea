"""Cumulative Gauss quadrature on pieces: integrals up to every node and every break point.

Glossary
--------
piece
    An interval between two break points; smooth inside (knots are break points).
nodes
    Gauss-Legendre points of a piece.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import legendre

from fabgeo.arrays import Array, BoolArray


@cache
def _rule(order: int) -> tuple[Array, Array, Array, Array]:
    """Nodes, weights on [-1, 1], the matrix of integrals up to each node, Legendre analysis."""
    nodes, weights = legendre.leggauss(order)
    vandermonde = legendre.legvander(nodes, order - 1)
    analysis = np.asarray(np.linalg.inv(vandermonde), dtype=np.float64)
    upto = np.empty((order, order))
    for k in range(order):
        integral = legendre.legint(np.eye(order)[k], lbnd=-1)
        upto[:, k] = legendre.legval(nodes, integral)
    return np.asarray(nodes), np.asarray(weights), upto @ analysis, analysis


@dataclass(frozen=True)
class Quadrature:
    """Pieces with `order` Gauss nodes each.

    Attributes
    ----------
    breaks : (p + 1,) array
    order : int
    """

    breaks: Array
    order: int = 8

    @property
    def nodes(self) -> Array:
        """All nodes, (p, order)."""
        x = _rule(self.order)[0]
        return self.breaks[:-1, None] + self._half[:, None] * (x + 1.0)

    @property
    def _half(self) -> Array:
        return np.diff(self.breaks) / 2.0

    def cumulative(self, values: Array) -> tuple[Array, Array]:
        """Integrals from the first break point of values (p, order, ...) at the nodes.

        Returns
        -------
        at_nodes : (p, order, ...) array
        at_breaks : (p + 1, ...) array
        """
        _, weights, upto, _ = _rule(self.order)
        half = self._half.reshape(-1, *([1] * (values.ndim - 2)))
        steps = half * np.einsum("k,pk...->p...", weights, values)
        at_breaks = np.concatenate([np.zeros_like(steps[:1]), np.cumsum(steps, axis=0)])
        inside = half[:, None] * np.einsum("jk,pk...->pj...", upto, values)
        return at_breaks[:-1, None] + inside, at_breaks

    def integral(self, values: Array) -> Array:
        """Integral over all pieces of values (p, order, ...)."""
        weights = _rule(self.order)[1]
        return np.einsum("p,k,pk...->...", self._half, weights, values)

    def halved(self, which: BoolArray | None = None) -> Quadrature:
        """The same rule with every piece, or those of `which` (p,), cut in two."""
        middle = (self.breaks[:-1] + self.breaks[1:]) / 2.0
        if which is not None:
            middle = middle[which]
        return Quadrature(np.sort(np.concatenate([self.breaks, middle])), self.order)

    def tail(self, values: Array) -> Array:
        """What the rule can't see in each piece (p,): the last Legendre coefficients times it."""
        analysis = _rule(self.order)[3]
        last = np.einsum("jk,pk...->pj...", analysis[-2:], values)
        half = self._half.reshape(-1, *([1] * (last.ndim - 1)))
        return np.abs(last * half).reshape(len(last), -1).max(axis=1)


def pieces(knots: Array, least: int) -> Array:
    """Break points: every knot span cut evenly so that there are `least` pieces or more."""
    spans = np.unique(knots)
    each = max(1, -(-least // (len(spans) - 1)))
    fraction = np.arange(each) / each
    inner = spans[:-1, None] + fraction * np.diff(spans)[:, None]
    return np.append(inner.ravel(), spans[-1])
