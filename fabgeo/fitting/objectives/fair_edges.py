"""Fair edge curves: f_fair/edge of paper eq. (2)."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array
from fabgeo.fitting.objectives.base import Gradients, Objective, State
from fabgeo.fitting.samples import Sites


def mostly_tangential(normals: Array, share: float) -> Array:
    """(..., 3, 3): keeps what is orthogonal to the normals and `share` of what is along them.

    The surface dictates the normal part of a bending; only the tangential part is free.
    """
    outer = normals[..., :, None] * normals[..., None, :]
    return np.eye(3) - (1.0 - share) * outer


class FairEdges(Objective):
    """p_i'' with its normal part hardly counted, made a length: times (unit / step)^2.

    Parameters
    ----------
    normals : (edges, elements, q, 3) array
        The design surface's, taken at the beginning of a stage and kept.
    step : float
        Mean length of a knot span in the fit's unit: the residual is then about the bending over
        one ruling length, whatever the number of segments.
    """

    name = "fair edges"
    width = 1

    def __init__(self, sites: Sites, normals: Array, step: float, share: float) -> None:
        super().__init__(sites)
        self._map = mostly_tangential(normals, share) / step**2

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Weighted second derivatives and their gradients."""
        second = state.at(self.sites, 2)
        values = (self._map @ second[..., None])[..., 0]
        return values, {2: self._map[..., :, None, :]} if slopes else {}
