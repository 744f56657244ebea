"""A border that overhangs the boundary stays beyond it, so that the model covers its surface."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array, IntArray, dot
from fabgeo.fitting.objectives.base import Gradients, Objective, State
from fabgeo.fitting.samples import Sites


class Cover(Objective):
    """How far the border has drawn in, beyond the room that it has; nothing where it has not.

    Narrow strips fit better, so nothing else in the functional keeps a free border from drawing in.

    Parameters
    ----------
    sites : Sites
        Of an end, or of edges.
    edges : (n,) int array
        Which edge curves are kept beyond at these sites.
    start, outwards : (n, elements, q, 3) arrays
        Points of the start, and unit vectors from the boundary to them; 0 where a point does not
        lie beyond.
    room : (n, elements, q) array
        How far each point may draw in: it keeps a margin to the boundary.
    """

    name = "cover"
    width = 1

    def __init__(
        self, sites: Sites, edges: IntArray, start: Array, outwards: Array, room: Array
    ) -> None:
        super().__init__(sites)
        self.window = edges[:, None]
        self._edges, self._start = edges, start
        self._outwards, self._room = outwards, room

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Distances short of the margin (negative) and their gradients."""
        away = state.at(self.sites)[self._edges] - self._start
        short = dot(away, self._outwards) + self._room
        values = np.minimum(short, 0.0)[..., None]
        gradient = np.where(values < 0.0, self._outwards, 0.0)
        return values, {0: gradient[..., None, None, :]} if slopes else {}
