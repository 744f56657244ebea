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

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.review.check_bends import bend_rows, check_bends, check_radii
from fabgeo.review.check_drawing import check_layers, check_strokes, label_of, strokes_of
from fabgeo.review.check_work import each
from fabgeo.review.dxf_text import Curve, Drawing, read_drawing
from fabgeo.review.findings import Findings
from fabgeo.review.flat_holes import openings_off
from fabgeo.review.flat_match import Match, is_mirrored, match, refold
from fabgeo.review.measured import FlatFile, Measured
from fabgeo.review.package import WrittenPackage, number
from fabgeo.review.solid_plate import SolidPlate

OUTLINE = 0.1  # mm: an outline off the solid's development; the writer's tolerance is added
LENGTH = 0.05  # mm: an edge's length against the solid's
AREA = 2e-5  # relative
REFOLD = 0.1  # mm
RIM = 0.15  # mm: a hole's contour off the rim of its opening in the solid
RIM_SAGITTA = 0.001  # mm: how far its points may be off it


def check_flats(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Read every cut/parts file and compare it with its solid and its schedule row."""
    asked = package.part_files or package.tables["sheets"]
    expected = set(package.cut_rows) if asked else set()
    for mark in sorted(expected - set(package.part_files)):
        findings.add(mark, "cut/parts file", "present", "missing", _name(mark))
    outwards = package.outwards
    drawn = [
        _Drawn(
            mark, path, package.cut_rows.get(mark), measured.plates.get(mark), outwards.get(mark)
        )
        for mark, path in package.part_files.items()
    ]
    each(partial(_drawing, package), drawn, package.jobs, measured, findings)
    for mark in package.part_files:
        if mark not in package.cut_rows and package.cut_rows:
            findings.add(mark, "row in the schedules", "present", "missing", _name(mark))


@dataclass(frozen=True)
class _Drawn:
    """A cut/parts file with what it is compared with."""

    mark: str
    path: Path
    row: dict[str, str] | None
    plate: SolidPlate | None
    up: Array | None


def _name(mark: str) -> str:
    return f"cut/parts/{mark}.dxf"


def _drawing(package: WrittenPackage, part: _Drawn, measured: Measured, findings: Findings) -> None:
    """Measure one file."""
    mark, name = part.mark, _name(part.mark)
    try:
        drawing = read_drawing(part.path)
    except InputError as error:
        findings.add(mark, "DXF file", "readable", error.problem, name)
        return
    check_layers(package, drawing, mark, findings, name)
    flat = flat_file(package, mark, drawing, findings, name)
    _mark(package, mark, drawing, flat, findings, name)
    if flat is None:
        return
    measured.flats[mark] = flat
    _row(package, flat, part.row or {}, findings, name)
    bends = bend_rows(part.path)
    check_bends(flat, bends, findings, name)
    if part.plate is not None:
        _against_solid(package, flat, part, part.plate, bends, measured, findings, name)


def _mark(
    package: WrittenPackage,
    mark: str,
    drawing: Drawing,
    flat: FlatFile | None,
    findings: Findings,
    name: str,
) -> None:
    """One mark, as text and engraved, inside the outline."""
    import shapely

    texts = [(t, (x, y)) for layer, t, x, y in drawing.texts if layer == package.layer("INFO")]
    if [text for text, _ in texts] != [mark]:
        found = ", ".join(text for text, _ in texts) or "none"
        findings.add(mark, "mark in its drawing", mark, found, name)
    if flat is None:
        return
    polygon = shapely.Polygon(flat.outline)
    if any(not polygon.contains(shapely.Point(at)) for _, at in texts):
        findings.add(mark, "mark in its drawing", "inside the outline", "outside", name)
    check_strokes(strokes_of(package, drawing), mark, polygon, findings, name)


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
    openings = hole_curves(package, drawing)
    rims = hole_rims(openings)
    holes = hole_rows(rims)
    for x, y, width, _ in holes:
        if not polygon.contains(shapely.Point(x, y)):
            findings.add(mark, "hole", "inside the outline", f"({x:.1f}, {y:.1f})", name)
        if width <= 0.0:
            findings.add(mark, "hole width", "positive", width, name)
    net = outers[0].area - sum(opening.area for opening in openings)
    label = label_of(strokes_of(package, drawing))
    return FlatFile(mark, points, holes, rims, bend_lines(package, drawing), net, label)


def bend_lines(package: WrittenPackage, drawing: Drawing) -> Array:
    """Ends (b, 2, 2) of a drawing's bend lines."""
    lines = [ends for layer, *ends in drawing.lines if layer == package.layer("RULINGS")]
    return np.array(lines, dtype=float).reshape(-1, 2, 2)


def hole_curves(package: WrittenPackage, drawing: Drawing) -> list[Curve]:
    """All curves of a drawing that cut holes."""
    layers = (package.layer("HOLES"), package.layer("CUT_INNER"))
    return [curve for curve in drawing.curves if curve.layer in layers]


def hole_rims(openings: Sequence[Curve]) -> tuple[Array, ...]:
    """Their contours (n, 2)."""
    return tuple(curve.points(RIM_SAGITTA) for curve in openings)


def hole_rows(rims: tuple[Array, ...]) -> Array:
    """Holes (h, 4) as x, y, width, length."""
    return np.array([_slot(rim) for rim in rims], dtype=float).reshape(-1, 4)


def _slot(points: Array) -> tuple[float, float, float, float]:
    """Centre, width and length of a hole from its contour."""
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    _, _, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    along, across = (points - centre) @ axes.T[:, 0], (points - centre) @ axes.T[:, 1]
    return float(centre[0]), float(centre[1]), float(np.ptp(across)), float(np.ptp(along))


def _row(
    package: WrittenPackage, flat: FlatFile, row: dict[str, str], findings: Findings, name: str
) -> None:
    """The drawing against its schedule row: area, overall size, number of holes."""
    area, holes = number(row, "area_m2"), number(row, "holes")
    if area is not None:
        within = (AREA * 1e6 * area + _beside(package, flat)) / 1e6 + 1e-6
        findings.near(flat.mark, "flat area in m2", area, flat.area / 1e6, within, name)
    if holes is not None:
        findings.near(flat.mark, "holes in the drawing", holes, len(flat.holes), 0.0, name)
    size = np.ptp(flat.outline, axis=0)
    prefix = "flat_" if "flat_length_mm" in row else ""
    for key, found in ((f"{prefix}length_mm", size[0]), (f"{prefix}width_mm", size[1])):
        value = number(row, key)
        if value is not None:
            within = 0.02 + 2.0 * _tolerance(package)
            findings.near(flat.mark, key, value, float(found), within, name)


def _tolerance(package: WrittenPackage) -> float:
    """How far outlines may be written off the exact ones, mm."""
    return float(package.setting("cutting", "tolerance", 0.05))


def _beside(package: WrittenPackage, flat: FlatFile) -> float:
    """Area in mm2 between an outline and the exact one, within the tolerance of it.

    Arcs cross the exact curve again and again, chords lie on one side of it: of a segment two
    thirds of its sagitta.
    """
    around = float(np.linalg.norm(np.diff(flat.outline, axis=0), axis=1).sum())
    chords = package.setting("cutting", "curves", "arcs") == "polylines"
    return (2.0 / 3.0 if chords else 0.2) * _tolerance(package) * around


def _against_solid(
    package: WrittenPackage,
    flat: FlatFile,
    part: _Drawn,
    plate: SolidPlate,
    bends: list[dict[str, str]],
    measured: Measured,
    findings: Findings,
    name: str,
) -> None:
    mark, tolerance = flat.mark, _tolerance(package)
    findings.near(mark, "holes in the solid", len(flat.holes), len(plate.openings), 0.0, name)
    found: Match | None = match(flat.outline, plate, flat.rims, part.up)
    if found is None:
        findings.add(mark, "outline", "corners as on its solid", "others", name)
        return
    if is_mirrored(plate, found, part.up):
        findings.add(mark, "outline", "seen from outside", "mirrored", name)
    measured.edge_errors[mark] = found.length_errors
    worst = float(np.abs(found.length_errors).max())
    measured.worst("edge_length_error_mm", worst)
    # What turns by an angle a is shortened by chords within the tolerance by a third of a times it.
    if worst > max(LENGTH, tolerance) + 2e-6 * float(plate.lengths.max()):
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
    _holes(flat, plate, found, findings, name)
    check_radii(flat, plate, found, bends, findings, name)
    area = plate.volume / plate.thickness
    measured.worst("area_error_rel", abs(flat.area - area) / area)
    within = AREA * area + _beside(package, flat)
    findings.near(mark, "flat area in mm2 of its solid", area, flat.area, within, name)
    if len(flat.bends):
        off = refold(flat, plate, found)
        measured.worst("refold_error_mm", off)
        if off > REFOLD:
            findings.add(mark, "refolding by the bend lines in mm", f"at most {REFOLD}", off, name)


def _holes(flat: FlatFile, plate: SolidPlate, found: Match, findings: Findings, name: str) -> None:
    """Every opening of the solid, laid flat, is a hole of the drawing in place and size."""
    if found.rails is None or not flat.rims:
        return
    for away, at in openings_off(plate, found.rails, flat.rims):
        if away > RIM:
            words = f"{away:.3f} mm off at ({at[0]:.1f}, {at[1]:.1f})"
            findings.add(flat.mark, "hole", f"within {RIM} mm of its solid's", words, name)
