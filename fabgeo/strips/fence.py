"""Which points an overhanging strip model keeps: those within the loops that it overhangs."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from fabgeo.arrays import Array, IndexArray, cross, dot, unit
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import DesignSurface

CORNER = np.cos(np.radians(20.0))  # a boundary that turns more between its points has a corner


class Fence:
    """Those boundary loops of a surface that a model overhangs: it is cut along them only.

    A model that is held on a loop crosses it by the sag of its rulings' chords; that is no
    overhang and is not cut. Points are judged by the side of the loop on which they lie, seen
    along the surface's normal: exact to the loop's own points, and quick.

    Parameters
    ----------
    surface : DesignSurface
    model : StripModel
    least : float
        How far beyond a loop a model lies that overhangs it, in mean ruling lengths.

    Attributes
    ----------
    loops : tuple of int
        The overhung loops of the surface.
    corners : (k, 2, 3) array
        Where they turn sharply, and the surface's unit normals there.
    """

    def __init__(self, surface: DesignSurface, model: StripModel, least: float = 0.1) -> None:
        points = model.points(model.parameters(2))
        width = float(np.linalg.norm(np.subtract(*model.pairs(points)), axis=-1).mean())
        points = points.reshape(-1, 3)
        sides = [_Loop(loop, surface) for loop in surface.loops]
        apart = np.array([side.short(points) for side in sides]).reshape(len(sides), len(points))
        nearest = np.argmin(np.abs(apart), axis=0) if sides else np.empty(0)
        beyond = [float(-row[nearest == k].min(initial=0.0)) for k, row in enumerate(apart)]
        self.loops = tuple(k for k, far in enumerate(beyond) if far > least * width)
        self._sides = [sides[k] for k in self.loops]
        self.corners = np.concatenate(
            [np.empty((0, 2, 3)), *(side.corners for side in self._sides)]
        )

    def __call__(self, points: Array) -> Array:
        """How far inside points (k, 3) lie: distances from the loops, negative beyond one."""
        depth = np.full(len(points), np.inf)
        for side in self._sides:
            depth = np.minimum(depth, side.short(points))
        return depth


class _Loop:
    """A closed polyline of boundary points with the surface's tangent planes there."""

    def __init__(self, loop: Array, surface: DesignSurface) -> None:
        points = loop[:-1] if np.allclose(loop[0], loop[-1]) else loop
        after = np.roll(points, -1, axis=0)
        self._start, self._end, self._step = points, after, after - points
        chord = unit(self._step)
        before = np.roll(chord, 1, axis=0)
        sharp = dot(chord, before) <= CORNER
        smooth = ~sharp[:, None]  # at a corner both segments keep theirs
        tangent = unit(chord + before)
        self._leave = np.where(smooth, tangent, chord)
        self._arrive = np.where(np.roll(smooth, -1, axis=0), np.roll(tangent, -1, axis=0), chord)
        normal = surface.closest(points).normal
        self.corners = np.stack([points, normal], axis=1)[sharp]
        inwards = cross(normal, self._leave), cross(np.roll(normal, -1, 0), self._arrive)
        size = float(np.linalg.norm(self._step, axis=1).min())
        probe = (points + after) / 2.0 + 0.01 * size * inwards[0]
        sign = 1.0 if surface.closest(probe).on_boundary.mean() < 0.5 else -1.0
        self._inwards = sign * np.stack(inwards)
        # Beside a corner's point it is the sum of both sides' directions that tells the side.
        self._at_point = self._inwards[0] + np.roll(self._inwards[1], 1, axis=0)
        self._tree = KDTree(points)

    def short(self, points: Array) -> Array:
        """Signed distances (k,) from the loop: positive on the surface's side."""
        near = np.asarray(self._tree.query(points)[1], dtype=np.intp)
        count = len(self._start)
        best, found = np.full(len(points), np.inf), np.zeros(len(points))
        for k in (near, (near - 1) % count):
            v = self._step[k]
            t = np.clip(dot(points - self._start[k], v) / dot(v, v), 0.0, 1.0)[:, None]
            apart = points - self._curve(k, t)
            side = (1.0 - t) * self._inwards[0, k] + t * self._inwards[1, k]
            side = np.where(t == 0.0, self._at_point[k], side)
            side = np.where(t == 1.0, self._at_point[(k + 1) % count], side)
            distance = np.linalg.norm(apart, axis=1)
            closer = distance < best
            found = np.where(closer, dot(apart, unit(side)), found)
            best = np.where(closer, distance, best)
        return found

    def _curve(self, k: IndexArray, t: Array) -> Array:
        """Points of the cubic through both ends of segment k with the loop's tangents."""
        size = np.linalg.norm(self._step[k], axis=1)[:, None]
        return (
            (2.0 * t**3 - 3.0 * t**2 + 1.0) * self._start[k]
            + (t**3 - 2.0 * t**2 + t) * size * self._leave[k]
            + (3.0 * t**2 - 2.0 * t**3) * self._end[k]
            + (t**3 - t**2) * size * self._arrive[k]
        )
