"""Circular models: one circle touches both edges at the ends of a ruling."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array
from fabgeo.fitting.objectives.base import Gradients, Objective, State
from fabgeo.fitting.samples import normed, through_unit


class Circular(Objective):
    """(t_i + t_{i+1}) . e_i on every strip."""

    name = "circular"
    constraint = True
    width = 2

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Sums of cosines and their gradients."""
        p0, p1 = state.around(self.sites, 2)
        d0, d1 = state.around(self.sites, 2, 1)
        (t, speed_t), (s, speed_s), (e, ruling) = normed(d0), normed(d1), normed(p1 - p0)
        values = np.einsum("...k,...k->...", t + s, e)[..., None]
        if not slopes:
            return values, {}
        by_p = through_unit(e, ruling, t + s)
        first = [through_unit(t, speed_t, e), through_unit(s, speed_s, e)]
        return values, {
            0: np.stack([-by_p, by_p], axis=-2)[..., None, :, :],
            1: np.stack(first, axis=-2)[..., None, :, :],
        }
