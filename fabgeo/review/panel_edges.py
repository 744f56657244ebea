"""Edges of panels as joints see them: points, normals of the panel, and how its rulings fan."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, IntArray, cross, unit
from fabgeo.review.solid_plate import SolidPlate

FINE = 4  # points of an edge to one of its solid's samples


@dataclass(frozen=True)
class PanelEdge:
    """One edge of a panel's mid-surface.

    Attributes
    ----------
    mark, number : str, int
        The panel, and which of its edges.
    rail : bool
        Whether rulings end at it; else it is a ruling itself.
    points, normals : (n, 3) array
        With the panel's unit normals there.
    fan : (n,) array
        How wide half a joint is there, in halves of the joint: 1 along rails. A ruling is moved
        along the strip until its slower end has come half a joint; the other end comes farther.
    curvature : float
        Bending of the panel across the edge, 1/mm: 0 at rails.
    """

    mark: str
    number: int
    rail: bool
    points: Array
    normals: Array
    fan: Array
    curvature: float

    def spaced(self, spacing: float) -> Array:
        """Some of the points, no farther from each other than the spacing."""
        length = float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())
        count = min(int(length / spacing) + 3, len(self.points))
        return self.points[np.linspace(0, len(self.points) - 1, count).round().astype(int)]

    def nearest(self, points: Array) -> tuple[IntArray, Array]:
        """Segment (k,) and fraction (k,) of the edge's points nearest to given ones."""
        # The nearest vertex by one product, then the nearer of the segments on both its sides.
        origin = self.points[0]
        a, b = points - origin, self.points - origin
        vertex = (np.sum(b * b, axis=1) - 2.0 * a @ b.T).argmin(axis=1)
        best = np.full(len(points), np.inf)
        place, fraction = np.zeros(len(points), dtype=np.int64), np.zeros(len(points))
        for k in (np.maximum(vertex - 1, 0), np.minimum(vertex, len(b) - 2)):
            step = b[k + 1] - b[k]
            t = np.sum((a - b[k]) * step, axis=1) / np.sum(step * step, axis=1)
            t = np.clip(t, 0.0, 1.0)
            away = np.linalg.norm(a - b[k] - t[:, None] * step, axis=1)
            closer = away < best
            best = np.where(closer, away, best)
            place, fraction = np.where(closer, k, place), np.where(closer, t, fraction)
        return place, fraction

    def at(self, place: IntArray, t: Array) -> Array:
        """Points (k, 3) in segments at fractions."""
        return _between(self.points, place, t)

    def normal_at(self, place: IntArray, t: Array) -> Array:
        """Normals (k, 3) in segments at fractions."""
        return _between(self.normals, place, t)

    def fan_at(self, place: IntArray, t: Array) -> Array:
        """Fan (k,) in segments at fractions."""
        return _between(self.fan[:, None], place, t)[:, 0]


def panel_edges(plates: Mapping[str, SolidPlate]) -> list[PanelEdge]:
    """Edges of all four-sided panels."""
    out: list[PanelEdge] = []
    for mark, plate in plates.items():
        rails = plate.rails()
        if rails is not None:
            out += _edges(mark, plate, rails)
    return out


def _edges(mark: str, plate: SolidPlate, rails: tuple[Array, Array]) -> list[PanelEdge]:
    """The four edges in the plate's order; its rails are two that face each other."""
    normals = plate.normals
    curvature = 1.0 / plate.radii
    first = next(k for k in (0, 1) if np.array_equal(plate.edges[k], rails[0]))
    found = [
        _rail(mark, first, rails[0], normals[0]),
        _rail(mark, first + 2, rails[1], normals[1]),
    ]
    speeds = _speeds(rails, normals)
    for row, number in ((-1, first + 1), (0, (first + 3) % 4)):
        v = np.linspace(0.0, 1.0, 17)[:, None]
        points = (1.0 - v) * rails[0][row] + v * rails[1][row]
        normal = unit((1.0 - v) * normals[0][row] + v * normals[1][row])
        pace = (1.0 - v[:, 0]) * speeds[0, row] + v[:, 0] * speeds[1, row]
        fan = pace / pace.min()
        bend = float(curvature[:, row].max())
        found.append(PanelEdge(mark, number, False, points, normal, fan, bend))
    return found


def _rail(mark: str, number: int, rail: Array, normals: Array) -> PanelEdge:
    from scipy.interpolate import CubicSpline

    sites = np.arange(len(rail), dtype=float)
    fine = np.linspace(0.0, sites[-1], FINE * (len(rail) - 1) + 1)
    points = np.asarray(CubicSpline(sites, rail)(fine))
    dense = unit(np.stack([np.interp(fine, sites, normals[:, k]) for k in range(3)], axis=-1))
    return PanelEdge(mark, number, True, points, dense, np.ones(len(fine)), 0.0)


def _speeds(rails: tuple[Array, Array], normals: tuple[Array, Array]) -> Array:
    """How fast (2, 2) both ends of the rulings move square to them, at the first and the last."""
    out = np.empty((2, 2))
    for column, (row, step) in enumerate(((0, 1), (-1, -2))):
        ruling = unit(rails[1][row] - rails[0][row])
        side = cross(ruling, unit(normals[0][row] + normals[1][row]))
        for k, rail in enumerate(rails):
            third = rail[step + (1 if step > 0 else -1)]
            way = 2.0 * rail[step] - 1.5 * rail[row] - 0.5 * third
            out[k, column] = abs(float(way @ side))
    return out


def _between(values: Array, place: IntArray, t: Array) -> Array:
    return values[place] + t[:, None] * (values[place + 1] - values[place])
