"""Curved I, T and box beams along edge curves, as plates that unroll (paper section 3, Fig. 8).

The web follows the axis strip of the edge, flanges the strips orthogonal to it. Distances along
the axis are signed like offsets: positive on the side of t x e, so a beam inside has outer < 0.

Glossary
--------
trajectory construction
    Flanges along orthogonal trajectories of the axes: exact, constant depth; the distance from
    the skin drifts along the edge (`standoff_min`, `standoff_max` in `info`).
envelope construction
    Flanges along the offset edges p + d n: constant distance from the skin's planes.
camber
    Largest distance of the beam's middle line from its chord.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Literal

import numpy as np

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.errors import GeometryError, InputError
from fabgeo.strips.axes import Axes, axes
from fabgeo.strips.interpolated import interpolated, knots_between
from fabgeo.strips.model import StripModel
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.beamline import BeamLine, Section
from fabgeo.structures.boxes import oriented_box
from fabgeo.structures.parts import Beam, Plate
from fabgeo.structures.patches import TRANSPORT_BOX
from fabgeo.structures.prisms import ruled_normals


@dataclass(frozen=True)
class BeamRule:
    """How beams are cut into segments.

    Attributes
    ----------
    at : tuple of float, optional
        Parameters of the cuts; otherwise by `box`.
    box : (3,) tuple
        Transport box in mm.
    gap : float
        Weld gap between segments, half on each side, mm.
    end_plate : float
        Thickness of end plates at inner cuts; 0 for none.
    bevel : float
        Groove angle (degrees) of the V weld between segments, ISO 9692-1: the skins of one side
        open by it, those of the other stand `gap` apart; 0 for square ends.
    construction : str
        "trajectory" or "envelope".
    """

    at: tuple[float, ...] | None = None
    box: tuple[float, float, float] = TRANSPORT_BOX
    gap: float = 0.0
    end_plate: float = 0.0
    bevel: float = 0.0
    construction: Literal["trajectory", "envelope"] = "trajectory"

    def __post_init__(self) -> None:
        if min(self.gap, self.end_plate, self.bevel) < 0.0 or self.bevel > 120.0:
            raise InputError("BeamRule", "expected gap, end_plate >= 0 and bevel from 0 to 120 deg")
        if self.end_plate > 0.0 and self.bevel > 0.0:
            raise InputError("BeamRule", "asks for end plates and for bevels", "choose one of them")

    def run(self, thickness: float) -> float:
        """Length (mm) along the plate that the bevel takes from its skin."""
        return thickness * float(np.tan(np.radians(self.bevel / 2.0)))


def beams(
    model: StripModel,
    section: Section,
    rule: BeamRule | None = None,
    edges: Sequence[int] | None = None,
    axes_field: Axes | None = None,
    tolerance: float = 1e-3,
) -> list[Beam]:
    """Beams along edge curves (all of them by default), cut into transportable segments.

    Marks: ``B-03-1`` with plates ``B-03-1-WEB``, ``-FLO``, ``-FLI`` (a box's second web ``-WEC``,
    end plates ``-EPA``, ``-EPB``).

    Raises
    ------
    GeometryError
        If the model is neither conical nor circular, a plate folds, an envelope degenerates, or
        no segment fits the transport box.
    """
    rule = rule or BeamRule()
    found = axes(model) if axes_field is None else axes_field
    chosen = range(model.edges) if edges is None else edges
    out = []
    for edge in chosen:
        line = BeamLine(model, found, edge, section, rule.construction)
        for number, (u0, u1) in enumerate(_segments(line, rule), start=1):
            out.append(_segment(line, rule, number, u0, u1, tolerance))
    return out


def _segments(line: BeamLine, rule: BeamRule) -> list[tuple[float, float]]:
    """Intervals of u, by given cuts or as few equal pieces as fit the transport box."""
    low, high = line.span
    if rule.at is not None:
        inner = sorted(u for u in rule.at if low < u < high)
        bounds = [low, *inner, high]
        return list(pairwise(bounds))
    grid = np.linspace(low, high, 40 * max(4, int(high - low)))
    middle = line.axis_point(grid, line.section.outer - line.section.depth / 2.0)
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(middle, axis=0), axis=1))])
    count = max(1, int(np.ceil(arc[-1] / max(rule.box) / 1.2)))
    while count <= 200:
        bounds = np.interp(np.linspace(0.0, arc[-1], count + 1), arc, grid)
        bounds[-1] = high
        pieces = [(float(a), float(b)) for a, b in pairwise(bounds)]
        outlines = (line.outline(np.linspace(a, b, 9)).reshape(-1, 3) for a, b in pieces)
        if all(oriented_box(points).fits(rule.box) for points in outlines):
            return pieces
        count += 1
    raise GeometryError(
        line.where, f"no segment fits the transport box {rule.box} mm", "reduce the section"
    )


def _segment(
    line: BeamLine, rule: BeamRule, number: int, u0: float, u1: float, tolerance: float
) -> Beam:
    mark = f"B-{line.edge:02d}-{number}"
    low, high = line.span
    cuts = [line.closed or u0 > low + 1e-9, line.closed or u1 < high - 1e-9]
    plates: list[Plate] = []
    ends = []
    for cut, u, sign, name in ((cuts[0], u0, 1.0, "EPA"), (cuts[1], u1, -1.0, "EPB")):
        face = u + sign * _step(line, u, rule.gap / 2.0 if cut else 0.0)
        if cut and rule.end_plate > 0.0:
            plates.append(_end_plate(line, face, sign, rule.end_plate, f"{mark}-{name}", mark))
            face += sign * _step(line, face, rule.end_plate)
        ends.append(face)
    if ends[1] <= ends[0]:
        raise GeometryError(mark, "its end plates and gaps leave nothing of it", "cut longer")
    cut = (cuts[0], cuts[1])
    body = _body(line, rule, (ends[0], ends[1]), cut, tolerance, mark)
    info = _info(line, ends[0], ends[1], body)
    if any(cut):
        info["weld_gap"] = rule.gap
        if rule.bevel > 0.0:
            info["bevel_deg"] = rule.bevel
    return Beam(mark, line.edge, ends[0], ends[1], (*body, *plates), info)


def _body(
    line: BeamLine,
    rule: BeamRule,
    ends: tuple[float, float],
    cuts: tuple[bool, bool],
    tolerance: float,
    mark: str,
) -> list[Plate]:
    """Web or webs and flanges of one segment: curves of equal ends on common knots."""
    out: dict[str, Plate] = {}
    strips = line.plates()
    for thickness in dict.fromkeys(strip.thickness if rule.bevel else 0.0 for strip in strips):
        chosen = [s for s in strips if not rule.bevel or s.thickness == thickness]
        run = rule.run(thickness)
        bevel = (run if cuts[0] else 0.0, run if cuts[1] else 0.0)
        u0, u1 = (
            u + sign * _step(line, u, r / 2.0)
            for u, sign, r in zip(ends, (1.0, -1.0), bevel, strict=True)
        )
        wanted = [place for strip in chosen for place in (strip.first, strip.second)]
        knots = knots_between(u0, u1, multiplicity=2)
        made = interpolated(partial(line.lines, wanted=wanted), knots, tolerance, mark)
        for k, strip in enumerate(chosen):
            mid = RuledPatch(made.knots, made.poles[2 * k : 2 * k + 2])
            name = f"{mark}-{strip.name}"
            out[strip.name] = Plate(
                name, mark, strip.role, mid, strip.thickness, line.section.material, bevel=bevel
            )
    return [out[strip.name] for strip in strips]


def _step(line: BeamLine, u: float, distance: float) -> float:
    """Parameter step on which every corner of the section moves at least `distance`."""
    if distance == 0.0:
        return 0.0
    h = 1e-3
    us = np.array([u - h, u + h])
    if not line.closed:
        us = np.clip(us, *line.span)
    x = line.outline(us)
    direction = cross(*line.strip.frame(np.array([u]))[1:])[0]
    return distance / float(np.abs((x[:, 1] - x[:, 0]) @ direction / (us[1] - us[0])).min())


def _end_plate(
    line: BeamLine, u: float, sign: float, thickness: float, mark: str, parent: str
) -> Plate:
    """A plane plate over the whole section whose outer face lies in the section plane at u."""
    at = np.array([u])
    x = line.outline(at)[:, 0]
    _, n, b = (v[0] for v in line.strip.frame(at))
    along = cross(n, b)
    along = along * np.sign(dot(along, line.strip.curve(at, 1)[0]))
    x = x + sign * thickness / 2.0 * along
    s = (np.arange(4) / 3.0)[:, None]
    poles = np.stack([x[0] + s * (x[3] - x[0]), x[1] + s * (x[2] - x[1])])
    mid = RuledPatch(np.array([0.0] * 4 + [1.0] * 4), poles)
    return Plate(mark, parent, "end_plate", mid, thickness, line.section.material)


def _info(line: BeamLine, u0: float, u1: float, body: list[Plate]) -> dict[str, float | str]:
    """Plain numbers of one segment, measured on its plates and curves; mm."""
    s = line.section
    u = np.linspace(u0, u1, 65)
    outer, inner = line.axis_point(u, s.outer), line.axis_point(u, s.outer - s.depth)
    middle = (outer + inner) / 2.0
    depth = _depth(line, u, body)
    chord = middle[-1] - middle[0]
    span = float(np.linalg.norm(chord))
    off = np.linalg.norm(cross(middle - middle[0], chord), axis=-1) / max(span, 1e-300)
    p = line.strip.curve(u, 0)
    standoff = np.linalg.norm(outer - p, axis=-1)
    box = oriented_box(np.concatenate(list(line.outline(u[::4]))))
    radii = {plate.role: plate_radii(plate.mid) for plate in body}
    info: dict[str, float | str] = {
        "construction": line.construction,
        "length": float(np.linalg.norm(np.diff(middle, axis=0), axis=1).sum()),
        "chord": span,
        "camber": float(off.max()),
        "depth_min": float(depth.min()),
        "depth_max": float(depth.max()),
        "standoff_min": float(standoff.min()),
        "standoff_max": float(standoff.max()),
        "box_length": float(box.size[0]),
        "box_width": float(box.size[1]),
        "box_height": float(box.size[2]),
    }
    for role, (least, largest) in radii.items():
        info[f"{role}_radius_min"], info[f"{role}_radius_max"] = least, largest
    return info


def _depth(line: BeamLine, u: Array, body: list[Plate]) -> Array:
    """Depth (n,) over the flanges along the web, which they lie about by their mid-surfaces.

    Of envelope flanges it is less than from level to level: levels there are apart by a little more
    than the flange is thick.
    """
    s, plates = line.section, {plate.role: plate for plate in body}
    outer, inner = line.axis_point(u, s.outer), line.axis_point(u, s.outer - s.depth)
    along = unit(outer - inner)
    faces = []
    for role, face, sign in (("flange_outer", outer, 1.0), ("flange_inner", inner, -1.0)):
        plate = plates.get(role)
        if plate is not None:
            level = s.outer if sign > 0.0 else s.outer - s.depth
            middle = line.axis_point(u, level - sign * plate.thickness / 2.0)
            normal = ruled_normals(plate.mid, np.clip(u, plate.mid.u0, plate.mid.u1))
            reach = plate.thickness / 2.0 / np.abs(dot(normal, along))
            face = middle + sign * reach[:, None] * along
        faces.append(face)
    return np.linalg.norm(faces[0] - faces[1], axis=-1)


def plate_radii(mid: RuledPatch) -> tuple[float, float]:
    """Least and largest bending radius of a developable patch, mm (inf where flat)."""
    u = mid.parameters(4)
    h = 1e-4 * (mid.u1 - mid.u0)
    inside = np.clip(u, mid.u0 + h, mid.u1 - h)
    dm = (ruled_normals(mid, inside + h) - ruled_normals(mid, inside - h)) / (2.0 * h)
    a, b = mid.edges(inside)
    chord: Array = b - a
    m = ruled_normals(mid, inside)
    side = cross(chord / np.linalg.norm(chord, axis=-1, keepdims=True), m)
    turn = np.linalg.norm(dm, axis=-1)
    speeds = np.stack([np.abs(dot(d, side)) for d in mid.edges(inside, 1)])
    with np.errstate(divide="ignore"):
        radius = np.where(turn > 1e-12, speeds / np.maximum(turn, 1e-300), np.inf)
    return float(radius.min()), float(radius.max())


def with_holes(beam: Beam, plates: Sequence[Plate]) -> Beam:
    """The beam with some of its plates replaced (those of equal mark)."""
    new = {plate.mark: plate for plate in plates}
    return replace(beam, plates=tuple(new.get(plate.mark, plate) for plate in beam.plates))
