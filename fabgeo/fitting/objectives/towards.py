"""Strips drawn towards given shapes, piece by piece: cylinders or cones that panels can be."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from fabgeo.arrays import Array, IntArray
from fabgeo.fitting.objectives.base import Gradients, Objective, State
from fabgeo.fitting.samples import Sites


class Shapes(Protocol):
    """The shape that each piece of each strip is drawn to; strips may be divided into lanes."""

    @property
    def lanes(self) -> IntArray:
        """How many lanes (strips,) divide every strip along its rulings."""
        ...

    def __call__(
        self, strip: IntArray, lane: IntArray, t: Array, points: Array
    ) -> tuple[Array, Array]:
        """Signed distances (k,) and unit normals (k, 3) of points (k, 3) in the surface's unit.

        `strip` (k,), `lane` (k,) and `t` (k,), from 0 to 1 along the strip, say whose shape.
        """
        ...


class Towards(Objective):
    """Distances of every lane's edges, and of the middles of its rulings, to its pieces' shapes.

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
        # Strips of fewer lanes look at some of them twice, so that all have as many places.
        count = shapes.lanes[self.window[:, 0], None]
        most = int(count.max(initial=1))
        self._lane: IntArray = np.repeat(np.arange(most) * count // most, 3, axis=1)  # (n, places)
        self._share: Array = (self._lane + np.tile([0.0, 0.5, 1.0], most)) / count  # of rulings

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Distances at three places of every lane's ruling, and their gradients."""
        a, b = (end[..., None, :] for end in state.around(self.sites, 2))
        share = self._share[:, None, None, :, None]
        points = (1.0 - share) * a + share * b  # (n, elements, q, places, 3)
        each = points.shape[:-1]
        values, normals = self._shapes(
            np.broadcast_to(self.window[:, 0, None, None, None], each).ravel(),
            np.broadcast_to(self._lane[:, None, None], each).ravel(),
            np.broadcast_to(self.sites.u[..., None] / self.sites.net.segments, each).ravel(),
            points.reshape(-1, 3) * self._length,
        )
        values = values.reshape(points.shape[:-1]) / self._length
        if not slopes:
            return values, {}
        both = np.stack([1.0 - share, share], axis=-2)  # of each point in both edges
        normals = normals.reshape(points.shape)
        return values, {0: both * normals[..., None, :]}
