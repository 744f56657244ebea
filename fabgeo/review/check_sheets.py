"""Nested sheets: every part once, as in its own file, inside the margins, apart by the spacing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import shapely

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.review.check_flats import hole_rows
from fabgeo.review.dxf_text import Drawing, read_drawing
from fabgeo.review.findings import Findings
from fabgeo.review.measured import FlatFile, Measured
from fabgeo.review.package import WrittenPackage, number
from fabgeo.review.solid_plate import shape_area

SLACK = 0.03  # mm: what a distance may fall short (arcs are measured by chords)
COPY = 0.06  # mm: an outline on a sheet against the part's own file


def check_sheets(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Measure every sheet's file and count the parts over all of them."""
    if not package.sheet_files:
        return
    areas: list[tuple[float, float]] = []
    for path in package.sheet_files:
        areas.append(_sheet(package, path, measured, findings))
    for mark, flat in measured.flats.items():
        where = measured.on_sheets.get(mark, [])
        stated = (package.cut_rows.get(mark, {}).get("sheet") or "").strip()
        if len(where) != 1 and (stated or where):
            findings.add(mark, "times on the sheets", 1, f"{len(where)} {' '.join(where)}".strip())
        elif where and stated and Path(where[0]).stem != Path(stated).name:
            findings.add(mark, "sheet in its schedule row", Path(where[0]).stem, stated)
        del flat
    measured.figures["unplaced_parts"] = float(
        sum(mark not in measured.on_sheets for mark in measured.flats)
    )
    whole = sum(sheet for _, sheet in areas)
    measured.figures["utilisation"] = sum(own for own, _ in areas) / whole if whole else 0.0


def _sheet(
    package: WrittenPackage, path: Path, measured: Measured, findings: Findings
) -> tuple[float, float]:
    """Check one sheet; net area of its parts and area of its stock."""
    name = path.relative_to(package.folder).as_posix()
    try:
        drawing = read_drawing(path)
    except InputError as error:
        findings.add(name, "DXF file", "readable", error.problem)
        return 0.0, 0.0
    stock = [c for c in drawing.curves if c.layer == package.layer("SHEET")]
    if len(stock) != 1:
        findings.add(name, "rectangles of the stock", 1, len(stock))
        return 0.0, 0.0
    marks, polygons, used = [], [], 0.0
    for mark, points in _named_outlines(package, drawing, name, findings):
        marks.append(mark)
        polygons.append(shapely.Polygon(points))
        measured.on_sheets.setdefault(mark, []).append(name)
        flat = measured.flats.get(mark)
        if flat is None:
            findings.add(mark, "cut/parts file of a nested part", "present", "missing", name)
            used += shape_area(points)
            continue
        used += flat.area
        _copy(mark, points, flat, findings, name)
        _holes(package, drawing, mark, polygons[-1], flat, findings, name)
    _apart(package, marks, polygons, stock[0].points(), findings, name)
    _row(package, path, marks, used, shape_area(stock[0].points()), findings)
    return used, shape_area(stock[0].points())


def _named_outlines(
    package: WrittenPackage, drawing: Drawing, name: str, findings: Findings
) -> list[tuple[str, Array]]:
    """Every outline with the one mark that stands inside it."""
    texts = [(t, shapely.Point(x, y)) for layer, t, x, y in drawing.texts
             if layer == package.layer("INFO")]  # fmt: skip
    found = []
    for curve in drawing.curves:
        if curve.layer != package.layer("CUT_OUTER"):
            continue
        points = curve.points()
        polygon = shapely.Polygon(points)
        inside = [text for text, at in texts if polygon.buffer(0).contains(at)]
        if len(inside) != 1:
            low = points.min(axis=0)
            where = inside[0] if inside else f"{name} at ({low[0]:.0f}, {low[1]:.0f})"
            findings.add(where, "marks inside one outline", 1, " ".join(inside) or "none", name)
            if not inside:
                continue
        if not curve.closed:
            findings.add(inside[0], "outline on its sheet", "closed", "open", name)
        if not polygon.is_valid:
            findings.add(inside[0], "outline on its sheet", "simple", "crosses itself", name)
        found.append((inside[0], points))
    return found


