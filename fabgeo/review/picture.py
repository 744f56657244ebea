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


def faces_of(rails: Array) -> list[Array]:
    """Contours (p, m, 3) of the ruled faces and end caps of parts with rails (p, N, k, 3).

    A surface (N = 2) has one face.
    """
    count = rails.shape[1]
    if count == 2:
        return [np.concatenate([rails[:, 0], rails[:, 1, ::-1]], axis=1)]
    after = np.roll(np.arange(count), -1).tolist()
    sides = [np.concatenate([rails[:, j], rails[:, after[j], ::-1]], axis=1) for j in range(count)]
    return [*sides, rails[:, :, 0], rails[:, :, -1]]


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
    thin: list[Array] = []
    for part in parts:
        keep = np.unique(np.linspace(0, part.rails.shape[1] - 1, steps).round().astype(int))
        thin.append(part.rails[:, keep])
    found: list[tuple[float, int, Polygon]] = []
    for shape in sorted({rails.shape for rails in thin}):
        own = [k for k, rails in enumerate(thin) if rails.shape == shape]
        faces = faces_of(np.stack([thin[k] for k in own]))
        normals = np.stack([_normal(face) for face in faces], axis=1)
        shown = np.ones(normals.shape[:2], dtype=bool)
        if largest_only:
            best = np.abs(normals @ view[2]).argmax(axis=1)
            shown = np.arange(len(faces)) == best[:, None]
        shade = 0.55 + 0.45 * np.abs(unit(normals) @ light)
        for at, face in enumerate(faces):
            flat = face @ view.T
            for row in np.flatnonzero(shown[:, at]).tolist():
                polygon = Polygon(parts[own[row]].mark, flat[row, :, :2], float(shade[row, at]))
                found.append((float(flat[row, :, 2].mean()), own[row], polygon))
    found.sort(key=lambda item: item[:2])
    return [polygon for *_, polygon in found]


def _normal(face: Array) -> Array:
    """Vector areas (p, 3) of closed contours (p, m, 3) (Newell)."""
    return 0.5 * cross(face, np.roll(face, -1, axis=1)).sum(axis=1)
