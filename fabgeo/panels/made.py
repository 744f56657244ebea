"""The panel as it will be made: a ruled patch on the shape that replaces it.

Both edge curves are projected onto the shape, and the lines between them are the shape's own
rulings: the made panel is exactly a piece of a plane, cylinder or cone, without twist, and unrolls
as one. Its ends run along the shape's rulings midway between where the fitted end rulings began
and ended; what they swing from the joint by is measured as a gap.

Joints at the ends are taken off the panel as made: off a fitted one, whose rulings may fan
otherwise, they would not leave as wide a joint.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

from fabgeo import spline
from fabgeo.arrays import Array, BoolArray
from fabgeo.errors import GeometryError
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.samples import Samples
from fabgeo.panels.shapes import Carrier, Plane
from fabgeo.strips.ruled import RuledPatch


def follows(samples: Samples, carriers: Carriers) -> BoolArray:
    """Whether the carriers' rulings (p,) run from edge to edge, in order, clear of an apex."""
    ends = [samples.edges[0, :, :, side] for side in (0, 1)]
    (turn, reach), (other, far) = (carriers.coordinates(end) for end in ends)
    mean = np.diff((turn + other) / 2.0, axis=1)
    ordered = np.all(mean > 0.0, axis=1) | np.all(mean < 0.0, axis=1)
    level = 1.0 + carriers.g[:, None] * np.concatenate([reach, far], axis=1)
    return (ordered & np.all(level > 1e-6, axis=1)) | ((carriers.k == 0.0) & (carriers.g == 0.0))


def end_shift(samples: Samples, carriers: Carriers) -> Array:
    """How far (p, 2, 2) the made ends leave the fitted ones along the strip, at their corners, mm.

    By start and end, then first and second edge. On a plane ends stay where they are.
    """
    corners = samples.edges[0][:, [0, -1]].reshape(len(samples), 4, 3)
    turn, reach = (a.reshape(-1, 2, 2) for a in carriers.coordinates(corners))
    shift = turn.mean(axis=2, keepdims=True) - turn
    bent = (carriers.k != 0.0)[:, None, None]
    return np.where(bent, shift * (1.0 + carriers.g[:, None, None] * reach), 0.0)


def end_turns(whole: RuledPatch, shape: Carrier, take: tuple[float, float]) -> tuple[float, float]:
    """Turns on the shape of a panel's first and last ruling, with joints taken off it as made.

    Parameters
    ----------
    whole : RuledPatch
        The fitted panel up to the middle of its joints.
    take : pair of float
        How far the slower end of either ruling comes in from there, mm.
    """
    corners = whole.poles[:, [0, -1]].transpose(1, 0, 2)
    turn, reach = (a.reshape(2, 2) for a in shape.batch.coordinates(corners.reshape(1, 4, 3)))
    mean = turn.mean(axis=1)
    slower = (1.0 + shape.g * reach).min(axis=1)  # how far an end goes while the ruling turns by 1
    first, last = mean + np.sign(mean[1] - mean[0]) * np.array([1.0, -1.0]) * take / slower
    return float(first), float(last)


def as_made(
    patch: RuledPatch,
    shape: Carrier,
    turns: tuple[float, float] | None = None,
    tolerance: float = 5e-5,
) -> RuledPatch:
    """The patch carried over to its replacement.

    Parameters
    ----------
    patch : RuledPatch
        The fitted panel, or as much of it as is cut.
    shape : Plane, Cylinder or Cone
        What replaces it.
    turns : pair of float, optional
        Turns of its first and last ruling, by default of the patch's own (on a plane always).
    tolerance : float
        Largest distance of the made edge curves from the shape, mm.

    Raises
    ------
    GeometryError
        If the shape's rulings do not run from edge to edge.
    """
    if isinstance(shape, Plane):  # projection onto a plane maps poles to poles
        return RuledPatch(patch.knots, np.stack([shape.project(p) for p in patch.poles]))
    pieces = 1
    while True:
        knots = _refined(patch.knots, pieces)
        sites = spline.greville(knots)
        first, second = _met(patch, shape, sites, turns)
        made = RuledPatch.through(knots, sites, first, second)
        edges = made.edges(made.parameters(3))
        off = max(float(np.abs(shape.distance(edge)).max()) for edge in edges)
        if not np.isfinite(off):
            raise _not_followed()
        if off <= tolerance or pieces >= 64:
            return made
        # The error of a cubic falls with the fourth power of the spacing.
        pieces = min(64, max(pieces + 1, int(np.ceil(1.1 * pieces * (off / tolerance) ** 0.25))))


def _not_followed() -> GeometryError:
    return GeometryError(
        "made panel", "the shape's rulings do not follow the panel's", "keep it developable"
    )


def _refined(knots: Array, pieces: int) -> Array:
    spans = np.unique(knots)
    fraction = np.arange(pieces) / pieces
    inner = (spans[:-1, None] + fraction * np.diff(spans)[:, None]).ravel()[1:]
    return np.concatenate([[spans[0]] * 4, inner, [spans[-1]] * 4])


def _met(
    patch: RuledPatch, shape: Carrier, sites: Array, ends: tuple[float, float] | None
) -> tuple[Array, Array]:
    """Points of both made edges at the sites, between rulings at given turns."""
    curve = BSpline(patch.knots, np.moveaxis(patch.poles, 1, 0), 3, extrapolate=True)

    def turn_reach(u: Array, side: int) -> tuple[Array, Array]:
        turn, reach = shape.batch.coordinates(np.asarray(curve(u))[None, :, side])
        return turn[0], reach[0]

    turns = [turn_reach(sites, side)[0] for side in (0, 1)]
    mean = (turns[0] + turns[1]) / 2.0
    if ends is not None:
        mean = mean + np.interp(sites, sites[[0, -1]], np.array(ends) - mean[[0, -1]])
    if np.any(np.diff(mean) * np.sign(mean[-1] - mean[0]) <= 0.0):
        raise _not_followed()
    edges = []
    for side in (0, 1):
        u = sites + np.interp(mean, *_ascending(turns[side], sites)) - sites
        h = 1e-4 * (patch.u1 - patch.u0)
        for _ in range(3):  # Newton on the turn, its slope by differences
            turn = turn_reach(u, side)[0]
            slope = (turn_reach(u + h, side)[0] - turn_reach(u - h, side)[0]) / (2.0 * h)
            u = u + (mean - turn) / slope
        edges.append(shape.batch.at(mean[None], turn_reach(u, side)[1][None])[0])
    return edges[0], edges[1]


def _ascending(x: Array, y: Array) -> tuple[Array, Array]:
    return (x, y) if x[-1] > x[0] else (x[::-1], y[::-1])
