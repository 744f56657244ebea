"""Nets that reach beyond the surface's boundary, for models that are trimmed to it later."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from fabgeo.arrays import Array, dot, unit
from fabgeo.fitting.starts.net import Net
from fabgeo.surfaces.trace_extension import Extended


def overhanging(
    net: Net, surface: Extended, shares: tuple[float, float], across: bool = False
) -> Net:
    """The net continued along its open edges by shares of their length at the two ends.

    Parameters
    ----------
    surface : Extended
        The surface with its continuation, onto which new points are brought.
    shares : (float, float)
        Of the edges' length, at t = 0 and at t = 1; 0 leaves an end on the boundary.
    across : bool
        Whether to continue the net across the edges as well.
    """
    if not net.closed_t:
        net = _continued(net, surface, shares)
    if across and not net.closed_s:
        net = _continued(net.turned, surface, shares).turned
    return net


def shortened(net: Net, shares: tuple[float, float]) -> Net:
    """The net without shares of its open edges' length at t = 0 and at t = 1."""
    rows, columns = net.points.shape[:2]
    s = np.arange(rows) / (rows if net.closed_s else rows - 1)
    t = np.linspace(shares[0], 1.0 - shares[1], columns)
    return Net(net.sampled(s, t), net.closed_s, False)


def uncovered(points: Array, surface: Extended) -> Array:
    """How far the boundary lies beyond the outer lines of a net: (rows, columns) x (first, last).

    0 where the outer line lies wholly beyond the boundary: the net covers the surface there.
    """
    border = np.concatenate(surface.loops)
    missing = np.zeros((2, 2))
    for axis in (0, 1):
        lines = np.moveaxis(points, axis, 0)
        for side, (outer, inner) in enumerate(((lines[0], lines[1]), (lines[-1], lines[-2]))):
            if surface.beyond(outer).min() > 0.0:
                continue
            near = KDTree(outer).query(border)[1]
            out = dot(border - outer[near], unit(outer - inner)[near])
            missing[axis, side] = max(float(out.max()), 0.0)
    return missing


def _continued(net: Net, surface: Extended, shares: tuple[float, float]) -> Net:
    columns = net.points.shape[1] - 1
    rows = net.points.shape[0]
    s = np.arange(rows) / (rows if net.closed_s else rows - 1)
    t = [_beyond(shares[0], columns)[::-1] * -1.0, np.linspace(0.0, 1.0, columns + 1)]
    t.append(1.0 + _beyond(shares[1], columns))
    start = _tangential(net, surface, s, 0.0, t[0])
    end = _tangential(net, surface, s, 1.0, t[2] - 1.0)
    widened = Net(np.concatenate([start, net.points, end], axis=1), net.closed_s, False)
    # Even columns again: the spline through them is a uniform one.
    place = np.concatenate(t)
    even = np.linspace(place[0], place[-1], len(place))
    index = np.interp(even, place, np.arange(len(place))) / (len(place) - 1)
    return Net(widened.sampled(s, index), net.closed_s, False)


def _beyond(share: float, columns: int) -> Array:
    """Places beyond an end, about as dense as the columns."""
    count = max(int(np.ceil(share * columns)), 1) if share > 0.0 else 0
    return share * np.arange(1, count + 1) / max(count, 1)


def _tangential(net: Net, surface: Extended, s: Array, end: float, x: Array) -> Array:
    at = np.full(len(s), end)
    points = net.evaluate(s, at)[:, None] + x[:, None] * net.evaluate(s, at, 0, 1)[:, None]
    return surface.closest(points.reshape(-1, 3)).point.reshape(points.shape)
