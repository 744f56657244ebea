"""A roof of translational strips in closed form: p_i(u) = p(u) + s_i, so every strip is a cylinder.

p(u) is an arc of a circle in the x-z plane, s_i a polygon in the y-z plane: the strip between
p + s_i and p + s_(i+1) is a general cylinder with rulings s_(i+1) - s_i, whose development is
known: along the rulings the coordinate is p . t, across them the arc length of p's projection
along t.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import make_interp_spline

from fabgeo.arrays import Array, unit
from fabgeo.panels.flat import BendLine, FlatEdge, FlatHole, FlatPart
from fabgeo.review.display import facing, shown_plate
from fabgeo.review.record import (
    DeviationMap,
    Limit,
    ReviewRecord,
    SetoutPoint,
    Shown,
    ShownConnector,
)
from fabgeo.sheets.stock import Nest, Placement, Sheet, Stock
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Plate
from fabgeo.structures.prisms import ruled_normals

RADIUS = 30_000.0


def shifts(strips: int, width: float = 1500.0) -> Array:
    """The polygon s_i: a parabola's chord in the y-z plane."""
    y = width * (np.arange(strips + 1) - strips / 2)
    return np.stack([0.0 * y, y, -(y**2) / 40_000.0], axis=1)


def patch(i: int, j: int, strips: int, cells: int, angle: float = 1.2) -> RuledPatch:
    """Panel j of strip i as an exact ruled patch (its edges interpolate the circle)."""
    step = angle / cells
    u = -angle / 2 + step * (j + np.linspace(0.0, 1.0, 7))
    points = RADIUS * np.stack([np.sin(u), 0.0 * u, np.cos(u)], axis=1)
    curve = make_interp_spline(u, points, k=3)
    s = shifts(strips)[[i, i + 1]]
    return RuledPatch(curve.t, np.asarray(curve.c)[None] + s[:, None])


def flat(mark: str, ruled: RuledPatch, thickness: float = 3.0) -> FlatPart:
    """The development of a translational patch, by quadrature of |p' - (p' . t) t|."""
    fine = np.linspace(ruled.u0, ruled.u1, 801)
    a, b = ruled.edges(fine)
    t = unit(b[0] - a[0])
    tangent = ruled.edges(fine, 1)[0]
    speed = np.linalg.norm(tangent - (tangent @ t)[:, None] * t, axis=1)
    x = np.append(0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(fine)))
    x *= 1.0
    keep = np.arange(0, 801, 25)
    lower = np.stack([x, (a - a[0]) @ t], axis=1)
    upper = np.stack([x, (b - a[0]) @ t], axis=1)
    slope = (tangent @ t) / speed
    directions = unit(np.stack([np.ones_like(x), slope], axis=1))
    arc = np.append(
        0.0, np.cumsum(np.linalg.norm(0.5 * (tangent[1:] + tangent[:-1]), axis=1) * np.diff(fine))
    )
    edges = (
        FlatEdge("first", lower[keep], directions[keep], arc[keep]),
        _straight("end", lower[-1], upper[-1]),
        FlatEdge("second", upper[keep][::-1], -directions[keep][::-1], arc[-1] - arc[keep][::-1]),
        _straight("start", upper[0], lower[0]),
    )
    refold = np.stack([np.hstack([lower[keep], a[keep]]), np.hstack([upper[keep], b[keep]])], 1)
    bends = tuple(BendLine(lower[k], upper[k], -RADIUS) for k in range(50, 800, 75))
    width = float(np.linalg.norm(b[0] - a[0]))
    hole = FlatHole(0.5 * (lower[400] + upper[400]), 18.0)
    slot = FlatHole(lower[100] + np.array([60.0, 90.0]), 14.0, 20.0, 0.3)
    return FlatPart(
        mark,
        "S355",
        thickness,
        edges,
        (hole, slot),
        bends,
        float(x[-1] * width),
        refold=refold,
        certificate={"edge_length_error_mm": 1e-6, "area_error_rel": 1e-9, "refold_error_mm": 1e-6},
    )


def _straight(name: str, start: Array, end: Array) -> FlatEdge:
    way = end - start
    length = float(np.linalg.norm(way))
    return FlatEdge(
        name, np.stack([start, end]), np.stack([way, way]) / length, np.array([0.0, length])
    )


