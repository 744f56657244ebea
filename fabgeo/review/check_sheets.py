"""Nested sheets: every part once, as in its own file, inside the margins, apart by the spacing."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
import shapely

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.review.check_drawing import check_layers, check_strokes, label_of, strokes_of
from fabgeo.review.check_flats import bend_lines, hole_curves, hole_rims, hole_rows
from fabgeo.review.check_work import each
from fabgeo.review.dxf_text import Drawing, read_drawing
from fabgeo.review.findings import Findings
from fabgeo.review.measured import FlatFile, Measured, SheetFile
from fabgeo.review.package import WrittenPackage, number
from fabgeo.review.sheet_copy import check_bends, check_copy, check_holes, check_turn
from fabgeo.review.solid_plate import shape_area

SLACK = 0.03  # mm: what a distance may fall short (arcs are measured by chords)
SIZE = 0.01  # mm: a sheet's sides
CUT = 1e-4  # relative: length of all contours
MASS = 2e-3  # relative: solids of bent plates weigh a little else than flat ones


def check_sheets(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Measure every sheet's file and count the parts over all of them."""
    if not package.sheet_files and not package.tables["sheets"]:
        return
    flats = measured.flats
    each(partial(_sheet, package), _files(package, flats), package.jobs, measured, findings)
    for mark in flats:
        where = measured.on_sheets.get(mark, [])
        stated = (package.cut_rows.get(mark, {}).get("sheet") or "").strip()
        if len(where) != 1 and (stated or where):
            findings.add(mark, "times on the sheets", 1, f"{len(where)} {' '.join(where)}".strip())
        elif where and stated and not _is_sheet(stated, where[0]):
            findings.add(mark, "sheet in its schedule row", where[0], stated)
    for row in package.tables["sheets"]:
        name = row.get("file") or f"{row.get('sheet')}"
        if not (package.folder / name).is_file():
            findings.add(name, "file of a row in sheets.csv", "present", "missing")
    for name, sheet in measured.sheets.items():
        _row(package, name, sheet, findings)
    measured.figures["unplaced_parts"] = float(
        sum(mark not in measured.on_sheets for mark in flats)
    )
    whole = sum(sheet.whole for sheet in measured.sheets.values())
    used = sum(sheet.used for sheet in measured.sheets.values())
    measured.figures["utilisation"] = used / whole if whole else 0.0


def _is_sheet(stated: str, file: str) -> bool:
    """Whether a row's sheet, with or without its folder, is a file of cut/nests."""
    own, there = Path(stated).parts, Path(file).with_suffix("").parts
    return own == there[-len(own) :]


def _files(
    package: WrittenPackage, flats: dict[str, FlatFile]
) -> Iterator[tuple[Path, dict[str, FlatFile]]]:
    """Every sheet with the flat parts whose marks its text holds."""
    for path in package.sheet_files:
        words = set(path.read_text(encoding="utf-8", errors="replace").split())
        yield path, {mark: flats[mark] for mark in flats.keys() & words}


def _sheet(
    package: WrittenPackage,
    file: tuple[Path, dict[str, FlatFile]],
    measured: Measured,
    findings: Findings,
) -> None:
    """Check one sheet; note what lies on it."""
    path, flats = file
    name = path.relative_to(package.folder).as_posix()
    try:
        drawing = read_drawing(path)
    except InputError as error:
        findings.add(name, "DXF file", "readable", error.problem)
        return
    check_layers(package, drawing, name, findings, name)
    stock = [c for c in drawing.curves if c.layer == package.layer("SHEET")]
    if len(stock) != 1:
        findings.add(name, "rectangles of the stock", 1, len(stock))
        return
    marks, polygons, used = [], [], 0.0
    rims = hole_rims(hole_curves(package, drawing))
    holes, bends, strokes = (
        hole_rows(rims),
        bend_lines(package, drawing),
        strokes_of(package, drawing),
    )
    begins = np.array([stroke[0] for stroke in strokes]).reshape(-1, 2)
    for mark, points in _named_outlines(package, drawing, name, findings):
        marks.append(mark)
        polygons.append(shapely.Polygon(points))
        measured.on_sheets.setdefault(mark, []).append(name)
        flat = flats.get(mark)
        if flat is None:
            findings.add(mark, "cut/parts file of a nested part", "present", "missing", name)
            used += shape_area(points)
            continue
        used += flat.area
        motions = check_copy(mark, points, flat, findings, name)
        check_holes(holes, mark, polygons[-1], flat, motions, findings, name)
        check_bends(bends, mark, polygons[-1], flat, motions, findings, name)
        inside = shapely.contains_xy(polygons[-1], begins[:, 0], begins[:, 1])
        own = [stroke for stroke, within in zip(strokes, inside, strict=True) if within]
        check_strokes(own, mark, polygons[-1], findings, name)
        row = package.cut_rows.get(mark, {})
        check_turn(row, mark, label_of(own), flat, motions, findings, name)
    outline = stock[0].points()
    _apart(package, marks, polygons, outline, findings, name)
    _title(package, drawing, outline, path.parent.name, findings, name)
    cut = sum(shapely.LinearRing(rim).length for rim in rims)
    cut += sum(polygon.length for polygon in polygons)
    pierces = len(rims) + len(polygons)
    length, width = np.ptp(outline, axis=0).tolist()
    if abs(shape_area(outline) - length * width) > SIZE * (length + width):
        findings.add(name, "the stock's outline", "a rectangle", "another shape")
    measured.sheets[name] = SheetFile(tuple(marks), used, (length, width), cut, pierces)


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


