"""Seams: where the panels of models side by side meet.

Both models are fitted to one geodesic there, but each has its own rulings, so that panels face each
other anywhere along it. What their edges leave open beside a joint, or overlap, stands in the rows
of both panels as a gap does between panels of one model.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from fabgeo.arrays import Array, BoolArray, cross, dot, unit
from fabgeo.panels.classify import PanelChoice
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Plate
from fabgeo.structures.prisms import ruled_normals

if TYPE_CHECKING:
    from fabgeo.build.geometry import Design

PLACES = 129  # on an edge, where it is measured
STEPS = 6  # of Newton's method to the nearest point
REACH = 100.0  # mm beside the joint: edges farther apart do not face each other
LEAST = 3  # places with the other edge right across


@dataclass(frozen=True)
class Seam:
    """What lies between two panels of models side by side.

    Attributes
    ----------
    panels : (str, str)
        Of the one model's last strip, and of the next one's first.
    open, narrow, step : float
        How much wider than the joint it is at most, how much narrower (or overlapping), and how
        much higher the one panel lies than the other; mm.
    gap : float
        What the distance of the edges is off the joint's width, at most; mm.
    kink_own, kink_added : float
        Angle between the fitted panels across it, and what their made shapes add; degrees.
    length : float
        Along which they face each other, mm.
    """

    panels: tuple[str, str]
    open: float
    narrow: float
    step: float
    gap: float
    kink_own: float
    kink_added: float
    length: float


def seamed(design: Design) -> Design:
    """The design with neighbours across seams, and what lies between them."""
    seams = list(_seams(design))
    if not seams:
        return design
    across: dict[str, dict[str, Seam]] = {}
    for seam in sorted(seams, key=lambda seam: seam.length):  # the longest is told
        for mark, side in zip(seam.panels, ("second", "first"), strict=True):
            across.setdefault(mark, {})[side] = seam
    panels = tuple(
        replace(plate, shared={**plate.shared, **_beyond(plate.mark, across.get(plate.mark, {}))})
        for plate in design.panels
    )
    choices = dict(design.choices)
    for seam in seams:
        for mark, side in zip(seam.panels, ("second", "first"), strict=True):
            choices[mark] = _judged(choices[mark], seam, side)
    told, worth = _told(seams)
    return replace(
        design,
        panels=panels,
        choices=choices,
        worth={**design.worth, **worth},
        remarks=(*design.remarks, f"seams between {len(design.models)} models: {told}"),
    )


def _told(seams: Sequence[Seam]) -> tuple[str, dict[str, float]]:
    """The worst of all seams in words with their places, and as figures of the summary."""
    words, figures = [], {}
    for name, word in (("open", "wider than joints"), ("narrow", "narrower"), ("step", "of step")):
        worst = max(seams, key=lambda seam: getattr(seam, name))
        value = float(getattr(worst, name))
        figures[f"seam_{name}_max_mm"] = value
        words.append(f"at most {value:.2f} mm {word} ({' and '.join(worst.panels)})")
    return ", ".join(words), figures


def _beyond(mark: str, sides: Mapping[str, Seam]) -> dict[str, str]:
    return {side: next(m for m in seam.panels if m != mark) for side, seam in sides.items()}


def _judged(choice: PanelChoice, seam: Seam, side: str) -> PanelChoice:
    """The choice with a seam among its panel's gaps and kinks."""
    if seam.gap > choice.gap_mm:
        choice = replace(choice, gap_mm=seam.gap, gap_edge=side)
    if seam.kink_added > choice.kink_added_deg:
        choice = replace(choice, kink_added_deg=seam.kink_added, kink_edge=side)
    return replace(choice, kink_own_deg=max(choice.kink_own_deg, seam.kink_own))


def _seams(design: Design) -> Iterator[Seam]:
    """All pairs of panels that face each other across a seam."""
    joint = 0.0 if design.project.panels is None else design.project.panels.joint
    of_strip: dict[int, list[Plate]] = {}
    for patch, plate in zip(design.patches, design.panels, strict=False):
        of_strip.setdefault(patch.strip, []).append(plate)
    for before, after in pairwise(design.models):
        for one in of_strip.get(before.numbers[-1], ()):
            for other in of_strip.get(after.numbers[0], ()):
                fitted = (design.choices[one.mark].fitted, design.choices[other.mark].fitted)
                seam = between((one, other), fitted, joint)
                if seam is not None:
                    yield seam


def between(
    plates: tuple[Plate, Plate], fitted: tuple[RuledPatch, RuledPatch], joint: float
) -> Seam | None:
    """What lies between a panel's second edge and another's first; None if they do not face.

    Parameters
    ----------
    plates : two Plates
        As made.
    fitted : two RuledPatches
        Before they were replaced by simpler shapes: what kinks are compared with.
    joint : float
        Its width, mm.
    """
    one, other = (plate.mid for plate in plates)
    u = np.linspace(one.u0, one.u1, PLACES)
    ends = one.edges(u)
    w, inside = nearest(ends[1], other, 0)
    apart = other.edges(w)[0] - ends[1]
    normals = _normals(one, u), _normals(other, w)
    outwards = cross(unit(one.edges(u, 1)[1]), normals[0])  # square to the edge, in the panel
    outwards *= np.where(dot(outwards, ends[1] - ends[0]) < 0.0, -1.0, 1.0)[:, None]
    width = np.linalg.norm(apart, axis=1)
    inside &= width < joint + REACH
    if inside.sum() < LEAST:
        return None
    kink = _angle(*normals)
    own = _angle(_normals(fitted[0], u), _normals(fitted[1], w))
    level, wanted = dot(apart, outwards), joint * np.cos(kink / 2.0)
    off = (level - wanted)[inside]
    way = np.linalg.norm(np.diff(ends[1], axis=0), axis=1)
    return Seam(
        (plates[0].mark, plates[1].mark),
        open=float(off.max(initial=0.0)),
        narrow=float((-off).max(initial=0.0)),
        step=float(np.abs(dot(apart, normals[0]))[inside].max()),
        gap=float(np.abs(np.copysign(width, level) - wanted)[inside].max()),
        kink_own=float(np.degrees(own[inside].max())),
        kink_added=float(np.degrees(np.abs(kink - own)[inside].max())),
        length=float(way[inside[1:] & inside[:-1]].sum()),
    )


def nearest(points: Array, patch: RuledPatch, side: int) -> tuple[Array, BoolArray]:
    """Parameters (k,) of an edge's points nearest to points (k, 3), and which lie within its ends.

    `side` is 0 for the patch's first edge, 1 for its second.
    """
    u = np.linspace(patch.u0, patch.u1, 4 * PLACES)
    line = patch.edges(u)[side]
    at = u[np.argmin(np.linalg.norm(points[:, None] - line, axis=-1), axis=1)]
    for _ in range(STEPS):
        tangent = patch.edges(at, 1)[side]
        step = dot(points - patch.edges(at)[side], tangent) / dot(tangent, tangent)
        at = np.clip(at + step, patch.u0, patch.u1)
    return at, (at > patch.u0) & (at < patch.u1)


def _normals(patch: RuledPatch, u: Array) -> Array:
    """Unit normals (k, 3) at parameters, or at the patch's own ends where they lie beyond."""
    return ruled_normals(patch, np.clip(u, patch.u0, patch.u1))


def _angle(one: Array, other: Array) -> Array:
    """Angles between normals (k, 3), whatever side they are on; radians."""
    return np.arctan2(np.linalg.norm(cross(one, other), axis=1), np.abs(dot(one, other)))
