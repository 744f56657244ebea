"""Planar walls along rulings, as plates: between a model and its offset, or between beams.

Glossary
--------
coped wall
    A wall between two beams, cut back to stand clear of their webs and flanges by a weld gap.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.errors import GeometryError
from fabgeo.strips.axes import Axes, axes
from fabgeo.strips.frames import Frames, frames
from fabgeo.strips.model import Patch, StripModel
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.beamline import BeamLine, Section
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
    made = _rulings(model, patches)
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


def coped_walls(
    model: StripModel,
    patches: Sequence[Patch],
    section: Section,
    thickness: float,
    material: str,
    gap: float = 2.0,
    construction: str = "trajectory",
    field: Axes | None = None,
) -> list[Plate]:
    """Walls at the same rulings and of the same marks as `walls`, coped to beams on all edges.

    A wall fills the space between two webs and the flanges above and below, `gap` (mm) clear of
    all of them; walls at the ends of an open strip stand inside its last rulings.

    Raises
    ------
    GeometryError
        If the beams leave no room for it.
    """
    field = axes(model) if field is None else field
    made = _rulings(model, patches)
    us = np.array([u for _, _, u in made])
    f = frames(model, us)
    lines = [BeamLine(model, field, i, section, construction) for i in range(model.edges)]
    out = []
    for k, (strip, cell, u) in enumerate(made):
        mark = f"W-{strip:02d}-{cell:02d}"
        second = (strip + 1) % model.edges
        ends = [
            _beside(lines[edge], f, strip, k, (edge, sign), thickness, gap)
            for edge, sign in ((strip, 1.0), (second, -1.0))
        ]
        low, high = (np.stack([end[side] for end in ends]) for side in (0, 1))
        e, m = f.e[strip, k], f.m[strip, k]
        if min(dot(low[1] - low[0], e), *(dot(high - low, m))) <= 0.0:
            raise GeometryError(
                mark, "has no room between the beams", "make them deeper, or the strips wider"
            )
        inside = 0.0 if model.closed_u else float(u <= 0.0) - float(u >= model.segments)
        step = inside * thickness / 2.0 * cross(e, m)
        step = step * np.sign(dot(cross(e, m), f.t[strip, k]))
        out.append(Plate(mark, mark, "wall", _flat(low + step, high + step), thickness, material))
    return out


def _beside(
    line: BeamLine,
    f: Frames,
    strip: int,
    k: int,
    side: tuple[int, float],
    thickness: float,
    gap: float,
) -> tuple[Array, Array]:
    """Low and high corner (3,) of a wall beside a beam, in the plane of the strip's ruling.

    The flanges' inner faces, seen from the wall's plane, are straight from root to tip: the wall
    keeps clear of both ends. Its side runs along the web's face.
    """
    edge, sign = side
    section, at = line.section, f.u[k : k + 1]
    p, e, m = f.p[edge, k], f.e[strip, k], f.m[strip, k]
    _, _, b = (v[0] for v in line.strip.frame(at))
    b = b * np.sign(dot(b, e))
    levels = section.levels()
    heights = []
    for level, width in (
        (levels["web_in"], section.width_inner if section.flange_inner else 0.0),
        (levels["web_out"], section.width_outer if section.flange_outer else 0.0),
    ):
        faces = line.lines(at, [(level, 0.0), (level, -width / 2.0), (level, width / 2.0)])[:, 0]
        near = faces[dot(faces - faces[0], sign * e) >= 0.0]  # the flange's half on this side
        heights.append(dot(near - p, m))
    reach = section.box / 2.0 + section.web if section.box > 0.0 else section.web / 2.0
    reach += gap + thickness / 2.0 * abs(float(dot(cross(e, m), b)))
    corners = []
    for h in (heights[0].max() + gap, heights[1].min() - gap):
        y = (sign * reach - h * dot(m, b)) / dot(e, b)
        corners.append(p + h * m + y * e)
    return corners[0], corners[1]


def _rulings(model: StripModel, patches: Sequence[Patch]) -> list[tuple[int, int, float]]:
    """Strip, number and u of every wall: first rulings of patches, last rulings of open strips."""
    lasts = {p.strip: p for p in patches}
    made = []
    for patch in patches:
        made.append((patch.strip, patch.cell, patch.u0))
        if patch is lasts[patch.strip] and not model.closed_u:
            made.append((patch.strip, patch.cell + 1, patch.u1))
    return made


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
