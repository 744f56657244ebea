"""Conical models: the edge tangent makes equal angles with both rulings."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array
from fabgeo.fitting.objectives.base import Gradients, Objective, State
from fabgeo.fitting.samples import normed, through_unit


class Conical(Objective):
    """t . (e+ - e-) at every inner edge; e+ and e- point away from it."""

    name = "conical"
    constraint = True
    width = 3

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Differences of cosines and their gradients."""
        before, here, after = state.around(self.sites, 3)
        derivative = state.around(self.sites, 3, 1)[1]
        t, speed = normed(derivative)
        (e, long), (f, short) = normed(after - here), normed(before - here)
        values = np.einsum("...k,...k->...", t, e - f)[..., None]
        if not slopes:
            return values, {}
        by_after, by_before = through_unit(e, long, t), -through_unit(f, short, t)
        by_tangent = through_unit(t, speed, e - f)
        points = np.stack([by_before, -by_after - by_before, by_after], axis=-2)
        nothing = np.zeros_like(by_tangent)
        first = np.stack([nothing, by_tangent, nothing], axis=-2)
        return values, {0: points[..., None, :, :], 1: first[..., None, :, :]}
