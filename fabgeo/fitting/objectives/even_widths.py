"""Even strip widths: ruling lengths against the mean of their neighbours, or a target."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array
from fabgeo.fitting.objectives.base import Gradients, Objective, State
from fabgeo.fitting.samples import normed


class EvenWidths(Objective):
    """(L_{i+1} - L_i) / 2 at every inner edge: zero where neighbouring rulings are equally long.

    The sum of its squares is least, between given outer edges, where all widths are equal.
    """

    name = "even widths"
    width = 3

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Half differences and their gradients."""
        before, here, after = state.around(self.sites, 3)
        (e, long), (f, short) = normed(after - here), normed(here - before)
        values = (long - short) / 2.0
        if not slopes:
            return values, {}
        return values, {0: np.stack([f, -e - f, e], axis=-2)[..., None, :, :] / 2.0}


class TargetWidths(Objective):
    """L_i - target: ruling lengths against one given width (in the fit's unit)."""

    name = "target widths"
    width = 2
    target = 1.0

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Differences and their gradients."""
        a, b = state.around(self.sites, 2)
        e, length = normed(b - a)
        if not slopes:
            return length - self.target, {}
        return length - self.target, {0: np.stack([-e, e], axis=-2)[..., None, :, :]}
