"""A weak pull to the start, along the surface only: keeps a model over its domain."""

from __future__ import annotations

from fabgeo.arrays import Array
from fabgeo.fitting.objectives.base import Gradients, Objective, State
from fabgeo.fitting.objectives.fair_edges import mostly_tangential
from fabgeo.fitting.samples import Sites


class Anchor(Objective):
    """x - x_start without its part along the surface's normal, at points of the edges.

    Parameters
    ----------
    start, normals : (edges, elements, q, 3) arrays
        Points of the start and the surface's normals there.
    """

    name = "anchor"
    width = 1

    def __init__(self, sites: Sites, start: Array, normals: Array) -> None:
        super().__init__(sites)
        self._start, self._map = start, mostly_tangential(normals, 0.0)

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Tangential distances and their gradients."""
        away = state.at(self.sites) - self._start
        values = (self._map @ away[..., None])[..., 0]
        return values, {0: self._map[..., :, None, :]} if slopes else {}
