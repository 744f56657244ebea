"""Geodesic models: osculating planes of edges bisect the adjacent strips."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array, cross, dot
from fabgeo.fitting.objectives.base import Gradients, Objective, State
from fabgeo.fitting.samples import normed, through_unit


class Geodesic(Objective):
    """kappa_g+ + kappa_g- at every inner edge: det(p', p'', m+ + m-) / |p'|^3.

    The geodesic curvatures of the edge on its two strips, both turned by normals of one side; as
    the unit is the mean ruling length, this is curvature times width.
    """

    name = "geodesic"
    constraint = True
    width = 3

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Sums of geodesic curvatures and their gradients."""
        before, here, after = state.around(self.sites, 3)
        a = state.around(self.sites, 3, 1)[1]
        c = state.around(self.sites, 3, 2)[1]
        d, g = after - here, before - here
        (m, long), (k, short) = normed(cross(a, d)), normed(cross(g, a))
        cube = normed(a)[1] ** 3
        turn = cross(a, c) / cube
        values = dot(turn, m + k)[..., None]
        if not slopes:
            return values, {}
        by_w, by_z = through_unit(m, long, turn), through_unit(k, short, turn)
        by_after, by_before = cross(by_w, a), cross(a, by_z)
        by_second = cross(m + k, a) / cube
        by_first = (
            cross(c, m + k) / cube
            - 3.0 * values * a / normed(a)[1] ** 2
            + cross(d, by_w)
            + cross(by_z, g)
        )
        nothing = np.zeros_like(a)
        points = np.stack([by_before, -by_after - by_before, by_after], axis=-2)
        first = np.stack([nothing, by_first, nothing], axis=-2)
        second = np.stack([nothing, by_second, nothing], axis=-2)
        return values, {
            0: points[..., None, :, :],
            1: first[..., None, :, :],
            2: second[..., None, :, :],
        }
