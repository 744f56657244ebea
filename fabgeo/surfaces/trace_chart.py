"""What a surface with a parametrisation offers to those who look for curves on it.

Glossary
--------
domain
    The rectangle ((u0, u1), (v0, v1)) of parameters.
closed
    Whether u (first) or v (second) runs round a closed surface, so that u1 is u0 again.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from fabgeo.arrays import Array


@runtime_checkable
class Parametrised(Protocol):
    """A surface that also answers by parameters: a formula, one B-spline face, a grid mesh."""

    @property
    def domain(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Parameter rectangle ((u0, u1), (v0, v1))."""
        ...

    @property
    def closed(self) -> tuple[bool, bool]:
        """Whether the surface closes in u, in v."""
        ...

    def evaluate(self, u: Array, v: Array) -> Array:
        """Points (k, 3) at parameters (k,) and (k,)."""
        ...
