"""Fair ruling polygons: f_fair/ruling of paper eq. (2)."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array
from fabgeo.fitting.objectives.base import Gradients, Objective, State
from fabgeo.fitting.objectives.fair_edges import mostly_tangential
from fabgeo.fitting.samples import Sites


class FairRulings(Objective):
    """p_{i+1} - 2 p_i + p_{i-1} with its normal part hardly counted.

    Parameters
    ----------
    normals : (edges, elements, q, 3) array
        The design surface's at the edges, taken at the beginning of a stage and kept.
    """

    name = "fair rulings"
    width = 3

    def __init__(self, sites: Sites, normals: Array, share: float) -> None:
        super().__init__(sites)
        self._map = mostly_tangential(normals[sites.net.windows(3)[:, 1]], share)

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Weighted second differences and their gradients."""
        before, here, after = state.around(self.sites, 3)
        values = (self._map @ (after - 2.0 * here + before)[..., None])[..., 0]
        if not slopes:
            return values, {}
        return values, {0: np.stack([self._map, -2.0 * self._map, self._map], axis=-2)}