def record(strips: int = 6, cells: int = 4, name: str = "Barrel <b>roof</b>") -> ReviewRecord:
    """A whole record: figures are made up but consistent, so that every reader has work to do."""
    rng = np.random.default_rng(5)
    panels, figures, shown, flats, setout, connectors = [], {}, [], {}, [], []
    for i in range(strips):
        for j in range(cells):
            mark = f"P-{i:02d}-{j:02d}"
            ruled = patch(i, j, strips, cells)
            plate = Plate(mark, mark, "panel", ruled, 3.0, "S355")
            middle = ruled.points(np.array([0.5 * (ruled.u0 + ruled.u1)]), np.array([0.5]))[0]
            outward = unit(middle)
            part = facing(shown_plate(plate, "panels"), outward)
            shown.append(part)
            cell = np.concatenate([part.rails[:2] - 250.0 * outward, part.rails[2:]])
            shown.append(Shown(f"C-{i:02d}-{j:02d}", "cells", cell, part.normal, mark))
            flats[mark] = flat(mark, ruled)
            figures[mark] = {
                "kink_max_deg": float(abs(rng.normal(0.0, 0.9))),
                "gap_max_mm": float(abs(rng.normal(0.0, 0.5))),
                "surface_deviation_mm": float(abs(rng.normal(0.0, 4.0))),
                "twist_max_deg": float(abs(rng.normal(0.0, 0.005))),
            }
            panels.append(_row(i, j, mark, ruled, flats[mark], figures[mark], middle))
            u = np.array([ruled.u0, ruled.u1])
            corners, normals = ruled.edges(u), ruled_normals(ruled, u)
            for number, (side, end) in enumerate(((0, 0), (0, 1), (1, 1), (1, 0)), 1):
                point, place = f"{mark}/{number}", corners[side, end]
                setout.append(SetoutPoint(point, place, normals[end], "panel corner", mark))
            for k in range(4):
                at = ruled.points(np.array([ruled.u0]), np.array([0.2 + 0.2 * k]))[0]
                connectors.append(ShownConnector(f"K-{i:02d}-{j:02d}-{k}", "fix", at, outward))
    nests = (_nest(panels, flats),)
    grid = np.stack(np.meshgrid(np.arange(40.0), np.arange(90.0), [0.0], indexing="ij"), -1)
    grid = grid[:, :, 0]
    values = 6.0 * np.sin(grid[..., 0] / 7.0) * np.cos(grid[..., 1] / 11.0)
    return ReviewRecord(
        name=name,
        version="0.1.0",
        panels=tuple(panels),
        connectors=tuple(
            {
                "mark": c.mark,
                "product": c.product,
                "panel": f"P{c.mark[1:7]}",
                "mass_kg": 0.4,
                **{f"{k}_mm": float(v) for k, v in zip("xyz", c.origin, strict=True)},
                **{f"axis_{k}": float(v) for k, v in zip("xyz", c.axis, strict=True)},
            }
            for c in connectors
        ),
        shown=tuple(shown),
        shown_connectors=tuple(connectors),
        flats=flats,
        nests=nests,
        setout=tuple(setout),
        limits=(
            Limit("kink_max_deg", 1.0, 3.0, "Kink that replacement adds", "project default"),
            Limit("gap_max_mm", 1.2, None, "Gap between neighbours", "project default"),
            Limit("surface_deviation_mm", None, label="Deviation from the design surface"),
        ),
        figures=figures,
        summary={"deviation_max_mm": 6.0, "solids": strips * cells, "invalid_solids": 0},
        history=tuple(
            {"iteration": k, "cost": 10.0 ** (3 - k / 4), "closeness": 10.0 ** (2 - k / 6)}
            for k in range(20)
        ),
        seconds={"fit": 12.5, "nest": 30.1},
        deviation=DeviationMap(grid, values),
        tradeoff=tuple(
            {"tolerance_mm": t, "flat": f, "cylinder": c, "cone": k, "developable": 100 - f - c - k}
            for t, f, c, k in ((0.1, 2, 10, 8), (1, 10, 40, 20), (10, 30, 55, 12), (50, 60, 36, 4))
        ),
        not_asked=("beams",),
        materials={"S355": {"density_kg_m3": 7850.0, "name": "Steel S355"}},
    )


def _row(i, j, mark, ruled, part, figures, middle):  # type: ignore[no-untyped-def]
    points = np.concatenate([edge.points for edge in part.outline])
    size = np.ptp(points, axis=0)
    kinds = ("flat", "cylinder", "cone", "developable")
    return {
        "mark": mark,
        "strip": i,
        "cell": j,
        "class": kinds[(i + j) % 4],
        "radius_min_mm": RADIUS,
        "radius_max_mm": RADIUS,
        "material": "S355",
        "thickness_mm": 3.0,
        "flat_length_mm": float(size[0]),
        "flat_width_mm": float(size[1]),
        "area_m2": part.area / 1e6,
        "mass_kg": part.area / 1e6 * 3.0 * 7.85,
        "cog_x_mm": float(middle[0]),
        "cog_y_mm": float(middle[1]),
        "cog_z_mm": float(middle[2]),
        "holes": len(part.holes),
        "forming": "spring",
        "sheet": f"SHEET-{i + 1:03d}",
        **figures,
    }


def _nest(panels, flats):  # type: ignore[no-untyped-def]
    """Panels under each other, one strip a sheet."""
    sheets = []
    stock = Stock("12 m plate", "S355", 3.0, 12_000.0, 12_500.0)
    for strip in sorted({row["strip"] for row in panels}):
        places, y = [], 10.0
        for row in (row for row in panels if row["strip"] == strip):
            points = np.concatenate([edge.points for edge in flats[row["mark"]].outline])
            low, high = points.min(axis=0), points.max(axis=0)
            places.append(Placement(row["mark"], 10.0 - low[0], y - low[1], 0.0))
            y += high[1] - low[1] + 8.0
        used = sum(flats[p.mark].area for p in places) / (stock.length * stock.width)
        sheets.append(Sheet(f"SHEET-{strip + 1:03d}", stock, tuple(places), used))
    return Nest("S355", 3.0, tuple(sheets), {}, 0.5, 8.0, 10.0)
