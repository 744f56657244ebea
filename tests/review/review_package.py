"""A whole written package of the synthetic roof, for the check to measure."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from review_synthetic import RADIUS, patch

from fabgeo.arrays import unit
from fabgeo.panels.flat import FlatPart
from fabgeo.panels.unfold import unfold
from fabgeo.review.record import Limit, ReviewRecord, SetoutPoint
from fabgeo.sheets.stock import Nest, Placement, Sheet, Stock
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Hole, Plate
from fabgeo.structures.prisms import plate_prism, prism_properties, ruled_normals

JOINT, THICKNESS, DENSITY = 10.0, 3.0, 7850.0


def net_patch(i: int, j: int, strips: int, cells: int) -> RuledPatch:
    """A panel with half of the joint taken off along its rulings' direction and at its ends."""
    full = patch(i, j, strips, cells)
    way = unit(full.poles[1, 0] - full.poles[0, 0])
    take = 0.5 * JOINT * way
    shrink = 0.5 * JOINT / RADIUS
    u = np.linspace(full.u0 + shrink, full.u1 - shrink, 7)
    from scipy.interpolate import make_interp_spline

    a, b = full.edges(u)
    curve = make_interp_spline(u, np.concatenate([a + take, b - take], axis=1), k=3)
    poles = np.asarray(curve.c)
    return RuledPatch(curve.t, np.stack([poles[:, :3], poles[:, 3:]]))


def plates(strips: int, cells: int) -> list[Plate]:
    """All panels, each with one round hole and one slot."""
    made = []
    for i in range(strips):
        for j in range(cells):
            mid = net_patch(i, j, strips, cells)
            u = np.array([0.5 * (mid.u0 + mid.u1), 0.7 * mid.u0 + 0.3 * mid.u1])
            at = mid.points(u, np.array([0.5, 0.2]))
            t, v = mid.edges(u, 1)[0], mid.edges(u)[1] - mid.edges(u)[0]
            axes = unit(np.cross(t, v))
            holes = (
                Hole(at[0], axes[0], 18.0),
                Hole(at[1], axes[1], 14.0, 20.0, unit(v[1])),
            )
            mark = f"P-{i:02d}-{j:02d}"
            made.append(Plate(mark, mark, "panel", mid, THICKNESS, "steel", holes))
    return made


def write_package(folder: Path, strips: int = 3, cells: int = 3) -> ReviewRecord:
    """Write the package and return its record."""
    from fabgeo.cad.assembly import CLASS_COLOURS, Node
    from fabgeo.cad.plates import plate_solid
    from fabgeo.cad.step import write_step
    from fabgeo.review.manifest import write_manifest
    from fabgeo.review.schedules import write_schedules
    from fabgeo.review.verdicts import write_review
    from fabgeo.sheets.dxf import write_nests, write_parts

    parts = plates(strips, cells)
    flats = {p.mark: _unfold(p) for p in parts}
    nest = _nest(flats)
    record = _record(parts, flats, nest, strips)
    nodes = [
        Node(p.mark, plate_solid(p), colour=CLASS_COLOURS["cylinder"], layer="panels")
        for p in parts
    ]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "model").mkdir(exist_ok=True)
    write_step(
        folder / "model" / "facade.step",
        Node("roof", children=(Node("panels", children=tuple(nodes)),)),
    )
    made = write_parts(list(flats.values()), folder / "cut" / "parts")
    write_nests([nest], made, folder / "cut" / "nests")
    write_schedules(folder, record)
    write_review(folder / "checks" / "review.json", record)
    write_manifest(
        folder,
        name="roof",
        project={
            "panels": {"joint": JOINT, "thickness": THICKNESS, "tolerance": 1.0},
            "nesting": {"spacing": nest.spacing, "margin": nest.margin},
            "cutting": {"tolerance": 0.05},
        },
        versions={"fabgeo": "0.1.0"},
        seconds={},
        not_asked=("cells", "beams", "connectors", "drawings"),
    )
    return record


