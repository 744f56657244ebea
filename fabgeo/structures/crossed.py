"""Two strip models crossed: the smooth direction of one runs across the strips of the other.

The discrete direction of each lies along the smooth direction of the other (paper section 3), so
beams along both families of edges make a grid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from fabgeo.arrays import Array, BoolArray, IntArray, dot, unit
from fabgeo.errors import GeometryError
from fabgeo.strips.distances import project
from fabgeo.strips.frames import frames
from fabgeo.strips.model import StripModel
from fabgeo.structures.beams import BeamRule, Section, beams
from fabgeo.structures.parts import Beam


@dataclass(frozen=True)
class Crossing:
    """How two strip models cross.

    Attributes
    ----------
    angle_min_deg : float
        Least angle between an edge of one and the nearest edge of the other: 90 where they
        cross squarely.
    gap_min, gap_max : float
        Distance between the two models, measured at samples of the outer one, mm.
    """

    angle_min_deg: float
    gap_min: float
    gap_max: float


@dataclass(frozen=True)
class Crossed(Crossing):
    """Two strip models crossed: beams of both, and how well they match.

    Attributes
    ----------
    outer, inner : list of Beam
    """

    outer: list[Beam]
    inner: list[Beam]


def crossed(
    outer: StripModel,
    inner: StripModel,
    sections: tuple[Section, Section],
    rule: BeamRule | None = None,
) -> Crossed:
    """Beams of two crossed strip models, the smooth direction of one along the strips of the other.

    Raises
    ------
    GeometryError
        If a model admits no beams, or their edges run along rather than across each other.
    """
    found = crossing(outer, inner)
    return Crossed(
        found.angle_min_deg,
        found.gap_min,
        found.gap_max,
        beams(outer, sections[0], rule),
        beams(inner, sections[1], rule),
    )


def crossing(outer: StripModel, inner: StripModel) -> Crossing:
    """Angles and distances of two crossed strip models, without their beams.

    Raises
    ------
    GeometryError
        If they don't lie over each other, or their edges run along each other.
    """
    f, g = frames(outer, outer.parameters(4)), frames(inner, inner.parameters(4))
    p0, p1 = g.sides(g.p)
    _, near = KDTree(((p0 + p1) / 2.0).reshape(-1, 3)).query(f.p.reshape(-1, 3))
    strip, column = np.divmod(near, len(g.u))
    p = f.p.reshape(-1, 3)
    gap, u, v = project(inner, p, strip, g.u[column], np.full(len(p), 0.5))
    over = _inside(inner, strip, u, v)
    if not over.any():
        raise GeometryError("crossed models", "don't lie over each other", "move one of them")
    s = _directions(inner, strip, u, v)
    angle = np.degrees(np.arccos(np.minimum(np.abs(dot(f.t.reshape(-1, 3), s)), 1.0)))
    angle = np.where(over, angle, 90.0)
    at = int(np.argmin(angle))
    if angle[at] < 30.0:
        edge, column = divmod(at, len(f.u))
        raise GeometryError(
            f"crossed models, outer edge {edge} at u = {f.u[column]:.3g}",
            f"edges of both models meet at {angle[at]:.1f} deg; expected 30 deg or more",
            "let the strips of one model run across those of the other",
        )
    gap = gap[over]
    return Crossing(float(angle.min()), float(gap.min()), float(gap.max()))


def _inside(model: StripModel, strip: IntArray, u: Array, v: Array) -> BoolArray:
    """Which feet lie within the model, not on its free boundary."""
    inside = np.ones(len(u), dtype=bool)
    if not model.closed_u:
        inside &= (u > 0.0) & (u < model.segments)
    if not model.closed_i:
        inside &= ~((strip == 0) & (v <= 0.0)) & ~((strip == model.strips - 1) & (v >= 1.0))
    return inside


def _directions(model: StripModel, strip: IntArray, u: Array, v: Array) -> Array:
    """Unit u-directions of the model at strips, u, v (k,): the edges' direction there."""
    rows = np.arange(len(u))
    d0, d1 = model.pairs(model.points(u, 1))
    d0, d1 = d0[strip, rows], d1[strip, rows]
    return unit(d0 + v[:, None] * (d1 - d0))
