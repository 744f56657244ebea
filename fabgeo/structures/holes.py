"""Holes of plates: their frames, that they lie apart, and what they take off a plate.

That is the height between its two skins, integrated over their section.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import KDTree

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.errors import PartError
from fabgeo.strips.pierce import pierce
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Hole, Prism

_NODES, _WEIGHTS = (np.asarray(x, dtype=np.float64) for x in np.polynomial.legendre.leggauss(4))
_S, _DS = (_NODES + 1.0) / 2.0, _WEIGHTS / 2.0
_ROUND = 12
"""Directions around a round end: a trapezoid rule, exact for the waves of the skins' bending."""


def hole_frames(holes: Sequence[Hole]) -> Array:
    """Frames (n, 3, 3) of holes, rows x, y, z: z the axis, x the slot's direction square to it."""
    z = unit(np.array([hole.axis for hole in holes]))
    along = np.array([hole.direction for hole in holes])
    along = along - dot(along, z)[:, None] * z
    none = np.linalg.norm(along, axis=1) < 1e-6
    other = np.eye(3)[np.argmin(np.abs(z), axis=1)]
    along = np.where(none[:, None], other - dot(other, z)[:, None] * z, along)
    x = unit(along)
    return np.stack([x, cross(z, x), z], axis=1)


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
    sections = {(hole.diameter, hole.slot): section_sites(hole) for hole in holes}
    own = [sections[hole.diameter, hole.slot] for hole in holes]
    count = [len(weight) for _, weight in own]
    weight = np.concatenate([each for _, each in own])
    sites = np.concatenate([each for each, _ in own])
    frames = np.repeat(hole_frames(holes), count, axis=0)
    centres = np.array([hole.centre for hole in holes])
    points = np.repeat(centres, count, axis=0) + np.einsum("ki,kid->kd", sites, frames[:, :2])
    low, high = (RuledPatch(prism.knots, prism.poles[[j, j + 1]]) for j in (0, 2))
    guess = np.repeat(_nearest(low, centres), count)
    u, _, lower = pierce(low, points, frames[:, 2], guess)
    _, _, upper = pierce(high, points, frames[:, 2], u)
    return float(np.abs(upper - lower) @ weight)


def _nearest(skin: RuledPatch, points: Array) -> Array:
    """Parameters u of the rulings whose middles lie nearest to points."""
    u = skin.parameters(8)
    middle = skin.edges(u).mean(axis=0)
    return u[np.argmin(np.linalg.norm(points[:, None] - middle, axis=-1), axis=1)]


def check_apart(mark: str, holes: Sequence[Hole]) -> None:
    """Refuse holes that touch each other (slots by their enclosing circle's two centres).

    Raises
    ------
    PartError
    """
    if len(holes) < 2:
        return
    reach = max(hole.diameter + hole.slot for hole in holes)
    for i, j in sorted(KDTree([hole.centre for hole in holes]).query_pairs(reach + 1e-3)):
        first, second = holes[i], holes[j]
        gap = _distance(first, second) - (first.diameter + second.diameter) / 2.0
        if gap < 1e-3:
            raise PartError(
                mark,
                f"holes at {_spot(first)} and {_spot(second)} touch",
                "move them apart",
            )


def _distance(first: Hole, second: Hole) -> float:
    """Least distance of the centre lines of two holes, sampled for slots."""
    spread = np.linspace(-0.5, 0.5, 9)[:, None]
    a = first.centre + first.slot * spread * unit(first.direction)
    b = second.centre + second.slot * spread * unit(second.direction)
    return float(np.linalg.norm(a[:, None] - b[None], axis=-1).min())


def _spot(hole: Hole) -> str:
    x, y, z = hole.centre
    return f"({x:.1f}, {y:.1f}, {z:.1f}) mm"
