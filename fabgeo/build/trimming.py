"""Panels of an overhanging model, cut along the boundary of the design surface.

A cut panel stays a ruled patch on the shape that it is made as: its rulings are parts of the old
ones, its long edges run along the boundary where the model overhangs. Where the boundary enters a
panel across one of its long edges, the panel is parted at the ruling there, so that no edge has a
corner: the further piece of ``P-03-05`` on a strip of 6 cells is ``P-03-11``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fabgeo.arrays import cross
from fabgeo.build.skin import sheet_of
from fabgeo.build.slits import Slit, slits_of
from fabgeo.panels.forming import forming_of
from fabgeo.panels.samples import PanelInput, Side
from fabgeo.panels.unfold_split import split_at_rulings
from fabgeo.strips.fence import Fence
from fabgeo.strips.model import Patch
from fabgeo.strips.ruled import RuledPatch
from fabgeo.strips.trim import Piece, Rules, trimmed_ruled
from fabgeo.structures.beams import plate_radii
from fabgeo.structures.parts import Plate

if TYPE_CHECKING:
    from fabgeo.build.geometry import Design
    from fabgeo.fitting.starts import Start
    from fabgeo.panels.classify import PanelChoice
    from fabgeo.project import Project

SHORTEST = 20.0  # mm: a cut panel's tip ends where its rulings get shorter
LEAST_LENGTH = 80.0  # mm: a cut panel shorter than this along its strip is dropped

FACING: Mapping[Side, Side] = {
    "first": "second",
    "second": "first",
    "start": "end",
    "end": "start",
}


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
        Marks of panels of which pieces were too small to make.
    lost : float
        Area in mm2 inside the boundary that no panel covers any more: tips, slivers, and the
        joints between pieces of one panel.
    slits : tuple of Slit
        Between panels that a piece too small to make lay between.
    """

    cut: tuple[str, ...] = ()
    outside: tuple[str, ...] = ()
    slivers: tuple[str, ...] = ()
    lost: float = 0.0
    slits: tuple[Slit, ...] = ()

    def __str__(self) -> str:
        words = (
            f"{len(self.cut)} panels are cut along the boundary, {len(self.outside)} lie wholly "
            f"beyond it, {len(self.slivers)} have pieces too small to make; tips, these pieces and "
            f"joints between pieces leave {self.lost / 1e6:.3g} m2 open"
        )
        if not self.slits:
            return words
        widest = max(self.slits, key=lambda slit: slit.width)
        between = " and ".join(widest.panels)
        return f"{words}; slits of up to {widest.width:.0f} mm, that between {between}"


@dataclass(frozen=True)
class Cut:
    """One piece of a plate: itself as a plate with its patch, and how it was cut.

    Attributes
    ----------
    patch : Patch
    plate : Plate
    piece : Piece
    whole : Plate
        The plate before.
    """

    patch: Patch
    plate: Plate
    piece: Piece
    whole: Plate

    def at(self, side: Side) -> tuple[float, float] | None:
        """The part of the whole plate's side that is left: in u, at its ends in v."""
        mid, own = self.whole.mid, self.piece.ruled
        if side in ("first", "second"):
            return None if self.piece.cut[side == "second"] else (own.u0, own.u1)
        if side == "start":
            return self.piece.ends[0] if own.u0 == mid.u0 else None
        return self.piece.ends[1] if own.u1 == mid.u1 else None


def trims_panels(project: Project, starts: Sequence[Start]) -> bool:
    """Whether the panels are to be cut along the boundary of the surface."""
    asked = project.panels
    if asked is None or asked.trim is False:
        return False
    below = project.cells is not None or project.beams is not None
    return any(start.overhangs for start in starts) and (asked.trim is True or not below)


def trimmed(design: Design) -> Design:
    """The design with its panels and further layers cut along the overhung boundary.

    Its patches are those of the panels that are left, in their order.
    """
    fences = [Fence(design.surface, own.model) for own in design.models]
    if not any(fence.loops for fence in fences):
        return design
    panels, first = _on_models(design, design.panels, fences)
    own: list[Plate] = []
    trims = [first]
    count = len(design.patches)
    for k in range(0, len(design.layers), count):
        layer, further = _on_models(design, design.layers[k : k + count], fences)
        own += [cut.plate for cut in layer]
        trims.append(further)
    return replace(
        design,
        patches=tuple(cut.patch for cut in panels),
        panels=tuple(cut.plate for cut in panels),
        layers=tuple(own),
        choices=_choices(design, panels),
        trims=replace(_joined(trims), slits=slits_of(_pieces(panels))),
    )


def _on_models(
    design: Design, plates: Sequence[Plate], fences: Sequence[Fence]
) -> tuple[list[Cut], Trims]:
    """Plates (one a patch of the design), those of each model cut along its fence."""
    joint = 0.0 if design.project.panels is None else design.project.panels.joint
    cuts: list[Cut] = []
    trims = []
    for model, fence in zip(design.models, fences, strict=True):
        on_it = model.own(design.patches)
        own = [design.patches[k] for k in on_it]
        kept, found = trim_plates(own, [plates[k] for k in on_it], fence, joint)
        cuts += kept
        trims.append(found)
    return cuts, _joined(trims)


