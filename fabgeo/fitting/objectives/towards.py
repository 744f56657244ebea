"""Strips drawn towards given shapes, piece by piece: cylinders or cones that panels can be."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from fabgeo.arrays import Array, IntArray
from fabgeo.fitting.objectives.base import Gradients, Objective, State
from fabgeo.fitting.samples import Sites


class Shapes(Protocol):
    """The shape that each piece of each strip is drawn to."""

    def __call__(self, strip: IntArray, t: Array, points: Array) -> tuple[Array, Array]:
        """Signed distances (k,) and unit normals (k, 3) of points (k, 3) in the surface's unit.

        `strip` (k,) and `t` (k,), from 0 to 1 along it, say whose shape.
        """
        ...


class Towards(Objective):
    """Distances of both edges and of the middles of rulings to the shape of their piece.

    Parameters
    ----------
    shapes : Shapes
    length : float
        The fit's unit.
    """

    name = "towards shapes"
    width = 2

    def __init__(self, sites: Sites, shapes: Shapes, length: float) -> None:
        super().__init__(sites)
        self._shapes, self._length = shapes, length

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Distances at the first edge, the second and between, and their gradients."""
        a, b = state.around(self.sites, 2)
        points = np.stack([a, b, (a + b) / 2.0], axis=-2)  # (n, elements, q, 3, 3)
        strip = np.broadcast_to(self.window[:, 0, None, None, None], points.shape[:-1])
        t = np.broadcast_to(self.sites.u[..., None] / self.sites.net.segments, points.shape[:-1])
        values, normals = self._shapes(
            strip.ravel(), t.ravel(), points.reshape(-1, 3) * self._length
        )
        values = values.reshape(points.shape[:-1]) / self._length
        if not slopes:
            return values, {}
        share = np.array([[1.0, 0.0], [0.0, 1.0], [0.5, 0.5]])  # of each point in both edges
        normals = normals.reshape(points.shape)
        return values, {0: share[:, :, None] * normals[..., None, :]}
