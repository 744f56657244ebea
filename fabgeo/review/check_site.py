"""What the site works by: setting-out points, boxes for transport, the order of erection."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from functools import partial

import numpy as np

from fabgeo.arrays import Array, cross
from fabgeo.review.check_work import each
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number
from fabgeo.review.solid_plate import SolidPlate
from fabgeo.structures.boxes import oriented_box

PLACE = 0.05  # mm: setting-out points carry four decimals
NORMAL = 0.1  # degrees
BOX = 0.02  # of a box's size: it is searched over other points here
BOX_MM = 5.0

type Row = dict[str, str]


def check_site(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Compare setting-out, boxes and erection order with the solids and with each other."""
    _points(package, measured, findings)
    _boxes(package, measured, findings)
    _order(package, findings)


def _points(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Every panel corner, beam node and connector once, where its solid or its row is."""
    own = package.setout
    tables = package.tables
    for mark in _marks(tables["panels"]):
        plate = measured.plates.get(mark)
        if plate is not None:
            _at_corners(mark, own.get(mark, []), plate.corners, len(plate.corners), findings)
            _normals(mark, own.get(mark, []), plate, findings)
    for mark in _marks(tables["beams"]):
        webs = [plate for key, plate in measured.plates.items() if key.startswith(f"{mark}-WEB")]
        if webs:  # one, or pieces from seam to seam
            corners = np.concatenate([web.corners for web in webs])
            _at_corners(mark, own.get(mark, []), corners, 2, findings)
    frames = {path[-1]: frame for path, frame in measured.fixings.items()}
    for row in tables["connectors"]:
        mark, centre = row.get("mark", ""), _vector(row, "x_mm", "y_mm", "z_mm")
        if np.isfinite(centre).all():
            _at_corners(mark, own.get(mark, []), centre[None], 1, findings)
        if mark in frames:
            _fixing(mark, row, centre, frames[mark], findings)


def _fixing(mark: str, row: Row, centre: Array, frame: Array, findings: Findings) -> None:
    """A connector's place and axis in the model against its row."""
    away = float(np.linalg.norm(frame[:3, 3] - centre))
    if away > PLACE:
        findings.add(mark, "place in the model", "as in connectors.csv", f"{away:.2f} mm off")
    off = _between(frame[:3, 2], _vector(row, "axis_x", "axis_y", "axis_z"))
    if off > NORMAL:
        findings.add(mark, "axis in the model", "as in connectors.csv", f"{off:.2f} deg off")


def _between(one: Array, other: Array) -> float:
    """Angle between two directions in degrees."""
    return float(np.degrees(np.arctan2(np.linalg.norm(cross(one, other)), float(one @ other))))


def _at_corners(mark: str, rows: list[Row], corners: Array, count: int, findings: Findings) -> None:
    """As many points as asked, each at another one of the corners."""
    if len(rows) != count:
        findings.add(mark, "setting-out points", count, len(rows), "setout/points.csv")
    taken: set[int] = set()
    for row in rows:
        away = np.linalg.norm(corners - _vector(row, "x", "y", "z"), axis=1)
        nearest = int(np.nanargmin(away)) if np.isfinite(away).any() else -1
        what = f"setting-out point {row.get('point')}"
        if nearest < 0 or away[nearest] > PLACE:
            found = f"{away[nearest]:.2f} mm off" if nearest >= 0 else "no numbers"
            findings.add(mark, what, "at its part", found, "setout/points.csv")
        elif nearest in taken:
            findings.add(mark, what, "at a corner of its own", "a second one", "setout/points.csv")
        taken.add(nearest)


def _normals(mark: str, rows: list[Row], plate: SolidPlate, findings: Findings) -> None:
    rails = plate.rails()
    if rails is None:
        return
    ends = np.concatenate([rail[[0, -1]] for rail in rails])
    normals = np.concatenate([normal[[0, -1]] for normal in plate.normals])
    for row in rows:
        k = int(np.linalg.norm(ends - _vector(row, "x", "y", "z"), axis=1).argmin())
        stated = _vector(row, "nx", "ny", "nz")
        sine, cosine = np.linalg.norm(cross(normals[k], stated)), abs(float(normals[k] @ stated))
        off = float(np.degrees(np.arctan2(sine, cosine)))
        if not off <= NORMAL:
            what = f"normal of setting-out point {row.get('point')}"
            findings.add(mark, what, "square to its panel", f"{off:.2f} deg off")


def _boxes(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Stated boxes against boxes around the solids, and their verdicts against the truck's."""
    limit = np.sort(package.setting("limits", "transport_mm", (13600.0, 2480.0, 2500.0)))
    parts = defaultdict(list)
    for row in package.tables["plates"]:
        parts[row.get("parent", "")].append(row.get("mark", ""))
    tasks: list[tuple[Row, list[SolidPlate], float | None]] = []
    for table in ("panels", "beams", "cells"):
        for row in package.tables[table]:
            mark = row.get("mark", "")
            marks = parts.get(mark, [mark])
            plates = [measured.plates[m] for m in marks if m in measured.plates]
            whole = plates if len(plates) == len(marks) else []
            tasks.append((row, whole, measured.volumes.get(mark)))
    each(partial(_box_of, limit), tasks, package.jobs, measured, findings)


def _box_of(
    limit: Array,
    part: tuple[Row, list[SolidPlate], float | None],
    measured: Measured,
    findings: Findings,
) -> None:
    """One row's box against the truck's, its solid's volume and the box around its plates."""
    row, plates, volume = part
    mark = row.get("mark", "")
    stated = [number(row, f"box_{side}_mm") for side in ("length", "width", "height")]
    size = np.array([value for value in stated if value is not None])
    if len(size) != 3:
        return
    fits = bool(np.all(np.sort(size) <= limit + 0.1))
    if row.get("transport") and fits != (row["transport"] == "fits"):
        findings.add(
            mark, "transport by its box", "fits" if fits else "too large", row["transport"]
        )
    if volume is not None and float(np.prod(size)) < volume * (1.0 - BOX):
        findings.add(mark, "volume of its box in mm3", f"over {volume:.4g}", np.prod(size))
    if plates:
        points = np.concatenate([_skins(plate) for plate in plates])
        _box(mark, size, oriented_box(points).size, findings)


def _box(mark: str, stated: Array, found: Array, findings: Findings) -> None:
    for side, own, there in zip(("length", "width", "height"), found, stated, strict=True):
        what = f"box_{side}_mm around its solid"
        findings.near(mark, what, float(own), float(there), BOX * float(own) + BOX_MM)


def _skins(plate: SolidPlate) -> Array:
    """Points on both skins along the edges (the mid-surface's alone without rulings)."""
    rails = plate.rails()
    if rails is None:
        return np.concatenate(plate.edges)
    half = [0.5 * plate.thickness * normal for normal in plate.normals]
    sides = [rail + sign * h for rail, h in zip(rails, half, strict=True) for sign in (-1.0, 1.0)]
    some = np.linspace(0.0, len(rails[0]) - 1.0, 9).round().astype(int)
    return np.concatenate([side[some] for side in sides])


def _order(package: WrittenPackage, findings: Findings) -> None:
    """Numbers 1, 2, 3, ...; panels strip by strip; beams before the panels that they carry."""
    panels, beams = package.tables["panels"], package.tables["beams"]
    stated = {row.get("mark", ""): number(row, "erection_order") for row in (*panels, *beams)}
    if all(place is None for place in stated.values()):
        return
    seen: dict[float, str] = {}
    for mark, place in stated.items():
        if place is None or not 1 <= place <= len(stated) or place in seen:
            words = f"a number of its own in 1 to {len(stated)}"
            findings.add(mark, "erection_order", words, "none" if place is None else f"{place:g}")
        elif place is not None:
            seen[place] = mark
    known = {mark: place for place, mark in seen.items()}
    first: dict[float, float] = {}
    last: dict[float, float] = {}
    for row in panels:
        strip, place = number(row, "strip"), known.get(row.get("mark", ""))
        if strip is not None and place is not None:
            first[strip] = min(first.get(strip, place), place)
            last[strip] = max(last.get(strip, place), place)
    for row in panels:
        strip, place = number(row, "strip"), known.get(row.get("mark", ""))
        if strip is not None and place is not None and place < last.get(strip - 1, 0.0):
            words = f"after strip {strip - 1:g}, whose last is {last[strip - 1]:g}"
            findings.add(row.get("mark", ""), "erection_order", words, place)
    for row in beams:
        edge, place = number(row, "edge"), known.get(row.get("mark", ""))
        if edge is not None and place is not None and place > first.get(edge, np.inf):
            words = f"before the panels of strip {edge:g}"
            findings.add(row.get("mark", ""), "erection_order", words, place)
    for row in package.tables["cells"]:
        mark, place = row.get("mark", ""), number(row, "erection_order")
        panel = stated.get(f"P{mark[1:]}")
        if place is not None and panel is not None:
            findings.near(mark, "erection_order of its panel", panel, place, 0.0)


def _marks(rows: Iterable[Row]) -> list[str]:
    return [row.get("mark", "") for row in rows]


def _vector(row: Row, *columns: str) -> Array:
    values = [number(row, column) for column in columns]
    return np.array([np.nan if value is None else value for value in values])
