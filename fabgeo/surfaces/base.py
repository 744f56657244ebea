"""What every design surface answers: closest points with normal and curvature, and boundary.

Glossary
--------
shape tensor
    The symmetric 3 x 3 tensor S with S n = 0 whose quadratic form d . S d is the normal curvature
    in the unit tangent direction d, positive where the surface bends towards its normal n.
loop
    One closed boundary curve, as a dense polyline whose last point joins its first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from fabgeo.arrays import FARTHEST, Array, BoolArray, checked, dot, set_frozen
from fabgeo.errors import InputError

MOST_SAMPLES = 10_000_000  # on a surface


@dataclass(frozen=True)
class SurfacePoints:
    """Closest points on a design surface, for many points at once.

    Attributes
    ----------
    point : (k, 3) array
        The closest points y.
    normal : (k, 3) array
        Unit normals there, consistently oriented over the surface.
    shape : (k, 3, 3) array
        Shape tensors, 1 / length.
    on_boundary : (k,) bool array
        Whether the closest point lies on the boundary (the query lies beside the surface).
    """

    point: Array
    normal: Array
    shape: Array
    on_boundary: BoolArray

    def normal_curvature(self, directions: Array) -> Array:
        """Normal curvature (k,) in directions (k, 3), which are projected to tangents first."""
        directions = checked("directions", directions, (len(self.normal), 3), most=FARTHEST)
        d = directions - dot(directions, self.normal)[:, None] * self.normal
        square = np.maximum(dot(d, d), 1e-300)
        return np.einsum("ki,kij,kj->k", d, self.shape, d) / square

    def principal(self) -> tuple[Array, Array]:
        """Principal curvatures (k, 2), the larger by absolute value first, and directions.

        Directions are (k, 2, 3): unit, tangent, orthogonal to each other.
        """
        # Shift the normal's eigenvalue far away, so that the two others are found by size.
        far = 4.0 * np.abs(self.shape).max(axis=(1, 2)) + 1.0
        shifted = self.shape + far[:, None, None] * self.normal[:, :, None] * self.normal[:, None]
        value, vector = np.linalg.eigh(shifted)
        kappa, axes = value[:, :2], np.swapaxes(vector, 1, 2)[:, :2]
        order = np.argsort(-np.abs(kappa), axis=1, kind="stable")
        return (
            np.take_along_axis(kappa, order, 1),
            np.take_along_axis(axes, order[:, :, None], 1),
        )


@runtime_checkable
class DesignSurface(Protocol):
    """A surface that a strip model can be fitted to; lengths in the unit of its owner."""

    @property
    def name(self) -> str:
        """How messages call it: a file name or ``formula``."""
        ...

    @property
    def bounds(self) -> Array:
        """Bounding box, (2, 3): lower and upper corner."""
        ...

    @property
    def loops(self) -> tuple[Array, ...]:
        """Boundary loops, each (k, 3) dense points on the boundary; () for a closed surface."""
        ...

    def closest(self, points: Array) -> SurfacePoints:
        """Closest points of `points` (k, 3)."""
        ...

    def sample(self, count: int) -> SurfacePoints:
        """About `count` points spread evenly over the (trimmed) surface."""
        ...


@dataclass(frozen=True)
class BoundaryPoints:
    """Closest points on the boundary: `point` (k, 3), unit `tangent` (k, 3), `loop` (k,) index."""

    point: Array
    tangent: Array
    loop: Array

    def __post_init__(self) -> None:
        set_frozen(self, "point", ("k", 3))
        set_frozen(self, "tangent", ("k", 3))


def check_surface(name: str, given: Any) -> None:
    """Raise InputError where something else than a design surface is given, such as a path."""
    if isinstance(given, type) or not callable(getattr(given, "closest", None)):
        raise InputError(
            name,
            f"expected a design surface, found a {type(given).__name__}",
            "pass fabgeo.as_surface(...) of it",
        )


def size_of(surface: DesignSurface) -> float:
    """Length of the bounding box's diagonal."""
    low, high = surface.bounds
    return float(np.linalg.norm(high - low))
