"""Panels with thickness: layers at given distances, joints taken off along edges and rulings.

Any developable strip has offsets along its own normal m(u) with parallel rulings; a panel of a
layer at height h lies on p + h m. Its long edges run where it meets the offset tangent plane of the
strip beyond, so that neighbouring panels of any layer meet edge to edge before the joint is taken
off: at the same point, p + h (m + a e), in a conical model, else along the edge from each other.

Glossary
--------
joint
    Clear width between neighbouring panels at mid-surface. "parallel": half of it is taken off
    square to the edge on the developed strip; "ruling": along the ruling.
layer
    One leaf of the skin, such as glass, insulation or lining: height of its mid-surface above the
    model (negative: inside), thickness and material.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.errors import GeometryError, InputError
from fabgeo.strips.frames import frames
from fabgeo.strips.interpolated import interpolated, knots_between
from fabgeo.strips.model import Patch, StripModel
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Plate
from fabgeo.structures.prisms import ruled_normals

type JointSides = Literal["parallel", "ruling"]


@dataclass(frozen=True)
class Layer:
    """One leaf of the skin; `height` of its mid-surface along m, in mm."""

    name: str
    height: float
    thickness: float
    material: str


@dataclass(frozen=True)
class Joint:
    """Joint widths in mm and how they are taken off along edge curves.

    `seams`: whether other models go on beyond the model's first and its last edge, so that joints
    are taken off there too.
    """

    edge: float = 0.0
    ruling: float = 0.0
    sides: JointSides = "parallel"
    at_boundary: bool = False
    seams: tuple[bool, bool] = (False, False)


def panels(
    model: StripModel,
    patches: Sequence[Patch],
    layer: Layer,
    joint: Joint | None = None,
    tolerance: float = 1e-3,
    suffix: str = "",
    first: int = 0,
) -> list[Plate]:
    """Panels of one layer, one a patch, in the order of the patches.

    Works on a model of any kind. Marks are ``P-03-07`` plus `suffix` (such as ``-INS`` for a
    second leaf); `shared` names the neighbours across edges and rulings. `first` is the number
    that the patches give to the model's first strip.

    Raises
    ------
    GeometryError
        If joints eat a panel up, or a layer lies beyond the smallest bending radius.
    """
    joint = joint or Joint()
    if layer.thickness <= 0.0:
        raise InputError(f"layer {layer.name}", f"expected thickness > 0, found {layer.thickness}")
    known: dict[int, list[Patch]] = defaultdict(list)
    for patch in patches:
        known[patch.strip].append(patch)
    strips = _Strips(model, first, known)
    return [_panel(strips, patch, layer, joint, tolerance, suffix) for patch in patches]


@dataclass(frozen=True)
class _Strips:
    """A model, the number of its first strip, and the patches on each."""

    model: StripModel
    first: int
    known: Mapping[int, Sequence[Patch]]


def _panel(
    strips: _Strips,
    patch: Patch,
    layer: Layer,
    joint: Joint,
    tolerance: float,
    suffix: str,
) -> Plate:
    mark = patch.mark + suffix
    shared = _neighbours(strips, patch, suffix)
    row = patch.strip - strips.first
    outer = (row == 0 and joint.seams[0], row == strips.model.strips - 1 and joint.seams[1])
    take = [
        (joint.edge if (side in shared or joint.at_boundary or seam) else 0.0) / 2.0
        for side, seam in zip(("first", "second"), outer, strict=True)
    ]
    trim = [
        (joint.ruling if (side in shared or joint.at_boundary) else 0.0) / 2.0
        for side in ("start", "end")
    ]
    local = _strip_only(strips.model, row)
    u0 = patch.u0 + _ruling_step(local, patch.strip, patch.u0, trim[0], layer.height)
    u1 = patch.u1 - _ruling_step(local, patch.strip, patch.u1, trim[1], layer.height)
    if u1 - u0 < 0.02 * (patch.u1 - patch.u0):
        raise GeometryError(mark, "its joints leave nothing of it", "cut longer panels")

    def curves(u: Array) -> Array:
        return layer_edges(local, u, layer.height, take, joint.sides, mark)

    made = interpolated(curves, knots_between(u0, u1), tolerance, mark)
    mid = RuledPatch(made.knots, made.poles)
    _refuse_regressive(mid, mark, layer.height)
    return Plate(mark, mark, "panel", mid, layer.thickness, layer.material, shared=shared)


@dataclass(frozen=True)
class _Local:
    """One strip of a model with its neighbours, as edge curves of their own (quick to evaluate)."""

    model: StripModel
    row: int  # of the strip within `model`


def _strip_only(model: StripModel, strip: int) -> _Local:
    if model.closed_i:
        index = (strip - 1 + np.arange(4)) % model.edges
        return _Local(StripModel(model.control[index], model.closed_u), 1)
    low, high = max(strip - 1, 0), min(strip + 2, model.edges - 1)
    return _Local(StripModel(model.control[low : high + 1], model.closed_u), strip - low)


def layer_edges(
    local: _Local, u: Array, height: float, take: Sequence[float], sides: str, mark: str
) -> Array:
    """Both edge curves (2, k, 3) of a panel at `height`, drawn in by `take` (mm) at each edge."""
    f = frames(local.model, u)
    row = local.row
    e, m = f.e[row], f.m[row]
    ends = []
    for side, sign in ((0, 1.0), (1, -1.0)):
        t, beyond = f.t[row + side], row - int(sign)
        own = _lean(m, sign * e, t, f.m[beyond]) if 0 <= beyond < len(f.m) else 0.0
        # Square to the edge on the developed strip: the ruling meets the edge at angle phi.
        sine = dot(cross(t, e), m)
        along = take[side] / sine if sides == "parallel" else np.full(len(u), take[side])
        step = sign * (height * own + along)
        ends.append(f.p[row + side] + height * m + step[:, None] * e)
    if np.any(dot(ends[1] - ends[0], e) <= 0.0):
        raise GeometryError(mark, "its joints leave nothing of it", "use wider strips")
    return np.stack(ends)


def _lean(m: Array, inwards: Array, t: Array, beyond: Array) -> Array:
    """Lean a (k,), (m + a inwards) . beyond = 1, of unit normals m and beyond on an edge along t.

    By the angle of the two planes about the edge, which both contain but for their strips' twist:
    where they hardly differ, twist decides how.
    """
    square = unit(cross(m, t))
    half = np.arctan2(dot(square, beyond), dot(m, beyond)) / 2.0
    return np.tan(half) / dot(inwards, square)


def _ruling_step(local: _Local, strip: int, u: float, distance: float, height: float) -> float:
    """Parameter step along which the nearer end of the ruling moves `distance` square to it."""
    if distance == 0.0:
        return 0.0
    h = 1e-3
    us = np.clip(
        np.array([u - h, u + h]), 0.0, None if local.model.closed_u else local.model.segments
    )
    x = layer_edges(local, us, height, (0.0, 0.0), "ruling", f"strip {strip}")
    f = frames(local.model, np.array([u]))
    side = cross(f.e[local.row, 0], f.m[local.row, 0])
    speed = np.abs((x[:, 1] - x[:, 0]) @ side / (us[1] - us[0])).min()
    return distance / float(speed)


def _neighbours(strips: _Strips, patch: Patch, suffix: str) -> dict[str, str]:
    """Marks of the panels across the patch's edges (the one that overlaps most) and rulings."""
    model, known, out = strips.model, strips.known, {}
    for side, step in (("first", -1), ("second", 1)):
        strip = patch.strip + step
        if model.closed_i:
            strip = (strip - strips.first) % model.strips + strips.first
        best, most = "", 1e-9
        for other in known.get(strip, ()):
            overlap = min(other.u1, patch.u1) - max(other.u0, patch.u0)
            if overlap > most:
                best, most = other.mark + suffix, overlap
        if best:
            out[side] = best
    row = sorted(known[patch.strip], key=lambda p: p.u0)
    at = row.index(patch)
    if at > 0:
        out["start"] = row[at - 1].mark + suffix
    elif model.closed_u and abs(row[-1].u1 - row[0].u0 - model.segments) < 1e-9:
        out["start"] = row[-1].mark + suffix
    if at < len(row) - 1:
        out["end"] = row[at + 1].mark + suffix
    elif model.closed_u and abs(row[-1].u1 - row[0].u0 - model.segments) < 1e-9:
        out["end"] = row[0].mark + suffix
    return out


def _refuse_regressive(mid: RuledPatch, mark: str, height: float) -> None:
    u = mid.parameters(4)
    a, b = mid.edges(u)
    da, db = mid.edges(u, 1)
    e = unit(b - a)
    m = ruled_normals(mid, u)
    side = cross(e, m)
    speeds = np.stack([dot(da, side), dot(db, side)])
    if np.any(speeds <= 0.0):
        raise GeometryError(
            mark,
            f"folds over at height {height:g} mm: its bending radius is smaller, or its rulings "
            "meet inside",
            "move the layer, or refit with wider strips",
        )
