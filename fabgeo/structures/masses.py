"""Areas, masses and centres of gravity of plates, by numerical integration."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, cross, dot, set_frozen
from fabgeo.structures.parts import Hole, Plate

DENSITIES = {"steel": 7850e-9, "aluminium": 2700e-9, "glass": 2500e-9}  # kg / mm3

_NODES, _WEIGHTS = (np.asarray(x, dtype=np.float64) for x in np.polynomial.legendre.leggauss(5))


@dataclass(frozen=True)
class Mass:
    """Area of the mid-surface (mm2), volume (mm3), mass (kg) and centre of gravity (3,).

    Holes are taken off. The volume is area times thickness: exact for a developable plate, since
    the first-order terms of both halves cancel and the Gaussian curvature is 0.
    """

    area: float
    volume: float
    mass: float
    centre: Array

    def __post_init__(self) -> None:
        set_frozen(self, "centre", (3,))


def plate_mass(plate: Plate, density: float) -> Mass:
    """Mass of a plate of the given density (kg / mm3)."""
    area, moment = _surface(plate)
    for hole in plate.holes:
        size = hole_area(hole)
        area -= size
        moment = moment - size * hole.centre
    volume = area * plate.thickness
    return Mass(area, volume, volume * density, moment / area)


def hole_area(hole: Hole) -> float:
    """Area of a round hole or a slot, mm2."""
    return float(np.pi / 4.0 * hole.diameter**2 + hole.diameter * hole.slot)


def _surface(plate: Plate) -> tuple[float, Array]:
    mid = plate.mid
    spans = np.unique(mid.knots)
    half = np.diff(spans)[:, None] / 2.0
    u = (spans[:-1, None] + half * (_NODES + 1.0)).ravel()
    weight = (half * _WEIGHTS).ravel()
    a, b = mid.edges(u)
    da, db = mid.edges(u, 1)
    chord: Array = b - a
    area, moment = 0.0, np.zeros(3)
    for v, wv in zip((_NODES + 1.0) / 2.0, _WEIGHTS / 2.0, strict=True):
        across: Array = da + v * (db - da)
        piece = np.linalg.norm(cross(across, chord), axis=-1) * weight * wv
        area += float(piece.sum())
        moment = moment + dot(piece[None], np.moveaxis(a + v * chord, -1, 0))
    return area, moment


def together(masses: Iterable[Mass]) -> Mass:
    """Sum of several masses with their common centre of gravity."""
    found = list(masses)
    total = sum(m.mass for m in found)
    centre = np.sum([m.mass * m.centre for m in found], axis=0) / total
    return Mass(sum(m.area for m in found), sum(m.volume for m in found), total, centre)
