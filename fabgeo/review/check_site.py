"""What the site works by: boxes for transport, the order of erection."""

from __future__ import annotations

from collections import defaultdict
from functools import partial

import numpy as np

from fabgeo.arrays import Array
from fabgeo.review.check_marks import PANEL
from fabgeo.review.check_work import each
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number
from fabgeo.review.solid_plate import SolidPlate
from fabgeo.structures.boxes import oriented_box

BOX = 1.5e-3  # of a box's size: it is searched over other points here, 5e-4 off at most
BOX_MM = 0.2  # one decimal is written
OTHER = 0.02  # of a size: another box may be as small, it is found over other points
SAME = 2e-3  # of its volume, to be that

type Row = dict[str, str]


def check_site(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Compare boxes and erection order with the solids and with each other."""
    _boxes(package, measured, findings)
    _order(package, findings)


def _boxes(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Stated boxes against boxes around the solids, and their verdicts against the truck's."""
    limit = np.sort(package.setting("limits", "transport_mm", (13600.0, 2480.0, 2500.0)))
    parts = defaultdict(list)
    for row in package.tables["plates"]:
        parts[row.get("parent", "")].append(row.get("mark", ""))
    tasks: list[tuple[Row, list[Array], float | None]] = []
    for table in ("panels", "beams", "cells"):
        for row in package.tables[table]:
            mark = row.get("mark", "")
            marks = parts.get(mark, [mark]) if table == "beams" else [mark]
            known = [_corners(m, measured) for m in marks]
            whole = [points for points in known if points is not None]
            tasks.append(
                (row, whole if len(whole) == len(known) else [], measured.volumes.get(mark))
            )
    each(partial(_box_of, limit), tasks, package.jobs, measured, findings)


def _box_of(
    limit: Array,
    part: tuple[Row, list[Array], float | None],
    measured: Measured,
    findings: Findings,
) -> None:
    """One row's box against the truck's, its solid's volume and the box around its solids."""
    row, solids, volume = part
    mark = row.get("mark", "")
    size = _size(row)
    if len(size) != 3:
        return
    fits = bool(np.all(np.sort(size) <= limit + 0.1))
    if row.get("transport") and fits != (row["transport"] == "fits"):
        findings.add(
            mark, "transport by its box", "fits" if fits else "too large", row["transport"]
        )
    if volume is not None and float(np.prod(size)) < volume * (1.0 - SAME):
        findings.add(mark, "volume of its box in mm3", f"over {volume:.4g}", np.prod(size))
    if solids:
        _box(mark, size, oriented_box(np.concatenate(solids)).size, findings)


def _size(row: Row) -> Array:
    """The three sides that a row states, or fewer."""
    stated = [number(row, f"box_{side}_mm") for side in ("length", "width", "height")]
    return np.array([value for value in stated if value is not None])


def _box(mark: str, stated: Array, found: Array, findings: Findings) -> None:
    if np.all(np.abs(stated - found) <= OTHER * found) and (
        abs(float(np.prod(stated) / np.prod(found)) - 1.0) <= SAME
    ):
        return
    for side, own, there in zip(("length", "width", "height"), found, stated, strict=True):
        what = f"box_{side}_mm around its solid"
        findings.near(mark, what, float(own), float(there), BOX * float(own) + BOX_MM)


def _corners(mark: str, measured: Measured) -> Array | None:
    """Points on the edges of a solid, or of a plate's skins; None where it was not measured."""
    if mark in measured.plates:
        return _skins(measured.plates[mark])
    return measured.cells.get(mark)


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
    order = {mark: known[mark] for row in panels if (mark := row.get("mark", "")) in known}
    for mark in _out_of_order(order):
        findings.add(mark, "erection_order", "strip by strip, cell by cell", order[mark])
    first: dict[float, float] = {}
    for row in panels:
        strip, place = number(row, "strip"), known.get(row.get("mark", ""))
        if strip is not None and place is not None:
            first[strip] = min(first.get(strip, place), place)
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


def _out_of_order(places: dict[str, float]) -> list[str]:
    """Panels that stand out of the order of their marks' numbers, by their places.

    What one panel displaced has moved by one is not named: who passes the most others is.
    """
    order = sorted((mark for mark in places if PANEL.match(mark)), key=lambda mark: places[mark])
    numbers = np.array([PANEL.findall(mark)[0] for mark in order], dtype=int).reshape(-1, 2)
    ranks = np.argsort(np.lexsort(numbers.T[::-1]), kind="stable")
    if np.array_equal(ranks, np.arange(len(ranks))):
        return []
    passed = np.triu(ranks[:, None] > ranks)
    count = passed.sum(axis=0) + passed.sum(axis=1)
    wrong = (ranks != np.arange(len(ranks))) & (2 * count > count.max())
    return [order[k] for k in np.flatnonzero(wrong)]
