"""The panel as it will be made: a ruled patch that lies exactly on the shape that replaces it."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

from fabgeo import spline
from fabgeo.arrays import Array
from fabgeo.errors import GeometryError
from fabgeo.panels.shapes import Carrier, Plane
from fabgeo.strips.ruled import RuledPatch


def as_made(patch: RuledPatch, shape: Carrier, tolerance: float = 5e-5) -> RuledPatch:
    """The patch carried over to its replacement.

    Both edge curves are projected onto the shape; the made ruling at u is the shape's ruling
    midway between the two that pass through the projected points of u, met with both projected
    edges. The ends are therefore rulings of the shape. On a plane every line is one: the
    projections are joined as they are.

    Parameters
    ----------
    patch : RuledPatch
        The fitted panel.
    shape : Carrier
        What replaces it.
    tolerance : float
        Largest distance of the made patch from the shape, mm.

    Raises
    ------
    GeometryError
        If the shape's rulings do not run from edge to edge.
    """
    spans = len(np.unique(patch.knots)) - 1
    if isinstance(shape, Plane):  # projection onto a plane maps poles to poles
        return RuledPatch(patch.knots, np.stack([shape.project(p) for p in patch.poles]))
    for pieces in (1, 2, 4, 8, 16, 32, 64):
        knots = _refined(patch.knots, pieces)
        sites = spline.greville(knots)
        first, second = _met(patch, shape, sites)
        made = RuledPatch.through(knots, sites, first, second)
        check = made.parameters(5)
        a, b = made.edges(check)
        off = max(float(np.abs(shape.distance(x)).max()) for x in (a, b, (a + b) / 2.0))
        if off <= tolerance or spans * pieces > 2000:
            return made
    return made


def _refined(knots: Array, pieces: int) -> Array:
    spans = np.unique(knots)
    fraction = np.arange(pieces) / pieces
    inner = (spans[:-1, None] + fraction * np.diff(spans)[:, None]).ravel()[1:]
    return np.concatenate([[spans[0]] * 4, inner, [spans[-1]] * 4])


def _met(patch: RuledPatch, shape: Carrier, sites: Array) -> tuple[Array, Array]:
    """Points of both made edges at the sites."""
    curve = BSpline(patch.knots, np.moveaxis(patch.poles, 1, 0), 3, extrapolate=True)

    def turn_reach(u: Array, side: int) -> tuple[Array, Array]:
        turn, reach = shape.batch.coordinates(np.asarray(curve(u))[None, :, side])
        return turn[0], reach[0]

    turns = [turn_reach(sites, side)[0] for side in (0, 1)]
    wanted = (turns[0] + turns[1]) / 2.0
    if np.any(np.diff(wanted) * np.sign(wanted[-1] - wanted[0]) <= 0.0):
        raise GeometryError(
            "made panel", "the shape's rulings do not follow the panel's", "keep it developable"
        )
    edges = []
    for side in (0, 1):
        u = sites + np.interp(wanted, *_ascending(turns[side], sites)) - sites
        h = 1e-4 * (patch.u1 - patch.u0)
        for _ in range(3):  # Newton on the turn, its slope by differences
            turn = turn_reach(u, side)[0]
            slope = (turn_reach(u + h, side)[0] - turn_reach(u - h, side)[0]) / (2.0 * h)
            u = u + (wanted - turn) / slope
        edges.append(shape.batch.at(wanted[None], turn_reach(u, side)[1][None])[0])
    return edges[0], edges[1]


def _ascending(x: Array, y: Array) -> tuple[Array, Array]:
    return (x, y) if x[-1] > x[0] else (x[::-1], y[::-1])
