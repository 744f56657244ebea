"""Plane, right circular cylinder and right circular cone as value objects.

Glossary
--------
signed distance
    Positive on the side of the carrier's normal at its origin: the panel's outer side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, set_frozen
from fabgeo.panels.carrier import Carriers


@dataclass(frozen=True)
class Carrier:
    """One carrier: see `fabgeo.panels.carrier` for what k, g and the frame mean.

    Attributes
    ----------
    origin : (3,) array
        A point on the shape, in the middle of the panel.
    frame : (3, 3) array
        Rows a (ruling), m, n (outer normal).
    k, g : float
        Curvature across the ruling and turning rate of the rulings, 1/mm.
    """

    origin: Array
    frame: Array
    k: float
    g: float

    def __post_init__(self) -> None:
        set_frozen(self, "origin", (3,))
        set_frozen(self, "frame", (3, 3))

    @property
    def batch(self) -> Carriers:
        """The same as a batch of one."""
        return Carriers(self.origin[None], self.frame[None], np.array([self.k]), np.array([self.g]))

    def distance(self, points: Array) -> Array:
        """Signed distance (s,) of points (s, 3)."""
        return self.batch.distance(np.asarray(points)[None])[0]

    def normal(self, points: Array) -> Array:
        """Unit normals (s, 3) at the feet of points (s, 3): the distance's gradient."""
        return self.batch.normal(np.asarray(points)[None])[0]

    def project(self, points: Array) -> Array:
        """Feet (s, 3) of points (s, 3)."""
        return self.batch.project(np.asarray(points)[None])[0]

    def ruling(self, points: Array) -> Array:
        """Unit rulings (s, 3) of the shape at the feet of points."""
        return self.batch.ruling(np.asarray(points)[None])[0]

    def derivatives(self, points: Array) -> tuple[Array, Array]:
        """Signed distance (s,) and its derivatives (s, 6).

        By a shift along n, rotations about a, m, n, by k and by g.
        """
        d, jac = self.batch.derivatives(np.asarray(points)[None])
        return d[0], jac[0]


@dataclass(frozen=True)
class Plane(Carrier):
    """A plane through `origin` with the normal `frame[2]`."""

    @property
    def direction(self) -> Array:
        """Unit normal."""
        return self.frame[2]


@dataclass(frozen=True)
class Cylinder(Carrier):
    """A right circular cylinder."""

    @property
    def radius(self) -> float:
        """Radius, positive, mm."""
        return 1.0 / abs(self.k)

    @property
    def axis(self) -> tuple[Array, Array]:
        """Point of the axis closest to the panel's middle, and the axis' unit direction."""
        return self.origin - self.frame[2] / self.k, self.frame[0]


@dataclass(frozen=True)
class Cone(Carrier):
    """A right circular cone."""

    @property
    def apex(self) -> Array:
        """Apex, mm."""
        return self.origin - self.frame[0] / self.g

    @property
    def half_angle(self) -> float:
        """Angle between axis and rulings in radians, between 0 and pi/2."""
        return float(np.arctan2(abs(self.g), abs(self.k)))

    @property
    def axis(self) -> tuple[Array, Array]:
        """Apex, and the axis' unit direction from it into the panel's nappe."""
        n = np.hypot(self.k, self.g)
        direction = (self.k * self.frame[0] - self.g * self.frame[2]) / n
        return self.apex, direction * np.sign(self.k * self.g)


type Shape = Plane | Cylinder | Cone
_KINDS: dict[str, type[Plane] | type[Cylinder] | type[Cone]] = {
    "flat": Plane,
    "cylinder": Cylinder,
    "cone": Cone,
}


def shape_of(carriers: Carriers, index: int, kind: str) -> Shape:
    """The value object of one carrier of a batch."""
    return _KINDS[kind](
        carriers.origin[index],
        carriers.frame[index],
        float(carriers.k[index]),
        float(carriers.g[index]),
    )