def _choices(design: Design, panels: Sequence[Cut]) -> dict[str, PanelChoice]:
    """The choices of what is left: radii, forming, gaps and kinks of the panels as cut."""
    from fabgeo.panels.remeasured import measured_again

    across = _neighbours(panels)
    choices, inputs = [], []
    for cut in panels:
        choice = replace(design.choices[cut.whole.mark], mark=cut.plate.mark)
        if cut.plate.mid is not cut.whole.mid and choice.cls in ("cone", "developable"):
            least, largest = plate_radii(cut.plate.mid)
            forming, _ = forming_of(choice.cls, least, sheet_of(design.project))
            choice = replace(choice, radius_min_mm=least, radius_max_mm=largest, forming=forming)
        choices.append(choice)
        beyond: dict[Side, str | tuple[str, ...]] = {
            side: tuple(marks) for side, marks in across[cut.plate.mark].items()
        }
        inputs.append(PanelInput(cut.plate.mark, _gross(choice.fitted, cut), beyond))
    return {choice.mark: choice for choice in measured_again(choices, inputs)}


def _gross(fitted: RuledPatch, cut: Cut) -> RuledPatch:
    """What the piece's rulings span of the fitted panel, its joints to others not taken off.

    Its ends are the whole rulings: a made panel's ends are found on these, cut or not.
    """
    mid, own = cut.whole.mid, cut.piece.ruled
    low = fitted.u0 if own.u0 == mid.u0 else own.u0
    high = fitted.u1 if own.u1 == mid.u1 else own.u1
    cuts = [u for u in (low, high) if fitted.u0 < u < fitted.u1]
    parts = split_at_rulings(fitted, np.array(cuts))
    return next(p for p in parts if p.u0 <= (low + high) / 2.0 <= p.u1)


def trim_plates(
    patches: Sequence[Patch], plates: Sequence[Plate], fence: Fence, joint: float
) -> tuple[list[Cut], Trims]:
    """Plates (one a patch) cut along the fence; whole ones stay as they are."""
    kept: list[Cut] = []
    cut, outside, slivers = [], [], []
    lost, cells = 0.0, _cells(patches)
    rules = Rules(joint, SHORTEST, LEAST_LENGTH)
    for patch, plate in zip(patches, plates, strict=True):
        found = trimmed_ruled(plate.mid, fence, fence.corners, rules, plate.mark)
        if found.whole:
            kept.append(Cut(patch, plate, found.pieces[0], plate))
            continue
        lost += found.inside - sum(area(piece.ruled) for piece in found.pieces)
        if found.dropped:
            slivers.append(plate.mark)
        (cut if found.pieces else outside).append(plate.mark)
        for k, piece in enumerate(found.pieces):
            u0, u1 = piece.ruled.u0, piece.ruled.u1
            own = Patch(patch.strip, patch.cell + k * cells[patch.strip], u0, u1)
            mark = plate.mark.replace(patch.mark, own.mark)
            made = replace(plate, mark=mark, parent=mark, mid=piece.ruled)
            kept.append(Cut(own, made, piece, plate))
    across = _neighbours(kept)
    pieces = _pieces(kept)
    linked = []
    for one in kept:
        shared: dict[str, str] = {
            side: marks[0] for side, marks in across[one.plate.mark].items() if marks
        } | _beside(one, pieces[one.whole.mark])
        linked.append(replace(one, plate=replace(one.plate, shared=shared)))
    return linked, Trims(tuple(cut), tuple(outside), tuple(slivers), lost)


def _pieces(cuts: Sequence[Cut]) -> dict[str, list[Cut]]:
    out: dict[str, list[Cut]] = {}
    for cut in cuts:
        out.setdefault(cut.whole.mark, []).append(cut)
    return out


def _neighbours(cuts: Sequence[Cut]) -> dict[str, dict[Side, list[str]]]:
    """Marks of the pieces of other plates across every piece's sides, longest common edge first."""
    pieces = _pieces(cuts)
    out: dict[str, dict[Side, list[str]]] = {}
    for cut in cuts:
        own = out.setdefault(cut.plate.mark, {})
        for side, facing in FACING.items():
            here = cut.at(side)
            if here is None:
                continue
            found = []
            for other in pieces.get(cut.whole.shared.get(side, ""), ()):
                there = other.at(facing)
                if there is not None:
                    common = min(here[1], there[1]) - max(here[0], there[0])
                    found.append((common, other.plate.mark))
            least = 1e-6 * (here[1] - here[0])
            marks = [mark for common, mark in sorted(found, reverse=True) if common > least]
            if marks:
                own[side] = marks
    return out


def _beside(one: Cut, pieces: Sequence[Cut]) -> dict[str, str]:
    """Marks of the pieces of the same plate beyond its first and its last ruling."""
    out = {}
    sides = (("start", 0, 1), ("end", 1, 0))
    for side, here, there in sides:
        if not one.piece.joined[here]:
            continue
        at, span = one.piece.breaks[here], one.piece.ends[here]
        for other in pieces:
            ends = other.piece.ends[there]
            common = min(span[1], ends[1]) - max(span[0], ends[0])
            if other is not one and other.piece.breaks[there] == at and common > 0.0:
                out[side] = other.plate.mark
    return out


def _cells(patches: Sequence[Patch]) -> dict[int, int]:
    """One more than the last cell's number of every strip."""
    out: dict[int, int] = {}
    for patch in patches:
        out[patch.strip] = max(out.get(patch.strip, 0), patch.cell + 1)
    return out


def _joined(trims: Sequence[Trims]) -> Trims:
    """The trims of several models, or layers, as one."""
    return Trims(
        tuple(m for t in trims for m in t.cut),
        tuple(m for t in trims for m in t.outside),
        tuple(m for t in trims for m in t.slivers),
        sum(t.lost for t in trims),
    )


def area(mid: RuledPatch) -> float:
    """Area in mm2, by quads."""
    first, second = mid.edges(mid.parameters(16))
    a, b = second[1:] - first[:-1], second[:-1] - first[1:]
    return float(np.linalg.norm(cross(a, b), axis=1).sum() / 2.0)
