"""Openings of a solid laid flat with its mid-surface: where the drawing's holes belong."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fabgeo.arrays import Array, IntArray, cross, dot, unit
from fabgeo.review.rings import distances
from fabgeo.review.solid_plate import SolidPlate, between_samples


def laid(plate: SolidPlate, flat: tuple[Array, Array], points: Array) -> Array:
    """Where points (k, 3) of the mid-surface come to lie in the plane, (k, 2).

    Every point lies on a ruling: between the two sampled ones on whose different sides it is, at
    a fraction of its length that the development keeps.

    Parameters
    ----------
    plate : SolidPlate
        Four-sided.
    flat : two (n, 2) arrays
        Its rails in the plane, as `fabgeo.review.solid_plate.developed` samples them.
    """
    a, b = (between_samples(rail) for rail in plate.four_sided)
    ruling = b - a
    normal = cross(np.gradient(a + b, axis=0), ruling)
    side = unit(cross(ruling, normal))
    # Signed distances (k, n) from all rulings: positive up to the last one before a point.
    away = points @ side.T - dot(a, side)
    before: IntArray = np.clip((away > 0.0).sum(axis=1) - 1, 0, len(a) - 2)
    rows = np.arange(len(points))
    d0, d1 = away[rows, before], away[rows, before + 1]
    t = (d0 / np.where(d0 == d1, 1.0, d0 - d1))[:, None]
    start, along = _between(a, before, t), _between(ruling, before, t)
    v = (dot(points - start, along) / dot(along, along))[:, None]
    return (1.0 - v) * _between(flat[0], before, t) + v * _between(flat[1], before, t)


def openings_off(
    plate: SolidPlate, flat: tuple[Array, Array], rims: Sequence[Array]
) -> list[tuple[float, Array]]:
    """How far every opening's rim, laid flat, is off the nearest of the drawn ones, and where."""
    if not plate.openings:
        return []
    middles = np.array([0.5 * (rim.min(axis=0) + rim.max(axis=0)) for rim in rims])
    ends = np.cumsum([len(opening) for opening in plate.openings])
    out = []
    for rim in np.split(laid(plate, flat, np.concatenate(plate.openings)), ends[:-1]):
        middle = 0.5 * (rim.min(axis=0) + rim.max(axis=0))
        nearest = int(np.linalg.norm(middles - middle, axis=1).argmin())
        out.append((float(distances(rim, rims[nearest]).max()), middle))
    return out


def _between(values: Array, place: IntArray, t: Array) -> Array:
    return values[place] + t * (values[place + 1] - values[place])
