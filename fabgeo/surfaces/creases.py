"""Creases: how sharply faces of a design surface meet along the edges they share.

A strip model is smooth along its strips, so no strip can follow a surface across a crease.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, IntArray, cross, dot
from fabgeo.surfaces.base import DesignSurface
from fabgeo.surfaces.parametric import ParametricSurface

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
    rows = np.flatnonzero(border.partner >= 0)
    other = border.partner[rows]
    rows, other = (x[border.face[rows] != border.face[other]] for x in (rows, other))
    if not len(rows):
        return None
    middle = (border.uv[rows] + border.uv_end[rows]) / 2.0
    point, mine = _at(surface, rows, middle)
    # The place on the other face's segment that is nearest to that point.
    way = border.end[other] - border.point[other]
    share = dot(point - border.point[other], way) / np.maximum(dot(way, way), 1e-300)
    share = np.clip(share, 0.0, 1.0)[:, None]
    foot = border.uv[other] + share * (border.uv_end[other] - border.uv[other])
    _, theirs = _at(surface, other, foot)
    sine = np.linalg.norm(cross(mine, theirs), axis=-1)
    angle = np.degrees(np.arctan2(sine, dot(mine, theirs)))
    worst = int(np.argmax(angle))
    if not angle[worst] > SHARP:
        return None
    x, y, z = (float(c) for c in point[worst])
    faces = (int(border.face[rows[worst]]), int(border.face[other[worst]]))
    return Crease(float(angle[worst]), faces, (x, y, z))


def _at(surface: ParametricSurface, rows: IntArray, uv: Array) -> tuple[Array, Array]:
    """Points and normals at parameters (k, 2) of the faces that segments of the border are of."""
    point, normal = np.zeros((len(rows), 3)), np.zeros((len(rows), 3))
    for face in np.unique(surface.border.face[rows]):
        own = surface.border.face[rows] == face
        found = surface.evaluate(*uv[own].T, face=int(face))
        point[own], normal[own] = found.point, found.normal
    return point, normal
