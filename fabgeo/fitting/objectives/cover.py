"""Ends that overhang the boundary stay beyond it, so that the model covers its surface."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.fitting.objectives.base import Gradients, Objective, State
from fabgeo.fitting.reference import Side
from fabgeo.fitting.samples import Sites


class Cover(Objective):
    """How far an end lies short of the boundary and a margin; nothing where it lies beyond.

    Narrow strips fit better, so nothing else in the functional keeps a free end from drawing in.

    Parameters
    ----------
    sites : Sites
        One end of the net.
    side : Side
        The smooth piece of the boundary that the end overhangs.
    start, normals : (edges, elements, q, 3) arrays
        Points of the start, which lie beyond, and the surface's normals there.
    margin : float
        In the fit's unit.
    """

    name = "cover"
    width = 1

    def __init__(
        self, sites: Sites, side: Side, start: Array, normals: Array, margin: float
    ) -> None:
        super().__init__(sites)
        self._side, self._normals, self._margin = side, normals, margin
        foot, tangent = side.closest(start)
        self._outwards = np.sign(dot(start - foot, cross(normals, tangent)))[..., None]

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Distances short of the margin (negative) and their gradients."""
        points = state.at(self.sites)
        foot, tangent = self._side.closest(points)
        out = self._outwards * unit(cross(self._normals, tangent))
        short = dot(points - foot, out) - self._margin
        values = np.minimum(short, 0.0)[..., None]
        gradient = np.where(values < 0.0, out, 0.0)
        return values, {0: gradient[..., None, None, :]} if slopes else {}