def _title(
    package: WrittenPackage,
    drawing: Drawing,
    stock: Array,
    group: str,
    findings: Findings,
    name: str,
) -> None:
    """The text beside the stock tells the material and thickness that the folder stands for."""
    material, _, thickness = group.rpartition("_")
    words = f"{material} {thickness.removesuffix('mm')} mm"
    (x0, y0), (x1, y1) = stock.min(axis=0), stock.max(axis=0)
    for layer, text, x, y in drawing.texts:
        beside = not (x0 <= x <= x1 and y0 <= y <= y1)
        if layer == package.layer("INFO") and beside and words not in text:
            findings.add(name, "title", words, text)


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


def _row(package: WrittenPackage, name: str, sheet: SheetFile, findings: Findings) -> None:
    """The sheet's schedule row: stock, marks and utilisation."""
    rows = [row for row in package.tables["sheets"] if row.get("file") == name]
    if package.tables["sheets"] and len(rows) != 1:
        findings.add(name, "rows in sheets.csv", 1, len(rows))
    for row in rows:
        parts, share = number(row, "parts"), number(row, "utilisation")
        if parts is not None:
            findings.near(name, "parts in sheets.csv", len(sheet.marks), parts, 0.0)
        stated = set((row.get("marks") or "").split())
        for mark in sorted(stated ^ set(sheet.marks)) if stated else ():
            words = ("on it", "not named") if mark in sheet.marks else ("not on it", "named")
            findings.add(mark, f"marks in sheets.csv of {name}", *words)
        if share is not None and sheet.whole:
            findings.near(name, "utilisation in sheets.csv", sheet.used / sheet.whole, share, 2e-4)
        cut, pierces = number(row, "cut_length_mm"), number(row, "pierces")
        if cut is not None:
            findings.near(name, "cut_length_mm in sheets.csv", sheet.cut, cut, 1.0 + CUT * cut)
        if pierces is not None:
            findings.near(name, "pierces in sheets.csv", sheet.pierces, pierces, 0.0)
        _weights(package, row, name, sheet, findings)
        for key, found in zip(("length_mm", "width_mm"), sheet.size, strict=True):
            stated = number(row, key)
            if stated is not None:
                findings.near(name, f"{key} of its stock in sheets.csv", found, stated, SIZE)


def _weights(
    package: WrittenPackage, row: dict[str, str], name: str, sheet: SheetFile, findings: Findings
) -> None:
    """Mass of a sheet's parts by their own rows; of the sheet by what its parts weigh."""
    parts, whole = number(row, "parts_mass_kg"), number(row, "sheet_mass_kg")
    masses = [number(package.cut_rows.get(mark, {}), "mass_kg") for mark in sheet.marks]
    known = [mass for mass in masses if mass is not None]
    if parts is None or len(known) != len(masses) or not sheet.used:
        return
    total = sum(known)
    findings.near(name, "parts_mass_kg in sheets.csv", total, parts, MASS * total + 0.01)
    if whole is not None:
        expected = total * sheet.whole / sheet.used
        findings.near(name, "sheet_mass_kg in sheets.csv", expected, whole, MASS * expected + 0.01)
