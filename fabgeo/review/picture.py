"""A still picture of the parts: parallel projection, painter's order, one polygon a part.

Used where no WebGL is (the page's fallback and its print) and in the drawings.

Glossary
--------
view
    Three orthonormal rows: right, up, towards the eye.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, cross, unit
from fabgeo.review.record import Shown

ISOMETRIC = np.array([-0.62, -0.55, 0.56])


@dataclass(frozen=True)
class Polygon:
    """One visible face: its part, its contour in the picture (x right, y up), its brightness."""

    mark: str
    points: Array
    shade: float


def view_of(towards: Array = ISOMETRIC) -> Array:
    """The view (3, 3) whose eye lies in the direction `towards`."""
    eye = unit(np.asarray(towards, dtype=float))
    up = np.array([0.0, 0.0, 1.0]) if abs(eye[2]) < 0.99 else np.array([0.0, 1.0, 0.0])
    right = unit(cross(up, eye))
    return np.stack([right, cross(eye, right), eye])


def faces_of(part: Shown) -> list[Array]:
    """Contours (k, 3) of the ruled faces and end caps of a part; a surface has one face."""
    rails = part.rails
    count = len(rails)
    if count == 2:
        return [np.concatenate([rails[0], rails[1][::-1]])]
    sides = [np.concatenate([rails[j], rails[(j + 1) % count][::-1]]) for j in range(count)]
    return [*sides, rails[:, 0], rails[:, -1]]


def picture_of(
    parts: Sequence[Shown], view: Array, largest_only: bool = True, steps: int = 5
) -> list[Polygon]:
    """Polygons of all parts from far to near.

    Parameters
    ----------
    largest_only : bool
        Draw of every part only the face that shows the largest area (enough for thin panels).
    steps : int
        Points kept of each rail.
    """
    light = unit(np.array([-0.35, -0.5, 0.8]))
    found: list[tuple[float, Polygon]] = []
    for part in parts:
        keep = np.unique(np.linspace(0, part.rails.shape[1] - 1, steps).round().astype(int))
        thin = Shown(part.mark, part.family, part.rails[:, keep], part.normal, part.row)
        faces = [(face, _normal(face)) for face in faces_of(thin)]
        if largest_only:
            faces = [max(faces, key=lambda f: abs(float(f[1] @ view[2])))]
        for face, normal in faces:
            shade = 0.55 + 0.45 * abs(float(unit(normal) @ light))
            flat = face @ view.T
            depth = float(flat[:, 2].mean())
            found.append((depth, Polygon(part.mark, flat[:, :2], shade)))
    found.sort(key=lambda item: item[0])
    return [polygon for _, polygon in found]


def _normal(face: Array) -> Array:
    """Vector area of a closed contour (Newell)."""
    return 0.5 * cross(face, np.roll(face, -1, axis=0)).sum(axis=0)
