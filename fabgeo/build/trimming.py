"""Panels of an overhanging model, cut along the boundary of the design surface.

A cut panel stays a ruled patch on the shape that it is made as: its rulings are parts of the old
ones, its long edges run along the boundary where the model overhangs. Its neighbours along the
strip meet it at rulings, as everywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fabgeo.arrays import cross, dot, unit
from fabgeo.panels.forming import forming_of
from fabgeo.panels.unfold_split import split_at_rulings
from fabgeo.strips.model import Patch
from fabgeo.strips.ruled import RuledPatch
from fabgeo.strips.trim import Fence, trimmed_ruled
from fabgeo.structures.beams import plate_radii
from fabgeo.structures.parts import Plate

if TYPE_CHECKING:
    from fabgeo.build.geometry import Design
    from fabgeo.fitting.starts import Start
    from fabgeo.panels.classify import PanelChoice
    from fabgeo.project import Project

SHORTEST = 150.0  # mm: a cut panel ends where its rulings get shorter
LEAST_LENGTH = 150.0  # mm: a cut panel shorter than this along its strip is dropped


@dataclass(frozen=True)
class Trims:
    """What cutting along the boundary did to the panels.

    Attributes
    ----------
    cut : tuple of str
        Marks of panels that lost a part.
    outside : tuple of str
        Marks of patches wholly beyond the boundary: no panels.
    slivers : tuple of str
        Marks of panels whose rest was too small to make.
    lost : float
        Area in mm2 inside the boundary that no panel covers any more: tips and slivers.
    """

    cut: tuple[str, ...] = ()
    outside: tuple[str, ...] = ()
    slivers: tuple[str, ...] = ()
    lost: float = 0.0

    @property
    def dropped(self) -> frozenset[str]:
        """Marks of all panels that are gone."""
        return frozenset(self.outside) | frozenset(self.slivers)

    def __str__(self) -> str:
        return (
            f"{len(self.cut)} panels are cut along the boundary, {len(self.outside)} lie wholly "
            f"beyond it, {len(self.slivers)} rests are too small to make; tips and rests leave "
            f"{self.lost / 1e6:.2f} m2 open"
        )


def trims_panels(project: Project, start: Start) -> bool:
    """Whether the panels are to be cut along the boundary of the surface."""
    asked = project.panels
    if asked is None or asked.trim is False:
        return False
    below = project.cells is not None or project.beams is not None
    return start.overhangs and (asked.trim is True or not below)


def trimmed(design: Design) -> Design:
    """The design with its panels and further layers cut along the overhung boundary.

    Its patches are those of the panels that are left, in their order.
    """
    fence = Fence(design.surface, design.model)
    if not fence.loops or design.project.panels is None:
        return design
    joint, patches = design.project.panels.joint, design.patches
    panels, first = trim_plates(patches, design.panels, fence, joint)
    own: list[Plate] = []
    trims = [first]
    for k in range(0, len(design.layers), len(patches)):
        layer, further = trim_plates(patches, design.layers[k : k + len(patches)], fence, joint)
        own += [plate for _, plate in layer]
        trims.append(further)
    cells = _cells(patches)
    choices, whole = {}, {plate.mark: plate for plate in design.panels}
    for patch, plate in panels:
        old = Patch(patch.strip, patch.cell % cells[patch.strip], patch.u0, patch.u1).mark
        choice = replace(design.choices[old], mark=plate.mark)
        cut = plate.mid is not whole[old].mid
        choices[plate.mark] = _remade(choice, plate, design.project) if cut else choice
    return replace(
        design,
        patches=tuple(patch for patch, _ in panels),
        panels=tuple(plate for _, plate in panels),
        layers=tuple(own),
        choices=choices,
        trims=joined(trims),
    )


def _remade(choice: PanelChoice, plate: Plate, project: Project) -> PanelChoice:
    """The choice with radii and forming of what is left of its panel."""
    from fabgeo.build.geometry import sheet_of

    if choice.cls == "flat":
        return choice
    least, largest = plate_radii(plate.mid)
    forming, _ = forming_of(choice.cls, least, sheet_of(project))
    return replace(choice, radius_min_mm=least, radius_max_mm=largest, forming=forming)


def trim_plates(
    patches: Sequence[Patch], plates: Sequence[Plate], fence: Fence, joint: float
) -> tuple[list[tuple[Patch, Plate]], Trims]:
    """Plates (one a patch) cut along the fence with their patches; whole ones stay as they are.

    Where the boundary enters a panel across one of its long edges, the panel is parted at the
    ruling there, so that no edge has a corner: the further piece of ``P-03-05`` on a strip of 6
    cells is ``P-03-11``.
    """
    kept: list[tuple[Patch, Plate]] = []
    cut, outside, slivers = [], [], []
    lost, cells = 0.0, _cells(patches)
    for patch, plate in zip(patches, plates, strict=True):
        mid = plate.mid
        first, second = mid.edges(mid.parameters(4))
        width = float(np.linalg.norm(second - first, axis=-1).mean())
        segments = float(len(np.unique(mid.knots)) - 1)
        found = trimmed_ruled(mid, fence, min(SHORTEST / width, 0.5), segments)
        if found is None:
            outside.append(plate.mark)
            continue
        if found.whole:
            kept.append((patch, plate))
            continue
        cut.append(plate.mark)
        lost += found.lost
        made = []
        for k, piece in enumerate(_parted(found.ruled, joint)):
            own = Patch(patch.strip, patch.cell + k * cells[patch.strip], piece.u0, piece.u1)
            mark = plate.mark.replace(patch.mark, own.mark)
            if length(piece) < LEAST_LENGTH:
                slivers.append(mark)
                lost += area(piece)
            else:
                made.append((own, replace(plate, mark=mark, parent=mark, mid=piece)))
        kept += _linked(made)
    gone = frozenset(outside) | frozenset(slivers)
    trims = Trims(tuple(cut), tuple(outside), tuple(slivers), lost)
    return [(patch, without(plate, gone)) for patch, plate in kept], trims


def _cells(patches: Sequence[Patch]) -> dict[int, int]:
    """One more than the last cell's number of every strip."""
    out: dict[int, int] = {}
    for patch in patches:
        out[patch.strip] = max(out.get(patch.strip, 0), patch.cell + 1)
    return out


