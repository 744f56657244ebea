"""Given points that edge curves are to meet: f_prox,discrete of paper section 1."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array, IntArray, dot
from fabgeo.fitting.objectives.base import Gradients, Objective, State
from fabgeo.fitting.samples import Net, Sites, normed, through_unit


class MountingPoints(Objective):
    """Distance of each mounting point to the tangent at its edge point.

    Which edge and parameter belong to a point is settled at the beginning of a stage and kept;
    the tangent lets the curve slide.

    Parameters
    ----------
    net : Net
    edges : (k,) int array
        The edge of each point.
    u : (k,) array
        The parameter of the closest point on it.
    points : (k, 3) array
        In the fit's unit.
    """

    name = "mounting points"
    width = 1

    def __init__(self, net: Net, edges: IntArray, u: Array, points: Array) -> None:
        super().__init__(Sites(net, u[:, None], np.ones((len(u), 1))))
        self._edges, self._points = edges, points
        self.window = np.zeros((1, 1), dtype=np.int64)
        self._nodes = edges[:, None] * net.columns + self.sites.index

    def nodes(self) -> IntArray:
        """Each point has its own edge: (k, 4)."""
        return self._nodes

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Vectors from the points to the tangents and their gradients."""
        pick = (self._edges, np.arange(len(self._edges)))
        point = state.at(self.sites)[pick]
        t, speed = normed(state.at(self.sites, 1)[pick])
        away = point - self._points[:, None]
        along = dot(t, away)[..., None]
        values = (away - along * t)[None]
        if not slopes:
            return values, {}
        across = np.eye(3) - t[..., :, None] * t[..., None, :]
        # Row c of the derivative by the unit tangent: -(t . w) 1_c - t_c w.
        by_t = -along[..., None] * np.eye(3) - t[..., :, None] * away[..., None, :]
        first = through_unit(t[..., None, :], speed[..., None, :], by_t)
        return values, {0: across[None, ..., None, :], 1: first[None, ..., None, :]}


def closest_sites(net: Net, control: Array, points: Array) -> tuple[IntArray, Array]:
    """The edge and the parameter closest to each point (k, 3)."""
    u = (np.arange(net.segments)[:, None] + np.arange(8) / 8.0).ravel()
    if not net.closed_u:
        u = np.append(u, net.segments)
    dense = Sites(net, u[:, None], np.ones((len(u), 1)))
    curve = dense.evaluate(control)[:, :, 0].reshape(-1, 3)
    nearest = np.array([int(np.argmin(np.sum((curve - p) ** 2, axis=1))) for p in points])
    edges, at = np.divmod(nearest, len(u))
    parameter = u[at]
    for _ in range(8):  # Newton along the tangent
        sites = Sites(net, parameter[:, None], np.ones((len(parameter), 1)))
        pick = (edges, np.arange(len(edges)), 0)
        away, d = points - sites.evaluate(control)[pick], sites.evaluate(control, 1)[pick]
        parameter = parameter + np.clip(dot(away, d) / dot(d, d), -0.1, 0.1)
        parameter = (
            np.mod(parameter, net.segments)
            if net.closed_u
            else np.clip(parameter, 0.0, net.segments)
        )
    return edges, parameter
