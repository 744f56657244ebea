"""Flat parts against solids: one closed, simple outline that is the solid's own development.

Glossary
--------
development
    The solid's mid-surface laid flat from its rails: see `fabgeo.review.solid_plate.developed`.
refold
    Every piece between two bend lines is moved onto the solid's mid-surface; how far its corners
    come to lie off.
"""

from __future__ import annotations

import numpy as np

from fabgeo.errors import InputError
from fabgeo.review.dxf_text import Curve, Drawing, read_drawing
from fabgeo.review.findings import Findings
from fabgeo.review.flat_match import Match, match, refold
from fabgeo.review.measured import FlatFile, Measured
from fabgeo.review.package import WrittenPackage, number
from fabgeo.review.solid_plate import SolidPlate, shape_area

OUTLINE = 0.1  # mm: an outline off the solid's development; the writer's tolerance is added
LENGTH = 0.05  # mm: an edge's length against the solid's
AREA = 2e-5  # relative
REFOLD = 0.1  # mm


def check_flats(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Read every cut/parts file and compare it with its solid and its schedule row."""
    expected = set(package.cut_rows) if package.part_files else set()
    for mark in sorted(expected - set(package.part_files)):
        findings.add(mark, "cut/parts file", "present", "missing", f"cut/parts/{mark}.dxf")
    tolerance = float(package.setting("cutting", "tolerance", 0.05))
    for mark, path in package.part_files.items():
        name = f"cut/parts/{path.name}"
        if mark not in package.cut_rows and package.cut_rows:
            findings.add(mark, "row in the schedules", "present", "missing", name)
        try:
            drawing = read_drawing(path)
        except InputError as error:
            findings.add(mark, "DXF file", "readable", error.problem, name)
            continue
        if drawing.unit not in (4, None):
            findings.add(mark, "$INSUNITS", 4, drawing.unit, name)
        texts = [text for layer, text, _, _ in drawing.texts if layer == package.layer("INFO")]
        if texts != [mark]:
            findings.add(mark, "mark in its drawing", mark, ", ".join(texts) or "none", name)
        flat = flat_file(package, mark, drawing, findings, name)
        if flat is None:
            continue
        measured.flats[mark] = flat
        _row(package, flat, findings, name)
        plate = measured.plates.get(mark)
        if plate is not None:
            _against_solid(flat, plate, tolerance, measured, findings, name)


def flat_file(
    package: WrittenPackage, mark: str, drawing: Drawing, findings: Findings, name: str
) -> FlatFile | None:
    """The one closed, simple outline with its holes and bends; None where there is none."""
    import shapely

    outers = [c for c in drawing.curves if c.layer == package.layer("CUT_OUTER")]
    if len(outers) != 1:
        findings.add(mark, "outer outlines", 1, len(outers), name)
        return None
    if not outers[0].closed:
        findings.add(mark, "outline", "closed", "open", name)
        return None
    points = outers[0].points()
    polygon = shapely.Polygon(points)
    if not polygon.is_valid:
        findings.add(mark, "outline", "simple", "crosses itself", name)
        return None
    holes = hole_rows(package, drawing)
    for x, y, width, _ in holes:
        if not polygon.contains(shapely.Point(x, y)):
            findings.add(mark, "hole", "inside the outline", f"({x:.1f}, {y:.1f})", name)
        if width <= 0.0:
            findings.add(mark, "hole width", "positive", width, name)
    taken = sum(np.pi / 4.0 * w * w + w * (n - w) for _, _, w, n in holes)
    lines = [ends for layer, *ends in drawing.lines if layer == package.layer("RULINGS")]
    bends = np.array(lines, dtype=float).reshape(-1, 2, 2)
    return FlatFile(mark, points, holes, bends, shape_area(points) - float(taken))


def hole_rows(package: WrittenPackage, drawing: Drawing) -> np.ndarray:
    """Holes (h, 4) as x, y, width, length: circles, and slots drawn as closed curves."""
    layers = (package.layer("HOLES"), package.layer("CUT_INNER"))
    rows = [(x, y, 2 * r, 2 * r) for layer, x, y, r in drawing.circles if layer in layers]
    rows += [_slot(curve) for curve in drawing.curves if curve.layer in layers]
    return np.array(rows, dtype=float).reshape(-1, 4)


def _slot(curve: Curve) -> tuple[float, float, float, float]:
    """Centre, width and length of a slot from its contour."""
    points = curve.points(0.001)
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    _, _, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    along, across = (points - centre) @ axes.T[:, 0], (points - centre) @ axes.T[:, 1]
    return float(centre[0]), float(centre[1]), float(np.ptp(across)), float(np.ptp(along))


def _row(package: WrittenPackage, flat: FlatFile, findings: Findings, name: str) -> None:
    """The drawing against its schedule row: area, overall size, number of holes."""
    row = package.cut_rows.get(flat.mark, {})
    area, holes = number(row, "area_m2"), number(row, "holes")
    if area is not None:
        # A contour of arcs may lie off the exact one by the tolerance, to one side at the worst.
        around = float(np.linalg.norm(np.diff(flat.outline, axis=0), axis=1).sum())
        slack = 0.2 * float(package.setting("cutting", "tolerance", 0.05)) * around / 1e6
        within = AREA * area + slack + 1e-6
        findings.near(flat.mark, "flat area in m2", area, flat.area / 1e6, within, name)
    if holes is not None:
        findings.near(flat.mark, "holes in the drawing", holes, len(flat.holes), 0.0, name)
    size = np.ptp(flat.outline, axis=0)
    for key, found in (("flat_length_mm", size[0]), ("flat_width_mm", size[1])):
        value = number(row, key)
        if value is not None:
            findings.near(flat.mark, key, value, float(found), 0.12, name)


def _against_solid(
    flat: FlatFile,
    plate: SolidPlate,
    tolerance: float,
    measured: Measured,
    findings: Findings,
    name: str,
) -> None:
    mark = flat.mark
    findings.near(mark, "holes in the solid", len(flat.holes), plate.holes, 0.0, name)
    found: Match | None = match(flat.outline, plate)
    if found is None:
        findings.add(mark, "outline", "corners as on its solid", "others", name)
        return
    measured.edge_errors[mark] = found.length_errors
    worst = float(np.abs(found.length_errors).max())
    measured.worst("edge_length_error_mm", worst)
    if worst > LENGTH + 2e-6 * float(plate.lengths.max()):
        k = int(np.abs(found.length_errors).argmax())
        expected = float(plate.lengths[k])
        findings.add(mark, "edge length in mm", expected, expected + found.length_errors[k], name)
    if found.away is not None:
        measured.worst("outline_error_mm", found.away)
        # A long plate is sampled as often as a short one: its development is known less well.
        within = OUTLINE + tolerance + 5e-6 * float(plate.lengths.max())
        if found.away > within:
            words = f"within {within:.3f} mm of the solid's development"
            at = f"{found.away:.3f} mm off at ({found.at[0]:.1f}, {found.at[1]:.1f})"
            findings.add(mark, "outline", words, at, name)
    volume = flat.area * plate.thickness
    error = abs(volume - plate.volume) / plate.volume
    measured.worst("area_error_rel", error)
    if error > 10 * AREA:
        findings.add(mark, "flat area times thickness in mm3", plate.volume, volume, name)
    if len(flat.bends):
        off = refold(flat, plate, found)
        measured.worst("refold_error_mm", off)
        if off > REFOLD:
            findings.add(mark, "refolding by the bend lines in mm", f"at most {REFOLD}", off, name)
