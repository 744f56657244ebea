"""Closed contours of lines and arcs: what is cut, written and checked.

Glossary
--------
bulge
    Tangent of a quarter of the arc's angle from a vertex to the next, positive counter-clockwise,
    0 for a line: DXF's own measure.
sagitta
    Height of an arc over its chord: |bulge| chord / 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, set_frozen
from fabgeo.panels.flat import FlatHole


@dataclass(frozen=True)
class Contour:
    """A contour of lines and arcs.

    Attributes
    ----------
    vertices : (k, 3) array
        x, y and the bulge towards the next vertex; the last leads back to the first.
    """

    vertices: Array

    def __post_init__(self) -> None:
        set_frozen(self, "vertices", ("k", 3))

    @property
    def starts(self) -> Array:
        """Start points (k, 2)."""
        return self.vertices[:, :2]

    @property
    def ends(self) -> Array:
        """End points (k, 2)."""
        return np.roll(self.vertices[:, :2], -1, axis=0)

    @property
    def chords(self) -> Array:
        """Chord lengths (k,)."""
        return np.linalg.norm(self.ends - self.starts, axis=-1)

    @property
    def angles(self) -> Array:
        """Signed arc angles (k,), 0 for lines."""
        return 4.0 * np.arctan(self.vertices[:, 2])

    @property
    def radii(self) -> Array:
        """Arc radii (k,), infinite for lines."""
        b = np.abs(self.vertices[:, 2])
        arc = b > 0.0
        return np.where(arc, self.chords * (1.0 + b**2) / np.where(arc, 4.0 * b, 1.0), np.inf)

    @property
    def length(self) -> float:
        """Length along lines and arcs in mm."""
        angle = np.abs(self.angles)
        arc = angle > 1e-9
        ratio = np.where(arc, angle / 2.0 / np.where(arc, np.sin(angle / 2.0), 1.0), 1.0)
        return float(np.sum(self.chords * ratio))

    @property
    def area(self) -> float:
        """Signed area in mm2, positive counter-clockwise: chords' polygon and circle segments."""
        p, q = self.starts, self.ends
        polygon = np.sum(p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]) / 2.0
        angle, radius = self.angles, self.radii
        arc = np.isfinite(radius)
        r = np.where(arc, radius, 0.0)
        return float(polygon + np.sum(r**2 * (angle - np.sin(angle)) / 2.0))

    def moved(self, x: float, y: float, rotation: float) -> Contour:
        """Rotated about the origin, then moved."""
        c, s = np.cos(rotation), np.sin(rotation)
        points = self.starts @ np.array([[c, s], [-s, c]]) + np.array([x, y])
        return Contour(np.column_stack([points, self.vertices[:, 2]]))

    def points(self, tolerance: float = 0.005, outside: bool = False) -> Array:
        """Polygon (n, 2) within `tolerance`: vertices on the arcs, sagitta at most the tolerance.

        With `outside` every arc's own points move off its chord's side so that the polygon holds
        every arc that bulges outwards (a counter-clockwise contour): sound for area and distance.
        """
        pieces: list[Array] = []
        bulges = self.vertices[:, 2]
        for p, q, bulge, radius in zip(self.starts, self.ends, bulges, self.radii, strict=True):
            if bulge == 0.0:
                pieces.append(p[None])
                continue
            pieces.append(_arc_points(p, q, bulge, radius, tolerance, outside and bulge > 0.0))
        return np.concatenate(pieces)

    def bounds(self) -> tuple[float, float, float, float]:
        """Exact box of lines and arcs: x and y least, x and y greatest."""
        points = np.concatenate([self.starts, *_extremes(self)])
        low, high = points.min(axis=0), points.max(axis=0)
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def centre_of(p: Array, q: Array, bulge: float) -> Array:
    """Centre of the arc from p to q."""
    d = q - p
    left = np.array([-d[1], d[0]])
    return (p + q) / 2.0 + left * (1.0 - bulge**2) / (4.0 * bulge)


def _arc_points(
    p: Array, q: Array, bulge: float, radius: float, tolerance: float, outside: bool
) -> Array:
    angle = 4.0 * np.arctan(bulge)
    share = min(1.0, tolerance / radius)
    step = 2.0 * np.arccos(1.0 - share)
    count = max(1, int(np.ceil(abs(angle) / max(step, 1e-6))))
    t = np.arange(count) / count
    if outside:  # tangent polygon: p, then the corners half-way at r / cos(half step)
        t = np.append(0.0, (np.arange(count) + 0.5) / count)
    # A point at fraction t of the arc, without the centre: stable for flat arcs.
    a, rest = angle * t / 2.0, angle * (1.0 - t) / 2.0
    chord = q - p
    left = np.array([-chord[1], chord[0]])
    sine = np.sin(angle / 2.0)
    if abs(sine) < 1e-12:  # a half turn of a full circle never comes here; a flat arc
        points = p + t[:, None] * chord
    else:
        along = np.sin(a) * np.cos(rest) / sine
        over = -np.sin(a) * np.sin(rest) / sine
        points = p + along[:, None] * chord + over[:, None] * left
    if outside:
        centre = centre_of(p, q, bulge)
        reach = np.append(1.0, np.full(count, 1.0 / np.cos(angle / count / 2.0)))
        points = centre + (points - centre) * reach[:, None]
    return points


def _extremes(contour: Contour) -> list[Array]:
    """Points where arcs have horizontal or vertical tangents."""
    found = []
    for p, q, bulge in zip(contour.starts, contour.ends, contour.vertices[:, 2], strict=True):
        if bulge == 0.0:
            continue
        centre = centre_of(p, q, bulge)
        radius = float(np.linalg.norm(p - centre))
        start = np.arctan2(*(p - centre)[::-1])
        turn = 4.0 * np.arctan(bulge)
        quarter = np.arange(4) * np.pi / 2.0
        way = (quarter - start) % (2 * np.pi) if turn > 0 else (start - quarter) % (2 * np.pi)
        inside = quarter[way < abs(turn)]
        if len(inside):
            found.append(centre + radius * np.column_stack([np.cos(inside), np.sin(inside)]))
    return found


def hole_contour(hole: FlatHole) -> Contour:
    """A round hole as two half circles, a slot as two lines and two half circles."""
    r = hole.diameter / 2.0
    d = np.array([np.cos(hole.angle), np.sin(hole.angle)])
    n = np.array([-d[1], d[0]])
    if hole.slot <= 0.0:
        return Contour(np.array([[*(hole.centre - r * d), 1.0], [*(hole.centre + r * d), 1.0]]))
    near, far = hole.centre - hole.slot / 2.0 * d, hole.centre + hole.slot / 2.0 * d
    return Contour(
        np.array(
            [
                [*(near - r * n), 0.0],
                [*(far - r * n), 1.0],
                [*(far + r * n), 0.0],
                [*(near + r * n), 1.0],
            ]
        )
    )
