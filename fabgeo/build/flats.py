"""The fourth stage: every plate unrolled with its certificate and contour, nested on stock."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from fabgeo.build.arguments import checked_jobs, checked_parts, checked_project
from fabgeo.build.cache import Cache
from fabgeo.build.identity import known_by, shape_of
from fabgeo.build.parallel import Work, results
from fabgeo.build.plain import digest
from fabgeo.build.progress import Clock
from fabgeo.errors import InputError, PartError
from fabgeo.panels.flat import FlatPart
from fabgeo.panels.unfold import unfold
from fabgeo.project import Project
from fabgeo.sheets.drawn import with_contour
from fabgeo.sheets.dxf_document import DxfStyle
from fabgeo.sheets.stock import Stock
from fabgeo.structures.parts import Plate


def flats_of(
    project: Project,
    plates: Sequence[Plate],
    jobs: int | None = None,
    clock: Clock | None = None,
    cache: Cache | None = None,
) -> dict[str, FlatPart]:
    """Flat parts by mark; plates lie with their outer side up.

    Raises
    ------
    InputError
        Naming the argument that is something else.
    PartError
        If a plate can't be unrolled.
    """
    project, jobs = checked_project(project), checked_jobs(jobs)
    plates, clock = checked_parts("plates", plates, Plate), clock or Clock()
    grain = project.nesting.rotations if project.nesting else "steps"
    kind, style = {"grain": "along"}.get(grain, grain), style_of(project)
    asked = (kind, style.outline, style.tolerance)
    origins = {plate.mark: digest(shape_of(plate), plate.shared, asked) for plate in plates}
    unfolded = partial(_unfolded, grain=kind, style=style)
    work = Work[Plate, FlatPart]("flat", unfolded, lambda plate: origins[plate.mark], _crashed)
    out = {}
    made = clock.each(results(work, plates, jobs, cache))
    for plate, flat in zip(plates, made, strict=True):
        out[plate.mark] = replace(flat, material=plate.material)  # a shape keeps its flat part
        known_by(out[plate.mark], origins[plate.mark], plate.material)
    return out


def style_of(project: Project) -> DxfStyle:
    """How the project wants its files written."""
    asked = project.cutting
    return DxfStyle(
        version=asked.version, outline=asked.curves, tolerance=asked.tolerance, layers=asked.layers
    )


def _crashed(plate: Plate, reason: str) -> FlatPart:
    raise PartError(plate.mark, f"could not be unrolled: {reason}", "please report it")


def _unfolded(plate: Plate, grain: str, style: DxfStyle) -> FlatPart:
    part = unfold(
        plate.mid,
        plate.mark,
        plate.material,
        plate.thickness,
        holes=plate.holes,
        shared=plate.shared,
        grain=grain,
    )
    return with_contour(part, style)


def stocks_of(project: Project, plates: Sequence[Plate]) -> list[Stock]:
    """Stock for every material and thickness in use.

    Raises
    ------
    InputError
        If there is none for one of them.
    """
    out = []
    for material, thickness in sorted({(p.material, p.thickness) for p in plates}):
        sheets = project.stock_for(material, thickness)
        if not sheets:
            raise InputError(
                "[[stock]]",
                f"holds no sheet of {material}, {thickness:g} mm",
                "add one, or leave its thickness out to mean any",
            )
        for sheet in sheets:
            name = sheet.name or f"{sheet.length:g}x{sheet.width:g}"
            out.append(
                Stock(
                    name, material, thickness, sheet.length, sheet.width, sheet.quantity, sheet.cost
                )
            )
    return out


def refuse_oversize(project: Project, plates: Sequence[Plate], flats: dict[str, FlatPart]) -> None:
    """Refuse a part that is larger than every sheet of its stock, before anything is written.

    Raises
    ------
    InputError
        Naming the largest such part, its size, and the largest sheet.
    """
    asked = project.nesting
    if asked is None:
        return
    stocks = stocks_of(project, plates)
    roles = {plate.mark: plate.role for plate in plates}
    for part in sorted(flats.values(), key=lambda part: -part.area):
        own = [s for s in stocks if (s.material, s.thickness) == (part.material, part.thickness)]
        length, width = np.ptp(np.concatenate([e.points for e in part.outline]), axis=0).tolist()
        rooms = [(s.length - 2 * asked.margin, s.width - 2 * asked.margin) for s in own]
        if not any(_holds(room, (length, width)) for room in rooms):
            largest = max(own, key=lambda s: s.length * s.width)
            if roles[part.mark] in ("web", "flange_inner", "flange_outer"):
                cure = "cut shorter segments by beams.cuts or limits.transport_mm"
            else:
                cure = "cut shorter or narrower panels"
            raise InputError(
                part.mark,
                f"is {length:.0f} x {width:.0f} mm flat, larger than every sheet of "
                f"{part.material} {part.thickness:g} mm (largest {largest.length:g} x "
                f"{largest.width:g} mm, margin {asked.margin:g})",
                cure
                + ("" if asked.split else ", set nesting.split = true")
                + ", or add a larger [[stock]]",
            )


def _holds(room: tuple[float, float], part: tuple[float, float]) -> bool:
    """Whether a rectangle fits into another, turned as it likes (Carver 1957)."""
    a, b = max(room), min(room)
    p, q = max(part), min(part)
    if p <= a and q <= b:
        return True
    if p <= a or q > b or min(room) <= 0.0:
        return False
    return b * (p * p + q * q) >= 2 * p * q * a + (p * p - q * q) * math.sqrt(p * p + q * q - a * a)