def _copy(mark: str, points: Array, flat: FlatFile, findings: Findings, name: str) -> None:
    """The outline on the sheet is the part's own, moved and turned but not mirrored."""
    if len(points) == len(flat.outline):
        away = _rigid(flat.outline, points)
        if away > COPY:
            words = f"the part's own within {COPY} mm"
            findings.add(mark, "outline on its sheet", words, f"{away:.3f} mm off", name)
        return
    own = flat.outline
    area, there = shape_area(own), shape_area(points)
    findings.near(mark, "area on its sheet in mm2", area, there, 1e-5 * area, name)
    length, there = shapely.LinearRing(own).length, shapely.LinearRing(points).length
    findings.near(mark, "length of its outline on the sheet", length, there, 1e-5 * length, name)


def _rigid(source: Array, target: Array) -> float:
    """Largest distance after the best turn and move, over all starting points of the outline."""
    s, t = source - source.mean(axis=0), target - target.mean(axis=0)
    z, w = s[:, 0] + 1j * s[:, 1], t[:, 0] + 1j * t[:, 1]
    # One transform gives all cyclic shifts: |sum conj(z) w| is largest for the best of them.
    scores = np.abs(np.fft.ifft(np.conj(np.fft.fft(z)) * np.fft.fft(w)))
    best = np.inf
    for shift in np.argsort(-scores)[:2]:
        moved = np.roll(w, -int(shift))
        turn = np.vdot(z, moved)
        turn = turn / abs(turn) if abs(turn) > 0.0 else 1.0
        best = min(best, float(np.abs(z * turn - moved).max()))
    return best


def _holes(
    package: WrittenPackage,
    drawing: Drawing,
    mark: str,
    polygon: shapely.Polygon,
    flat: FlatFile,
    findings: Findings,
    name: str,
) -> None:
    rows = hole_rows(package, drawing)
    inside = [row for row in rows if polygon.contains(shapely.Point(row[0], row[1]))]
    if len(inside) != len(flat.holes):
        findings.add(mark, "holes on its sheet", len(flat.holes), len(inside), name)
        return
    own = np.sort(flat.holes[:, 2:], axis=0)
    there = np.sort(np.array(inside).reshape(-1, 4)[:, 2:], axis=0)
    if len(own) and np.abs(own - there).max() > 0.05:
        findings.add(mark, "hole sizes on its sheet", own.max(), there.max(), name)


def _apart(
    package: WrittenPackage,
    marks: list[str],
    polygons: list[shapely.Polygon],
    stock: Array,
    findings: Findings,
    name: str,
) -> None:
    """Margins to the sheet's edge, spacing between parts."""
    spacing = float(package.setting("nesting", "spacing", 0.0))
    margin = float(package.setting("nesting", "margin", 0.0))
    low, high = stock.min(axis=0), stock.max(axis=0)
    sound = [polygon.buffer(0) for polygon in polygons]
    for mark, polygon in zip(marks, sound, strict=True):
        x0, y0, x1, y1 = polygon.bounds
        room = min(x0 - low[0], y0 - low[1], high[0] - x1, high[1] - y1)
        if room < margin - SLACK:
            findings.add(mark, "margin to the sheet's edge in mm", margin, float(room), name)
    if len(sound) < 2:
        return
    shapes = np.array(sound)
    tree = shapely.STRtree(shapes)
    pairs = tree.query(shapes, predicate="dwithin", distance=max(spacing - SLACK, 0.0))
    for i, j in pairs.T.tolist():
        if i >= j:
            continue
        gap = float(shapely.distance(shapes[i], shapes[j]))
        common = float(shapely.area(shapely.intersection(shapes[i], shapes[j])))
        if common > 1e-3:
            found = f"overlap of {common:.2f} mm2 with {marks[j]}"
        elif gap < spacing - SLACK:
            found = f"{gap:.3f} mm to {marks[j]}"
        else:
            continue
        findings.add(marks[i], "spacing on its sheet in mm", spacing, found, name)
        findings.add(marks[j], "spacing on its sheet in mm", spacing,
                     found.replace(marks[j], marks[i]), name)  # fmt: skip


def _row(
    package: WrittenPackage,
    path: Path,
    marks: list[str],
    used: float,
    whole: float,
    findings: Findings,
) -> None:
    """The sheet's schedule row: number of parts and utilisation."""
    name = path.relative_to(package.folder).as_posix()
    rows = [row for row in package.tables["sheets"] if row.get("file") == name]
    if package.tables["sheets"] and len(rows) != 1:
        findings.add(name, "rows in sheets.csv", 1, len(rows))
    for row in rows:
        parts, share = number(row, "parts"), number(row, "utilisation")
        if parts is not None:
            findings.near(name, "parts in sheets.csv", len(marks), parts, 0.0)
        if share is not None and whole:
            findings.near(name, "utilisation in sheets.csv", used / whole, share, 2e-4)
