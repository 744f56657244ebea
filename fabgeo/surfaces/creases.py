"""Creases: how sharply faces of a design surface meet along the edges they share.

A strip model is smooth along its strips, so no strip can follow a surface across a crease.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from fabgeo.arrays import Array, IntArray, cross, dot
from fabgeo.surfaces.base import DesignSurface
from fabgeo.surfaces.parametric import ParametricSurface

NEIGHBOURS = 8  # nearest segments of the border among which the other face's is looked for
SHARP = 5.0  # degrees: what people should know of


@dataclass(frozen=True)
class Crease:
    """The sharpest place between two faces: degrees, faces by index, point in space."""

    degrees: float
    faces: tuple[int, int]
    point: tuple[float, float, float]

    def __str__(self) -> str:
        at = ", ".join(f"{x:.0f}" for x in self.point)
        first, second = self.faces
        return f"faces {first} and {second} meet at {self.degrees:.0f} degrees at ({at})"


def sharpest(surface: DesignSurface) -> Crease | None:
    """The sharpest crease of a surface of several faces, if it is sharper than `SHARP`."""
    if not isinstance(surface, ParametricSurface) or len(surface.charts) < 2:
        return None
    border = surface.border
    middle = (border.point + border.end) / 2.0
    rows = np.flatnonzero(~border.free)
    if not len(rows):
        return None
    count = min(NEIGHBOURS, len(middle))
    near = KDTree(middle).query(middle[rows], k=count)[1].reshape(len(rows), count)
    foreign = border.face[near] != border.face[rows][:, None]
    rows, near, foreign = (a[foreign.any(axis=1)] for a in (rows, near, foreign))
    if not len(rows):
        return None
    other = near[np.arange(len(near)), np.argmax(foreign, axis=1)]
    mine, theirs = _normals(surface, rows), _normals(surface, other)
    sine = np.linalg.norm(cross(mine, theirs), axis=-1)
    angle = np.degrees(np.arctan2(sine, dot(mine, theirs)))
    worst = int(np.argmax(angle))
    if not angle[worst] > SHARP:
        return None
    x, y, z = (float(c) for c in middle[rows[worst]])
    faces = (int(border.face[rows[worst]]), int(border.face[other[worst]]))
    return Crease(float(angle[worst]), faces, (x, y, z))


def _normals(surface: ParametricSurface, rows: IntArray) -> Array:
    """Normals at the middles of segments of the border, on the face each belongs to."""
    uv = (surface.border.uv[rows] + surface.border.uv_end[rows]) / 2.0
    normal = np.zeros((len(rows), 3))
    for face in np.unique(surface.border.face[rows]):
        own = surface.border.face[rows] == face
        normal[own] = surface.evaluate(*uv[own].T, face=int(face)).normal
    return normal
