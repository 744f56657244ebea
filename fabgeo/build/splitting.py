"""Long parts divided at rulings until every piece fits its stock: ``[nesting] split = true``.

A panel becomes several panels, each with its own mark, shape, solid and joint: its patch is cut
before anything is chosen. A wall or a plate of a beam becomes pieces that meet edge to edge, or
leave the weld gap between them; fixings stay clear of the seams, as of the ends of beam segments.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from fabgeo.build.fitted import Fitted
from fabgeo.build.skin import plates_of
from fabgeo.errors import GeometryError
from fabgeo.panels.unfold_split import MOST_PIECES, cuts_to_fit, pieces_fit, split_to_fit
from fabgeo.project import Project
from fabgeo.strips.model import Patch
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures import panels as layers
from fabgeo.structures.parts import Beam, Plate

type Room = tuple[float, float]

SLACK = 5.0  # mm left around a panel: its made shape is not exactly the fitted one


def divided_patches(
    project: Project, models: Sequence[Fitted], patches: tuple[Patch, ...]
) -> tuple[Patch, ...]:
    """The patches cut at rulings so that the panels of every layer fit the largest of their sheets.

    Where there are cells, a cut runs through all strips. What no number of cuts helps, since its
    rulings are longer than every sheet is wide, stays: it is refused by name later.
    """
    if project.panels is None or project.nesting is None or not project.nesting.split:
        return patches
    leaves = [
        (leaf, rooms_of(project, leaf.material, leaf.thickness, SLACK)) for leaf in _layers(project)
    ]
    gross = [(plates_of(models, patches, leaf), rooms) for leaf, rooms in leaves]
    cuts = {
        patch: max(
            (_cuts(plates[k].mid, plates[k].mark, rooms) for plates, rooms in gross), key=len
        )
        for k, patch in enumerate(patches)
    }
    if project.cells:
        mids = {
            patch: [(plates[k].mid, rooms) for plates, rooms in gross]
            for k, patch in enumerate(patches)
        }
        cuts = _through(cuts, mids)
    rows: dict[int, list[tuple[float, float]]] = defaultdict(list)
    for patch in patches:
        rows[patch.strip] += pairwise([patch.u0, *cuts[patch], patch.u1])
    return tuple(
        Patch(strip, cell, float(low), float(high))
        for strip, spans in rows.items()
        for cell, (low, high) in enumerate(spans)
    )


def divided_structure(project: Project, made: dict[str, Any]) -> dict[str, Any]:
    """Walls and beams with every plate that is too long for its stock in pieces."""
    if project.nesting is None or not project.nesting.split:
        return made
    out = dict(made)
    gap = project.beams.weld_gap if project.beams else 0.0
    if "walls" in made:
        out["walls"] = tuple(piece for wall in made["walls"] for piece in pieces(project, wall))
    if "beams" in made:
        beams: Sequence[Beam] = made["beams"]
        out["beams"] = tuple(
            replace(b, plates=tuple(p for plate in b.plates for p in pieces(project, plate, gap)))
            for b in beams
        )
    return out


def pieces(project: Project, plate: Plate, gap: float = 0.0) -> tuple[Plate, ...]:
    """The plate, or its pieces from seam to seam: its mark with a, b, ... behind."""
    rooms = rooms_of(project, plate.material, plate.thickness)
    try:
        parts = split_to_fit(plate.mid, plate.mark, rooms, gap)
    except GeometryError:
        return (plate,)  # refused by name before anything is written
    if len(parts) == 1:
        return (plate,)
    marks, last = [mark for mark, _ in parts], len(parts) - 1
    out = []
    for k, (mark, mid) in enumerate(parts):
        shared = {side: plate.shared[side] for side in ("first", "second") if side in plate.shared}
        before = plate.shared.get("start") if k == 0 else marks[k - 1]
        behind = plate.shared.get("end") if k == last else marks[k + 1]
        shared |= {} if before is None else {"start": before}
        shared |= {} if behind is None else {"end": behind}
        bevel = (plate.bevel[0] if k == 0 else 0.0, plate.bevel[1] if k == last else 0.0)
        out.append(replace(plate, mark=mark, mid=mid, shared=shared, bevel=bevel))
    return tuple(out)


def rooms_of(project: Project, material: str, thickness: float, slack: float = 0.0) -> list[Room]:
    """Length along the part and width over it that the sheets of a stock leave between margins.

    The grain lies along a sheet's length; other parts may lie across the sheet too.
    """
    asked = project.nesting
    if asked is None:
        return []
    off = 2.0 * asked.margin + slack
    rooms = [(s.length - off, s.width - off) for s in project.stock_for(material, thickness)]
    if asked.rotations != "grain":
        rooms += [(width, length) for length, width in rooms]
    return [room for room in rooms if min(room) > 0.0]


def _layers(project: Project) -> list[layers.Layer]:
    asked = project.panels
    if asked is None:
        return []
    first = layers.Layer("panel", asked.offset, asked.thickness, asked.material)
    further = [
        layers.Layer(one.name, one.distance, one.thickness, one.material) for one in asked.layers
    ]
    return [first, *further]


def _cuts(mid: RuledPatch, mark: str, rooms: Sequence[Room]) -> tuple[float, ...]:
    try:
        return cuts_to_fit(mid, mark, rooms)
    except GeometryError:
        return ()


def _through(
    cuts: Mapping[Patch, tuple[float, ...]],
    mids: Mapping[Patch, Sequence[tuple[RuledPatch, Sequence[Room]]]],
) -> dict[Patch, tuple[float, ...]]:
    """The same cuts for all patches between the same rulings: as many as the longest needs."""
    bands: dict[tuple[float, float], list[Patch]] = defaultdict(list)
    for patch in cuts:
        bands[patch.u0, patch.u1].append(patch)
    out: dict[Patch, tuple[float, ...]] = {}
    for (u0, u1), band in bands.items():
        common = max((cuts[patch] for patch in band), key=len)
        while common and len(common) < MOST_PIECES:
            able = [patch for patch in band if cuts[patch] or all(
                pieces_fit(mid, (), rooms) for mid, rooms in mids[patch])]  # fmt: skip
            if all(pieces_fit(mid, common, rooms) for p in able for mid, rooms in mids[p]):
                break
            common = tuple(np.linspace(u0, u1, len(common) + 3)[1:-1].tolist())
        out |= dict.fromkeys(band, common)
    return out