def _parted(ruled: RuledPatch, joint: float) -> list[RuledPatch]:
    """The trimmed patch parted at its corners (threefold knots), the joint taken off there."""
    knots, counts = np.unique(ruled.knots, return_counts=True)
    intervals, low = [], ruled.u0
    for u in knots[1:-1][counts[1:-1] >= 3]:
        step = joint / 2.0 / _pace(ruled, float(u))
        intervals.append((low, float(u) - step))
        low = max(low, float(u) + step)
    intervals.append((low, ruled.u1))
    least = 1e-9 * (ruled.u1 - ruled.u0)
    kept = [(a, b) for a, b in intervals if b - a > least]
    cuts = {u for ends in kept for u in ends if ruled.u0 < u < ruled.u1}
    pieces = split_at_rulings(ruled, np.array(sorted(cuts)))
    return [p for p in pieces if any(a < (p.u0 + p.u1) / 2.0 < b for a, b in kept)]


def _pace(mid: RuledPatch, u: float) -> float:
    """The slower of both edges' speeds across the ruling at u."""
    at = np.array([u])
    e = unit(mid.edges(at)[1] - mid.edges(at)[0])
    velocity = mid.edges(at, 1)
    return float(np.linalg.norm(velocity - dot(velocity, e)[..., None] * e, axis=-1).min())


def _linked(pieces: list[tuple[Patch, Plate]]) -> list[tuple[Patch, Plate]]:
    """Pieces of one plate, each the next one's neighbour."""
    out = []
    for k, (patch, plate) in enumerate(pieces):
        shared = dict(plate.shared)
        if k > 0:
            shared["start"] = pieces[k - 1][1].mark
        if k < len(pieces) - 1:
            shared["end"] = pieces[k + 1][1].mark
        out.append((patch, replace(plate, shared=shared)))
    return out


def without(plate: Plate, gone: frozenset[str]) -> Plate:
    """The plate with no neighbours among the marks that are gone."""
    shared = {side: mark for side, mark in plate.shared.items() if mark not in gone}
    return plate if len(shared) == len(plate.shared) else replace(plate, shared=shared)


def joined(trims: Sequence[Trims]) -> Trims:
    """Several layers' trims as one."""
    return Trims(
        tuple(m for t in trims for m in t.cut),
        tuple(m for t in trims for m in t.outside),
        tuple(m for t in trims for m in t.slivers),
        sum(t.lost for t in trims),
    )


def length(mid: RuledPatch) -> float:
    """Length in mm of the patch's middle line."""
    return float(
        np.linalg.norm(np.diff(mid.edges(mid.parameters(8)).mean(axis=0), axis=0), axis=1).sum()
    )


def area(mid: RuledPatch) -> float:
    """Area in mm2, by quads."""
    first, second = mid.edges(mid.parameters(8))
    a, b = second[1:] - first[:-1], second[:-1] - first[1:]
    return float(np.linalg.norm(cross(a, b), axis=1).sum() / 2.0)
