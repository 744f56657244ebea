"""What the solver is given: residuals with exact local Jacobians, and nothing about strips.

Glossary
--------
node
    A small group of unknowns that always act together: `dim` coordinates of one control point.
element
    One small dense part of the Jacobian: a few residuals that depend on a few nodes.
block
    All elements of one shape, batched.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from fabgeo.arrays import Array, IntArray


@dataclass(frozen=True)
class Block:
    """Residuals and Jacobian of `k` elements, each with `r` residuals on `w` nodes.

    Attributes
    ----------
    nodes : (k, w) int array
        The nodes that each element depends on; the same array object in every evaluation.
    residual : (k, r) array
    jacobian : (dim, k, r, w) array
        Derivatives by each coordinate of the nodes, coordinate by coordinate.
    """

    nodes: IntArray
    residual: Array
    jacobian: Array


class Problem(Protocol):
    """A sum of squares to be made small: what Levenberg-Marquardt asks of a problem."""

    @property
    def node_count(self) -> int:
        """Number of nodes; unknowns are (node_count, dim) arrays."""
        ...

    @property
    def dim(self) -> int:
        """Coordinates of a node."""
        ...

    @property
    def stencils(self) -> Sequence[IntArray]:
        """The `nodes` arrays of all blocks, which fix the pattern of the normal equations."""
        ...

    def costs(self, x: Array) -> Array:
        """Half the sums of squared residuals at `x` (node_count, dim), by groups of residuals.

        Their sum is made small; each group has to settle before a minimisation has converged.
        """
        ...

    def blocks(self, x: Array) -> Sequence[Block]:
        """Residuals and Jacobians at `x`."""
        ...

    def admissible(self, x: Array) -> bool:
        """Whether `x` may be accepted at all, whatever its cost."""
        ...
