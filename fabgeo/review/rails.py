"""Normals and bending radii of a strip between two rails, sampled alike: see `solid_plate`."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array, cross, unit


def rail_normals(a: Array, b: Array) -> tuple[Array, Array]:
    """Unit normals (n, 3) of the strip between the rails, at both ends of every ruling."""
    from scipy.interpolate import CubicSpline

    sites = np.arange(len(a), dtype=float)
    speeds = CubicSpline(sites, np.stack([a, b], axis=1))(sites, 1)
    first, second = (unit(cross(speeds[:, k], b - a)) for k in (0, 1))
    return first, second


def diagonals_apart(a: Array, b: Array) -> Array:
    """Distance (n,) in mm of the diagonals of the quads at the rulings of two rails (n, 3).

    A quad has two corners on a ruling's ends and two more where the edges lead from there, as far
    along them as the ruling is long: 0 on developables (paper, eq. 2).
    """
    from scipy.interpolate import CubicSpline

    sites = np.arange(len(a), dtype=float)
    speeds = unit(CubicSpline(sites, np.stack([a, b], axis=1))(sites, 1))
    along, beside, ruling = speeds[:, 0], speeds[:, 1], unit(b - a)
    volume = np.abs(np.sum(cross(along, beside) * ruling, axis=1))
    base = np.linalg.norm(cross(ruling + beside, ruling - along), axis=1)
    return np.linalg.norm(b - a, axis=1) * volume / np.maximum(base, 1e-300)


def bending_sides(a: Array, b: Array) -> Array:
    """For every ruling (n,) +1 where the strip bends towards the side of its `rail_normals`."""
    from scipy.interpolate import CubicSpline

    sites = np.arange(len(a), dtype=float)
    second = CubicSpline(sites, a + b)(sites, 2)
    return np.sign(np.sum(second * np.add(*rail_normals(a, b)), axis=1))


def ruling_radii(rails: tuple[Array, Array]) -> Array:
    """Bending radii (2, n) at both ends of every ruling: turn of the normal over the width.

    The normal is that between the normals at a ruling's ends: across the chord and the mean of
    the rails' directions. The derivatives are those of cubic splines through the rails' samples,
    so that the first and the last ruling, where a radius is often least, are measured as well.
    """
    from scipy.interpolate import CubicSpline

    sites = np.arange(len(rails[0]), dtype=float)
    spline = CubicSpline(sites, np.stack(rails, axis=1))
    (a, b), speeds, seconds = (np.moveaxis(spline(sites, d), 1, 0) for d in (0, 1, 2))
    (da, db), (along, turning) = speeds, _directions(speeds, seconds)
    chord, change = b - a, db - da
    across = cross(along, chord)
    size = np.linalg.norm(across, axis=1, keepdims=True)
    m = across / size
    rate = cross(turning, chord) + cross(along, change)
    turn = np.linalg.norm(rate - np.sum(rate * m, axis=1, keepdims=True) * m, axis=1) / size[:, 0]
    side = unit(cross(chord, m))
    widths = [np.abs(np.sum(speed * side, axis=1)) for speed in (da, db)]
    return np.array(widths) / np.maximum(turn, 1e-15)


def _directions(speed: Array, second: Array) -> tuple[Array, Array]:
    """Mean (n, 3) of both rails' unit tangents, and its derivative."""
    size = np.linalg.norm(speed, axis=-1, keepdims=True)
    tangent = speed / size
    bent = second - np.sum(second * tangent, axis=-1, keepdims=True) * tangent
    return 0.5 * tangent.sum(axis=0), 0.5 * (bent / size).sum(axis=0)
