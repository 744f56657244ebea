"""Nested sheets: every part once, as in its own file, inside the margins, apart by the spacing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import shapely

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.review.check_flats import hole_curves, hole_rims, hole_rows
from fabgeo.review.check_work import each
from fabgeo.review.dxf_text import Drawing, read_drawing
from fabgeo.review.findings import Findings
from fabgeo.review.measured import FlatFile, Measured, SheetFile
from fabgeo.review.package import WrittenPackage, number
from fabgeo.review.solid_plate import shape_area

SLACK = 0.03  # mm: what a distance may fall short (arcs are measured by chords)
HOLE = 0.05  # mm: a hole on a sheet against the part's own file
CUT = 1e-4  # relative: length of all contours
MASS = 2e-3  # relative: solids of bent plates weigh a little else than flat ones
COPY = 0.06  # mm: an outline on a sheet against the part's own file


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
    stock = [c for c in drawing.curves if c.layer == package.layer("SHEET")]
    if len(stock) != 1:
        findings.add(name, "rectangles of the stock", 1, len(stock))
        return
    marks, polygons, used = [], [], 0.0
    rims = hole_rims(hole_curves(package, drawing))
    holes = hole_rows(rims)
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
        motions = _copy(mark, points, flat, findings, name)
        _holes(holes, mark, polygons[-1], flat, motions, findings, name)
    outline = stock[0].points()
    _apart(package, marks, polygons, outline, findings, name)
    cut = sum(shapely.LinearRing(rim).length for rim in rims)
    cut += sum(polygon.length for polygon in polygons)
    pierces = len(rims) + len(polygons)
    measured.sheets[name] = SheetFile(tuple(marks), used, shape_area(outline), cut, pierces)


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


def _copy(mark: str, points: Array, flat: FlatFile, findings: Findings, name: str) -> list[Motion]:
    """The outline on the sheet is the part's own, moved and turned but not mirrored.

    Returns all motions that it may have gone: a rectangle may have been turned by 180 degrees.
    """
    if len(points) == len(flat.outline):
        motions = moves(flat.outline, points)
        away = min(motion.away for motion in motions)
        if away > COPY:
            words = f"the part's own within {COPY} mm"
            findings.add(mark, "outline on its sheet", words, f"{away:.3f} mm off", name)
        return [motion for motion in motions if motion.away <= COPY]
    own = flat.outline
    area, there = shape_area(own), shape_area(points)
    findings.near(mark, "area on its sheet in mm2", area, there, 1e-5 * area, name)
    length, there = shapely.LinearRing(own).length, shapely.LinearRing(points).length
    findings.near(mark, "length of its outline on the sheet", length, there, 1e-5 * length, name)
    return []


@dataclass(frozen=True)
class Motion:
    """A turn and a move in the plane, as complex numbers, and what it leaves between outlines."""

    turn: complex
    move: complex
    away: float

    def __call__(self, points: Array) -> Array:
        """Points (k, 2) moved."""
        z = (points[:, 0] + 1j * points[:, 1]) * self.turn + self.move
        return np.stack([z.real, z.imag], axis=1)


def moves(source: Array, target: Array) -> list[Motion]:
    """The best turns and moves, over all starting points of the outline."""
    z, w = source[:, 0] + 1j * source[:, 1], target[:, 0] + 1j * target[:, 1]
    middle, there = z.mean(), w.mean()
    z, w = z - middle, w - there
    # One transform gives all cyclic shifts: |sum conj(z) w| is largest for the best of them.
    scores = np.abs(np.fft.ifft(np.conj(np.fft.fft(z)) * np.fft.fft(w)))
    found = []
    for shift in np.argsort(-scores)[:4]:  # of a square all are alike
        moved = np.roll(w, -int(shift))
        turn = np.vdot(z, moved)
        turn = complex(turn / abs(turn)) if abs(turn) > 0.0 else 1.0 + 0.0j
        away = float(np.abs(z * turn - moved).max())
        found.append(Motion(turn, complex(there - middle * turn), away))
    return found


def _holes(
    rows: Array,
    mark: str,
    polygon: shapely.Polygon,
    flat: FlatFile,
    motions: list[Motion],
    findings: Findings,
    name: str,
) -> None:
    """As many holes as in the part's own file, as large, and moved with its outline."""
    inside = rows[shapely.contains_xy(polygon, rows[:, 0], rows[:, 1])]
    if len(inside) != len(flat.holes):
        findings.add(mark, "holes on its sheet", len(flat.holes), len(inside), name)
        return
    if not len(inside):
        return
    own, there = np.sort(flat.holes[:, 2:], axis=0), np.sort(inside[:, 2:], axis=0)
    if np.abs(own - there).max() > HOLE:
        findings.add(mark, "hole sizes on its sheet", own.max(), there.max(), name)
    off = []
    for motion in motions:
        moved = motion(flat.holes[:, :2])
        away = np.linalg.norm(moved[:, None] - inside[None, :, :2], axis=-1)
        off.append(max(float(away.min(axis=1).max()), float(away.min(axis=0).max())))
    if off and min(off) > HOLE:
        words = "where the part's own are"
        findings.add(mark, "holes on its sheet", words, f"{min(off):.3f} mm off", name)


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
        size = [number(row, "length_mm"), number(row, "width_mm")]
        if size[0] is not None and size[1] is not None:
            area = size[0] * size[1]
            findings.near(name, "area of the stock in mm2", sheet.whole, area, 1e-6 * area)


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
