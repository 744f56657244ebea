"""Developability: the distance of the diagonals of the quad of paper section 1, f_dev."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array, cross
from fabgeo.fitting.objectives.base import Gradients, Objective, State
from fabgeo.fitting.samples import normed, through_unit


class Developable(Objective):
    """Distance of the diagonals of (p_i, p_i + l p_i', p_{i+1} + m p_{i+1}', p_{i+1}).

    With l = L / |p_i'| and m = L / |p_{i+1}'| it is
    L det(t_i, t_{i+1}, e) / |(e + t_{i+1}) x (e - t_i)|, about L/2 sin(twist).
    """

    name = "developable"
    constraint = True
    width = 2

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Signed distance and its gradients."""
        p0, p1 = state.around(self.sites, 2)
        d0, d1 = state.around(self.sites, 2, 1)
        (t, speed_t), (s, speed_s), (e, ruling) = normed(d0), normed(d1), normed(p1 - p0)
        sum_, difference = e + s, e - t
        unit_c, length_c = normed(cross(sum_, difference))
        volume = np.einsum("...k,...k->...", cross(t, s), e)[..., None]
        ratio = volume / length_c
        if not slopes:
            return ruling * ratio, {}
        # Of volume / |c| by the three unit vectors, c = (e + s) x (e - t).
        by_t = (cross(s, e) - ratio * cross(sum_, unit_c)) / length_c
        by_s = (cross(e, t) - ratio * cross(difference, unit_c)) / length_c
        both = cross(difference, unit_c) + cross(unit_c, sum_)
        by_e = (cross(t, s) - ratio * both) / length_c
        by_p = e * ratio + ruling * through_unit(e, ruling, by_e)
        first = np.stack(
            [
                ruling * through_unit(t, speed_t, by_t),
                ruling * through_unit(s, speed_s, by_s),
            ],
            axis=-2,
        )
        points = np.stack([-by_p, by_p], axis=-2)
        return ruling * ratio, {0: points[..., None, :, :], 1: first[..., None, :, :]}
