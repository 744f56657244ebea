"""The panel as it will be made: a ruled patch on the shape that replaces it.

Both edge curves are projected onto the shape. The made panel is cut along its joints, so its ends
should run where the fitted end rulings ran, but a ruled patch ends in ruling lines, and those of
the shape may swing away. Lines that swing from the shape's rulings by little are as good: a line
that leaves one by w over its length lies w^2 kappa / 8 below the surface, 0.01 mm for 30 mm at a
radius of 11 m. So at u the made line joins the projections of both edge points, drawn together
towards the shape's ruling midway between them by a factor, the skew, that keeps this sag within
the form tolerance: 1 are the fitted rulings, 0 exactly the shape's.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

from fabgeo import spline
from fabgeo.arrays import Array
from fabgeo.errors import GeometryError
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.samples import Samples, sample
from fabgeo.panels.shapes import Carrier, Plane
from fabgeo.strips.ruled import RuledPatch

_FORM = 0.01  # mm


def skew_of(samples: Samples, carriers: Carriers, form_mm: float = _FORM) -> Array:
    """Largest skew (p,) of every panel's ruling lines that keeps the form tolerance."""
    ends = [samples.edges[0, :, :, side] for side in (0, 1)]
    turns = [carriers.coordinates(end)[0] for end in ends]
    # Turns are arcs at the origin's level; 1 + g reach scales them, the curvature with its inverse.
    sag = 0.0
    for end in ends:
        q = np.abs(carriers.k)[:, None] / np.maximum(np.abs(carriers.curvature(end)[0]), 1e-300)
        width = (turns[1] - turns[0]) * np.where(carriers.k[:, None] == 0.0, 0.0, q)
        sag = np.maximum(sag, np.abs(carriers.curvature(end)[0]) * width**2 / 8.0)
    most = np.max(sag, axis=1)
    return np.sqrt(np.minimum(1.0, form_mm / np.maximum(most, 1e-300)))


def as_made(
    patch: RuledPatch, shape: Carrier, skew: float | None = None, tolerance: float = 5e-5
) -> RuledPatch:
    """The patch carried over to its replacement.

    Parameters
    ----------
    patch : RuledPatch
        The fitted panel.
    shape : Plane, Cylinder or Cone
        What replaces it.
    skew : float, optional
        How far the ruling lines follow the fitted ones; None: as the default form tolerance of
        0.01 mm allows; 0: the lines are exactly the shape's rulings.
    tolerance : float
        Largest distance of the made edge curves from the shape, mm.

    Raises
    ------
    GeometryError
        If the shape's rulings do not run from edge to edge.
    """
    if isinstance(shape, Plane):  # projection onto a plane maps poles to poles
        return RuledPatch(patch.knots, np.stack([shape.project(p) for p in patch.poles]))
    if skew is None:
        skew = float(skew_of(sample([patch]), shape.batch)[0])
    pieces = 1
    while True:
        knots = _refined(patch.knots, pieces)
        sites = spline.greville(knots)
        first, second = _met(patch, shape, sites, skew)
        made = RuledPatch.through(knots, sites, first, second)
        edges = made.edges(made.parameters(3))
        off = max(float(np.abs(shape.distance(edge)).max()) for edge in edges)
        if off <= tolerance or pieces >= 64:
            return made
        # The error of a cubic falls with the fourth power of the spacing.
        pieces = min(64, max(pieces + 1, int(np.ceil(1.1 * pieces * (off / tolerance) ** 0.25))))


def _refined(knots: Array, pieces: int) -> Array:
    spans = np.unique(knots)
    fraction = np.arange(pieces) / pieces
    inner = (spans[:-1, None] + fraction * np.diff(spans)[:, None]).ravel()[1:]
    return np.concatenate([[spans[0]] * 4, inner, [spans[-1]] * 4])


def _met(patch: RuledPatch, shape: Carrier, sites: Array, skew: float) -> tuple[Array, Array]:
    """Points of both made edges at the sites."""
    curve = BSpline(patch.knots, np.moveaxis(patch.poles, 1, 0), 3, extrapolate=True)

    def turn_reach(u: Array, side: int) -> tuple[Array, Array]:
        turn, reach = shape.batch.coordinates(np.asarray(curve(u))[None, :, side])
        return turn[0], reach[0]

    if skew >= 1.0:
        first, second = (shape.project(np.asarray(curve(sites))[:, side]) for side in (0, 1))
        return first, second
    turns = [turn_reach(sites, side)[0] for side in (0, 1)]
    mean = (turns[0] + turns[1]) / 2.0
    if np.any(np.diff(mean) * np.sign(mean[-1] - mean[0]) <= 0.0):
        raise GeometryError(
            "made panel", "the shape's rulings do not follow the panel's", "keep it developable"
        )
    edges = []
    for side in (0, 1):
        wanted = mean + skew * (turns[side] - mean)
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
