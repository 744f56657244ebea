"""Triangles of skins with holes and of the holes' walls, for viewing; without the kernel.

Glossary
--------
ring
    The corners of a hole on one skin, counter-clockwise about the hole's axis. Its inside is
    convex: a Delaunay triangle whose three corners belong to one ring lies in the hole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import Delaunay

from fabgeo.arrays import Array, IntArray
from fabgeo.cad.rims import Piece, Skin

type Mesh = tuple[Array, IntArray]
"""Vertices (n, 3) in mm and triangles (m, 3), counter-clockwise seen from outside."""

_STEPS = 6
"""Corners to a half circle, and to a slot's flank."""


@dataclass(frozen=True)
class Ring:
    """One hole on one skin: points (k, 3), parameters (k, 2), mean height along the axis."""

    points: Array
    uv: Array
    height: float


def rings_of(skin: Skin, walls: Sequence[Sequence[Piece]]) -> list[Ring]:
    """The rings of holes' walls on a skin; raises a PartError as `Skin.rims` does."""
    t = np.arange(_STEPS) / _STEPS
    foot, axis, uv, height = skin.meet([piece for wall in walls for piece in wall], t)
    points = foot + height[:, None] * axis
    ends = np.cumsum([_STEPS * len(wall) for wall in walls])
    return [
        Ring(
            points[b - _STEPS * len(wall) : b], uv[b - _STEPS * len(wall) : b], float(height[b - 1])
        )
        for wall, b in zip(walls, ends.tolist(), strict=True)
    ]


def bored_skin(u: Array, curves: Array, rings: Sequence[Ring]) -> Mesh:
    """A ruled face between two curves (2, k, 3) at u (k,), less its rings.

    Between rulings where no ring lies the face is two triangles; blocks with rings are Delaunay
    triangulations in the developed plane, so no triangle spans more of the bend than a block.
    """
    count = len(u)
    middle = curves.mean(axis=0)
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(middle, axis=0), axis=1)))
    width = float(np.linalg.norm(curves[1] - curves[0], axis=1).mean())
    inner = np.concatenate([ring.uv for ring in rings])
    flat = np.stack([np.interp(inner[:, 0], u, arc), width * inner[:, 1]], axis=1)
    edges = [np.stack([arc, np.full(count, y)], axis=1) for y in (0.0, width)]
    points = np.concatenate([*edges, flat])
    owner = np.repeat(np.arange(-1, len(rings)), [2 * count, *(len(r.uv) for r in rings)])
    column = np.searchsorted(u, inner[:, 0], side="right") - 1
    touched = np.zeros(count - 1, dtype=bool)
    bounds = np.cumsum([0, *(len(ring.uv) for ring in rings)])
    for a, b in pairwise(bounds.tolist()):
        touched[column[a:b].min() : column[a:b].max() + 1] = True
    plain = np.flatnonzero(~touched)
    triangles = [
        np.stack([plain, plain + 1, plain + count], 1),
        np.stack([plain + 1, plain + count + 1, plain + count], 1),
    ]
    changes = np.flatnonzero(np.diff(np.concatenate([[0], touched.astype(int), [0]])))
    for first, last in changes.reshape(-1, 2).tolist():
        side = np.arange(first, last + 1)
        within = 2 * count + np.flatnonzero((column >= first) & (column < last))
        chosen = np.concatenate([side, side + count, within])
        triangles.append(chosen[_outside(points[chosen], owner[chosen], 1e-9 * width**2)])
    made = np.concatenate([*curves, *(ring.points for ring in rings)])
    return made, np.concatenate(triangles)


def _outside(points: Array, owner: IntArray, least: float) -> IntArray:
    """Counter-clockwise Delaunay triangles (m, 3) of the plane that lie in no ring."""
    triangles = Delaunay(points).simplices.astype(np.int64)
    of = owner[triangles]
    triangles = triangles[(of[:, 0] < 0) | (of[:, 0] != of[:, 1]) | (of[:, 0] != of[:, 2])]
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles = np.where((area < 0.0)[:, None], triangles[:, ::-1], triangles)
    return triangles[np.abs(area) > least]  # three points of one side make none


def bores(first: Sequence[Ring], second: Sequence[Ring]) -> list[Mesh]:
    """The walls between the rings of both skins, seen from within the holes."""
    out: list[Mesh] = []
    for a, b in zip(first, second, strict=True):
        low, high = (a, b) if a.height < b.height else (b, a)
        count = len(low.points)
        k = np.arange(count)
        n = (k + 1) % count
        quads = [np.stack([k, k + count, n], 1), np.stack([n, k + count, n + count], 1)]
        out.append((np.concatenate([low.points, high.points]), np.concatenate(quads)))
    return out


def joined(meshes: Sequence[Mesh]) -> Mesh:
    """Several meshes as one."""
    if not meshes:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    starts = np.cumsum([0, *(len(points) for points, _ in meshes[:-1])])
    triangles = [index + start for (_, index), start in zip(meshes, starts, strict=True)]
    return np.concatenate([p for p, _ in meshes]), np.concatenate(triangles).astype(np.int64)
