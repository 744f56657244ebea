"""Planar walls along rulings between a model and its offset, as plates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fabgeo.arrays import Array, dot, unit
from fabgeo.errors import GeometryError
from fabgeo.strips.axes import Axes, axes
from fabgeo.strips.frames import frames
from fabgeo.strips.model import Patch, StripModel
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Plate


def walls(
    model: StripModel,
    patches: Sequence[Patch],
    distances: tuple[float, float],
    thickness: float,
    material: str,
    clearance: float = 0.0,
    field: Axes | None = None,
) -> list[Plate]:
    """One planar plate at the first ruling of every patch, and at the last of every strip.

    Corners lie on the axes of both edges at the two signed distances from the model, drawn in by
    `clearance` (mm, measured along the ruling) at each edge, e.g. half the web's thickness.
    The mark ``W-03-07`` is that of the patch that begins there; the last ruling of an open strip
    takes the next number.
    """
    field = axes(model) if field is None else field
    lasts = {p.strip: p for p in patches}
    made = []
    for patch in patches:
        made.append((patch.strip, patch.cell, patch.u0))
        closes = model.closed_u and abs(patch.u1 - patch.u0 % model.segments) < 1e-9
        if patch is lasts[patch.strip] and not (model.closed_u or closes):
            made.append((patch.strip, patch.cell + 1, patch.u1))
    us = np.array([u for _, _, u in made])
    f, n = frames(model, us), field(us)
    (n0, n1), (p0, p1) = f.sides(n), f.sides(f.p)
    out = []
    for k, (strip, cell, _) in enumerate(made):
        mark = f"W-{strip:02d}-{cell:02d}"
        e = f.e[strip, k]
        corners = [
            np.stack([p0[strip, k] + d * n0[strip, k], p1[strip, k] + d * n1[strip, k]])
            for d in distances
        ]
        inset = [_drawn_in(c, clearance, e, mark) for c in corners]
        out.append(Plate(mark, mark, "wall", _flat(inset[0], inset[1]), thickness, material))
    return out


def _drawn_in(corners: Array, clearance: float, e: Array, mark: str) -> Array:
    length = dot(corners[1] - corners[0], e)
    if length <= 2.0 * clearance:
        raise GeometryError(
            mark, f"is only {length:.3g} mm long before its clearances", "use wider strips"
        )
    step = clearance * unit(corners[1] - corners[0])
    return np.stack([corners[0] + step, corners[1] - step])


def _flat(low: Array, high: Array) -> RuledPatch:
    """The quad as a ruled patch with straight edge curves from the low to the high side."""
    s = (np.arange(4) / 3.0)[:, None]
    poles = np.stack([low[k] + s * (high[k] - low[k]) for k in (0, 1)])
    return RuledPatch(np.array([0.0] * 4 + [1.0] * 4), poles)
