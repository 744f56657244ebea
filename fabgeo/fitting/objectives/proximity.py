"""Proximity: distances to the tangent planes at the closest points, f_prox of paper eq. (2)."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array
from fabgeo.fitting.objectives.base import Gradients, Objective, State


class EdgeProximity(Objective):
    """(x - y) . n at points of the edge curves; y, n the closest point and its normal.

    As y moves in the tangent plane and n is a unit vector, n is the exact gradient.
    """

    name = "proximity of edges"
    width = 1

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Signed distances and their gradients."""
        foot = state.feet(self.sites)[0]
        values = np.einsum("...k,...k->...", state.at(self.sites) - foot.point, foot.normal)
        return values[..., None], {0: foot.normal[..., None, None, :]} if slopes else {}


class MiddleProximity(Objective):
    """The same at the middles of the rulings, where a chord sags the most."""

    name = "proximity of strips"
    width = 2

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Signed distances and their gradients."""
        foot = state.feet(self.sites)[1]
        a, b = state.around(self.sites, 2)
        values = np.einsum("...k,...k->...", (a + b) / 2.0 - foot.point, foot.normal)
        if not slopes:
            return values[..., None], {}
        half = 0.5 * foot.normal[..., None, :]
        return values[..., None], {0: np.concatenate([half, half], axis=-2)[..., None, :, :]}