def _unfold(plate: Plate) -> FlatPart:
    """Up-side outwards: away from the axis of the roof's arc."""
    middle = plate.mid.points(np.array([0.5 * (plate.mid.u0 + plate.mid.u1)]), np.array([0.5]))
    a, b = plate.mid.edges(np.array([plate.mid.u0]))
    normal = np.cross(plate.mid.edges(np.array([plate.mid.u0]), 1)[0, 0], (b - a)[0])
    side = 1 if normal @ middle[0] > 0 else -1
    return unfold(plate.mid, plate.mark, plate.material, plate.thickness, plate.holes, side=side)


def _nest(flats: dict[str, FlatPart]) -> Nest:
    """Parts above each other, as many as a sheet takes."""
    stock = Stock("big", "steel", THICKNESS, 13_000.0, 8_000.0)
    sheets: list[tuple[list[Placement], float]] = []
    y = np.inf
    for mark, part in flats.items():
        points = np.concatenate([edge.points for edge in part.outline])
        low, high = points.min(axis=0), points.max(axis=0)
        if y + high[1] - low[1] + 10.0 > stock.width:
            sheets.append(([], 0.0))
            y = 12.0
        places, used = sheets[-1]
        places.append(Placement(mark, 12.0 - low[0], y - low[1], 0.0))
        sheets[-1] = (places, used + part.area)
        y += high[1] - low[1] + 8.0
    whole = stock.length * stock.width
    made = tuple(
        Sheet(f"SHEET-{k + 1:03d}", stock, tuple(places), used / whole)
        for k, (places, used) in enumerate(sheets)
    )
    return Nest(
        "steel", THICKNESS, made, {}, sum(u for _, u in sheets) / whole / len(made), 6.0, 10.0
    )


def _record(
    parts: list[Plate], flats: dict[str, FlatPart], nest: Nest, strips: int
) -> ReviewRecord:
    sheet_of = {p.mark: s.name for s in nest.sheets for p in s.placements}
    rows, figures, setout = [], {}, []
    for plate in parts:
        part = flats[plate.mark]
        points = np.concatenate([edge.points for edge in part.outline])
        size = np.ptp(points, axis=0)
        centre = prism_properties(plate_prism(plate)).centre
        radii = [abs(b.radius) for b in part.bends]
        figures[plate.mark] = {
            key: float(part.certificate[key])
            for key in ("edge_length_error_mm", "area_error_rel", "refold_error_mm")
        }
        ends = np.array([plate.mid.u0, plate.mid.u1])
        corners, normals = plate.mid.edges(ends), ruled_normals(plate.mid, ends)
        for number, (side, end) in enumerate(((0, 0), (0, 1), (1, 1), (1, 0)), 1):
            point, place = f"{plate.mark}/{number}", corners[side, end]
            setout.append(SetoutPoint(point, place, normals[end], "panel corner", plate.mark))
        rows.append(
            {
                "mark": plate.mark,
                "strip": int(plate.mark[2:4]),
                "cell": int(plate.mark[5:7]),
                "class": "cylinder",
                "radius_min_mm": min(radii),
                "radius_max_mm": max(radii),
                "material": plate.material,
                "thickness_mm": plate.thickness,
                "flat_length_mm": float(size[0]),
                "flat_width_mm": float(size[1]),
                "area_m2": part.area / 1e6,
                "mass_kg": part.area * plate.thickness * DENSITY * 1e-9,
                "cog_x_mm": float(centre[0]),
                "cog_y_mm": float(centre[1]),
                "cog_z_mm": float(centre[2]),
                "holes": len(part.holes),
                "sheet": sheet_of[plate.mark],
                "forming": "spring",
            }
        )
    return replace(
        ReviewRecord("roof", version="0.1.0"),
        panels=tuple(rows),
        flats=flats,
        nests=(nest,),
        setout=tuple(setout),
        limits=(Limit("edge_length_error_mm", 0.02), Limit("refold_error_mm", 0.05)),
        figures=figures,
        summary={
            "solids": len(parts),
            "invalid_solids": 0,
            "utilisation": nest.utilisation,
            "unplaced_parts": 0,
            "area_error_rel": max(f["area_error_rel"] for f in figures.values()),
        },
    )
