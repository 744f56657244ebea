"""What holes take off a plate: the height between its two skins, integrated over their section."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fabgeo.arrays import Array, cross, unit
from fabgeo.strips.pierce import pierce
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Hole, Prism

_NODES, _WEIGHTS = (np.asarray(x, dtype=np.float64) for x in np.polynomial.legendre.leggauss(4))
_S, _DS = (_NODES + 1.0) / 2.0, _WEIGHTS / 2.0
_ROUND = 12
"""Directions around a round end: a trapezoid rule, exact for the waves of the skins' bending."""


def hole_frame(hole: Hole) -> Array:
    """Rows x, y, z of a hole: z its axis, x the slot's direction made square to it."""
    z = unit(hole.axis)
    along = hole.direction - (hole.direction @ z) * z
    if np.linalg.norm(along) < 1e-6:
        along = np.eye(3)[np.argmin(np.abs(z))]
        along = along - (along @ z) * z
    x = unit(along)
    return np.stack([x, cross(z, x), z])


def section_sites(hole: Hole) -> tuple[Array, Array]:
    """Points (k, 2) in a hole's section, in its frame, and their weights (k,) in mm2."""
    radius, half = hole.diameter / 2.0, hole.slot / 2.0
    angle = 2.0 * np.pi * (np.arange(_ROUND) + 0.5) / _ROUND
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = (radius * _S[:, None, None] * ring).reshape(-1, 2)
    weights = np.repeat(radius**2 * _S * _DS * 2.0 * np.pi / _ROUND, _ROUND)
    if half == 0.0:
        return points, weights
    points[:, 0] += np.where(points[:, 0] > 0.0, half, -half)
    flat = np.stack(np.meshgrid(_NODES * half, _NODES * radius, indexing="ij"), -1).reshape(-1, 2)
    area = (half * radius * np.outer(_WEIGHTS, _WEIGHTS)).ravel()
    return np.concatenate([points, flat]), np.concatenate([weights, area])


def bored_volume(prism: Prism, holes: Sequence[Hole]) -> float:
    """Volume (mm3) of holes through the skins 0 and 2 of a plate's prism.

    The height between the skins along the hole's axis, by Newton's method, at quadrature sites
    over the hole's section: a second route beside the solid's own faces.
    """
    if not holes:
        return 0.0
    start, axes, weights = [], [], []
    for hole in holes:
        frame = hole_frame(hole)
        sites, weight = section_sites(hole)
        start.append(hole.centre + sites @ frame[:2])
        axes.append(np.tile(frame[2], (len(sites), 1)))
        weights.append(weight)
    points, directions, weight = (
        np.concatenate(start),
        np.concatenate(axes),
        np.concatenate(weights),
    )
    low, high = (RuledPatch(prism.knots, prism.poles[[j, j + 1]]) for j in (0, 2))
    guess = np.repeat(_nearest(low, np.stack([h.centre for h in holes])), [len(w) for w in weights])
    heights = [pierce(skin, points, directions, guess)[2] for skin in (low, high)]
    return float(np.abs(heights[1] - heights[0]) @ weight)


def _nearest(skin: RuledPatch, points: Array) -> Array:
    """Parameters u of the rulings whose middles lie nearest to points."""
    u = skin.parameters(8)
    middle = skin.edges(u).mean(axis=0)
    return u[np.argmin(np.linalg.norm(points[:, None] - middle, axis=-1), axis=1)]
