"""Rows of the schedules, from the parts and what was measured of them (handover.md)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.build.facts import Facts
from fabgeo.build.figures import Figures
from fabgeo.build.geometry import Design
from fabgeo.build.planks import plank_row
from fabgeo.build.skin import sheet_of
from fabgeo.build.slits import slit_rows
from fabgeo.build.solids import Built
from fabgeo.panels.classify import PanelChoice
from fabgeo.panels.flat import FlatPart
from fabgeo.panels.forming import beyond_standards
from fabgeo.project import Project
from fabgeo.review.verdicts import ORDER
from fabgeo.sheets.stock import Nest
from fabgeo.structures.boxes import Box
from fabgeo.structures.parts import Beam, Plate

type Row = dict[str, Any]
type Places = dict[str, tuple[str, float]]

CUBIC_METRE = 1e9
SQUARE_METRE = 1e6
PLAIN_RADIUS = 1e8  # mm: over 10 m it rises by 0.1 mm


def places_of(nests: list[Nest]) -> Places:
    """Mark to sheet (with its folder) and rotation in degrees."""
    return {
        p.mark: (f"{n.material}_{n.thickness:g}mm/{s.name}", float(np.degrees(p.rotation)))
        for n in nests
        for s in n.sheets
        for p in s.placements
    }


def panel_rows(
    design: Design,
    flats: Mapping[str, FlatPart],
    built: Mapping[str, Built],
    figures: Figures,
    places: Places,
    facts: Mapping[str, Facts],
) -> list[Row]:
    """One row a panel; none where the project asks for cells or beams alone."""
    if not design.panels:
        return []
    count: dict[str, int] = {}
    for connector in design.connectors:
        count[connector.panel] = count.get(connector.panel, 0) + 1
    order = erection_order(design)
    slits = {} if design.trims is None else slit_rows(design.trims.slits)
    rows, plates = [], {plate.mark: plate for plate in design.panels}
    last = {own.numbers[-1] for own in design.models if own.seams[1]}
    for patch, plate in zip(design.patches, design.panels, strict=True):
        choice = design.choices[plate.mark]
        row: Row = {
            "mark": plate.mark,
            "strip": patch.strip,
            "cell": patch.cell,
            **_choice_row(plate, choice, figures[plate.mark]),
            "connectors": count.get(plate.mark, 0) if design.connectors else None,
            "erection_order": order[plate.mark],
            "reason": choice.reason,
        }
        row = _joined(row, _plate_row(design.project, plate, flats, built, places, facts))
        row = _joined(row, _box_row(facts[plate.mark].box, design.project))
        row = _joined(row, slits.get(plate.mark, {}))
        flagged = beyond_standards(choice.cls, sheet_of(design.project, plate.material))
        if flagged:
            row = _joined(row, {"verdict": "warn", "reason": flagged})
        if plate.mark in design.complaints:
            verdict, reason = design.complaints[plate.mark]
            row = _joined(row, {"verdict": verdict, "reason": reason})
        flat = flats.get(plate.mark)
        if flat is not None:
            row["flat_length_mm"], row["flat_width_mm"] = row.pop("length_mm"), row.pop("width_mm")
            row["developability_mm"] = facts[plate.mark].developability_mm
            if design.models[0].model.kind == "geodesic":
                beyond = plate.shared.get("second", "")
                seam = patch.strip in last
                row |= plank_row((plate, flat), (plates.get(beyond), flats.get(beyond)), seam)
        rows.append(row)
    return rows


def _choice_row(plate: Plate, choice: PanelChoice, own: Mapping[str, float | None]) -> Row:
    """What a panel is made as, and how that meets the surface and its neighbours."""
    return {
        "class": choice.cls,
        "radius_min_mm": finite(choice.radius_min_mm),
        "radius_max_mm": finite(choice.radius_max_mm),
        "half_angle_deg": choice.half_angle_deg,
        "axis_or_apex": axis_text(choice.axis),
        "fit_deviation_mm": choice.bound_mm,
        "surface_deviation_mm": own.get("surface_deviation_mm"),
        "kink_max_deg": choice.kink_own_deg,
        "kink_added_deg": choice.kink_added_deg,
        "kink_edge": plate.shared.get(choice.kink_edge, choice.kink_edge),
        "gap_max_mm": choice.gap_mm,
        "gap_edge": plate.shared.get(choice.gap_edge, choice.gap_edge),
        "flange_mm": choice.flange_mm,
        "twist_max_deg": own.get("twist_max_deg"),
        "forming": choice.forming,
    }


def plate_rows(
    design: Design,
    flats: Mapping[str, FlatPart],
    built: Mapping[str, Built],
    places: Places,
    facts: Mapping[str, Facts],
) -> list[Row]:
    """One row a plate that is no panel."""
    rows = []
    for plate in design.plates[len(design.panels) :]:
        least, largest = facts[plate.mark].radii
        rows.append(
            {
                "mark": plate.mark,
                "parent": plate.parent,
                "role": plate.role,
                "radius_min_mm": bent(least),
                "radius_max_mm": bent(largest),
                "bevel_start_mm": plate.bevel[0] or None,
                "bevel_end_mm": plate.bevel[1] or None,
                "camber_mm": facts[plate.mark].camber,
                **_plate_row(design.project, plate, flats, built, places, facts),
            }
        )
    return rows


def cell_rows(design: Design, built: Mapping[str, Built], facts: Mapping[str, Facts]) -> list[Row]:
    """One row a cell; it is erected with its panel."""
    order = erection_order(design)
    rows = []
    for cell in design.cells:
        row: Row = {
            "mark": cell.mark,
            "strip": cell.patch.strip,
            "cell": cell.patch.cell,
            "erection_order": order.get(f"P-{cell.patch.tag}"),
            **_box_row(facts[cell.mark].box, design.project),
        }
        solid = built.get(cell.mark)
        if solid is not None and solid.report is not None:
            row["volume_m3"] = solid.report.volume / CUBIC_METRE
            row |= _centre(solid.report.centre)
        rows.append(row)
    return rows


def beam_rows(design: Design, built: Mapping[str, Built], facts: Mapping[str, Facts]) -> list[Row]:
    """One row a beam segment."""
    order = erection_order(design)
    rows = []
    for beam in design.beams:
        mass, centre = _mass(design.project, beam, built)
        rows.append(
            {
                "mark": beam.mark,
                "edge": beam.edge,
                "length_mm": beam.info.get("length"),
                "depth_min_mm": beam.info.get("depth_min"),
                "depth_max_mm": beam.info.get("depth_max"),
                "groove_deg": beam.info.get("bevel_deg"),
                "weld_gap_mm": beam.info.get("weld_gap"),
                "plates": len(beam.plates),
                "mass_kg": mass,
                **_centre(centre),
                "erection_order": order[beam.mark],
                **_box_row(facts[beam.mark].box, design.project),
            }
        )
    return rows


def erection_order(design: Design) -> dict[str, int]:
    """Place in the erection sequence of every beam segment and panel, strip by strip.

    Before a strip's panels come the beams of its two edges that do not stand yet, each from its
    start to its end; a strip's panels follow along it.
    """
    waiting = sorted(design.beams, key=lambda beam: (beam.edge, beam.u0))
    edges = sum(own.lanes.edges for own in design.models)  # several models carry no beams
    marks: list[str] = []
    for strip in range(design.models[-1].numbers.stop):
        near = {strip % edges, (strip + 1) % edges}
        marks += [beam.mark for beam in waiting if beam.edge in near]
        waiting = [beam for beam in waiting if beam.edge not in near]
        own = [patch for patch in design.patches if patch.strip == strip]
        if design.panels:
            marks += [f"P-{patch.tag}" for patch in sorted(own, key=lambda patch: patch.cell)]
    marks += [beam.mark for beam in waiting]
    return {mark: number for number, mark in enumerate(marks, 1)}


def _plate_row(
    project: Project,
    plate: Plate,
    flats: Mapping[str, FlatPart],
    built: Mapping[str, Built],
    places: Places,
    facts: Mapping[str, Facts],
) -> Row:
    row: Row = {
        "material": plate.material,
        "thickness_mm": plate.thickness,
        "holes": len(plate.holes),
    }
    flat = flats.get(plate.mark)
    if flat is not None:
        row["length_mm"], row["width_mm"] = facts[plate.mark].size
        row["area_m2"] = flat.area / SQUARE_METRE
    solid = built.get(plate.mark)
    if solid is not None and solid.report is not None:
        density = project.material(plate.material).density
        row["mass_kg"] = solid.report.volume / CUBIC_METRE * density
        row |= _centre(solid.report.centre)
    elif solid is not None:
        row |= {"verdict": "fail", "reason": solid.failure}
    if plate.mark in places:
        row["sheet"], row["sheet_rotation_deg"] = places[plate.mark]
    return row


def _box_row(box: Box, project: Project) -> Row:
    fits = box.fits(project.limits.transport_mm)
    keys = ("box_length_mm", "box_width_mm", "box_height_mm")
    row: Row = {key: float(v) for key, v in zip(keys, box.size, strict=True)}
    if fits:
        return {**row, "transport": "fits", "verdict": "good"}
    sizes = " x ".join(f"{v:.0f}" for v in box.size)
    limit = " x ".join(f"{v:g}" for v in project.limits.transport_mm)
    reason = f"its box of {sizes} mm is larger than the transport box of {limit} mm"
    return {**row, "transport": "too large", "verdict": "fail", "reason": reason}


def _joined(row: Row, more: Row) -> Row:
    """Both rows in one, with the worse verdict and all reasons, those for it first."""
    both = sorted((row, more), key=lambda r: -ORDER.index(r.get("verdict", "not asked")))
    worse = both[0].get("verdict", "not asked")
    reasons = [r["reason"] for r in both if r.get("reason")]
    return {**row, **more, "verdict": worse, "reason": "; ".join(reasons)}


def _centre(point: Array) -> Row:
    return {f"cog_{k}_mm": float(v) for k, v in zip("xyz", point, strict=True)}


def _mass(project: Project, beam: Beam, built: Mapping[str, Built]) -> tuple[float, Array]:
    """Mass and centre of gravity of the plates that could be built."""
    total, moment = 0.0, np.zeros(3)
    for plate in beam.plates:
        report = built[plate.mark].report
        if report is not None:
            mass = report.volume / CUBIC_METRE * project.material(plate.material).density
            total, moment = total + mass, moment + mass * report.centre
    return total, moment / max(total, 1e-300)


def axis_text(axis: Array | None) -> str:
    """Point (or apex) and direction as text: ``x y z; dx dy dz``."""
    if axis is None:
        return ""
    point, direction = np.asarray(axis)
    return " ".join(f"{v:.2f}" for v in point) + "; " + " ".join(f"{v:.8f}" for v in direction)


def bent(radius: float) -> float | None:
    """None for a radius that a plate of any length shows nothing of."""
    return float(radius) if radius < PLAIN_RADIUS else None


def finite(value: float) -> float | None:
    """None for an infinite radius: flat."""
    return float(value) if np.isfinite(value) else None
