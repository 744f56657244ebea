"""Bend lines of a flat part against their table, and their radii against the solid's."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from fabgeo.arrays import Array
from fabgeo.review.findings import Findings
from fabgeo.review.flat_match import Match
from fabgeo.review.measured import FlatFile
from fabgeo.review.package import csv_rows, number
from fabgeo.review.rails import bending_sides
from fabgeo.review.solid_plate import SolidPlate

TABLE = 0.002  # mm: tables of bend lines carry three decimals
BEND = 0.005  # relative: a bend line's radius against its solid's; 29,389 needed 4.4e-7 1/mm
NEARLY_FLAT = 5e-6  # 1/mm: a plate that bends less is not compared
BENT = 1e-6  # 1/mm: its curvature, between two samples of the solid's


def bend_rows(path: Path) -> list[dict[str, str]]:
    """Rows of the table of bend lines beside a cut/parts file; empty if there is none."""
    return csv_rows(path.with_suffix(".bends.csv"))


def check_bends(flat: FlatFile, rows: list[dict[str, str]], findings: Findings, name: str) -> None:
    """Every bend line of the drawing is in its table, and none besides."""
    if len(rows) != len(flat.bends):
        words = f"{len(rows)} as in its table"
        findings.add(flat.mark, "bend lines in the drawing", words, len(flat.bends), name)
        return
    if not rows:
        return
    for k, row in enumerate(rows, 1):
        if row.get("bend") != str(k):
            findings.add(flat.mark, "number of a bend line in its table", k, row.get("bend"), name)
    columns = ("x1_mm", "y1_mm", "x2_mm", "y2_mm", "length_mm")
    stated = _columns(rows, columns)
    lengths = np.linalg.norm(flat.bends[:, 1] - flat.bends[:, 0], axis=1)
    drawn = np.column_stack([flat.bends.reshape(-1, 4), lengths])
    for k, column in np.argwhere(~(np.abs(stated - drawn) <= TABLE)).tolist():
        what = f"{columns[column]} of bend line {rows[k].get('bend')} in its table"
        findings.add(flat.mark, what, drawn[k, column], stated[k, column], name)


def _columns(rows: list[dict[str, str]], names: Iterable[str]) -> Array:
    """Numbers of some columns, nan where there is none."""
    values = [[number(row, name) for name in names] for row in rows]
    return np.array([[np.nan if v is None else v for v in own] for own in values])


def check_radii(
    flat: FlatFile,
    plate: SolidPlate,
    found: Match,
    rows: list[dict[str, str]],
    findings: Findings,
    name: str,
) -> None:
    """Radii of the bend lines are the solid's at the middles of the same rulings.

    A developable's radius grows linearly along a ruling: in its middle it is the mean of both ends.
    It is positive where the part bends towards the side from which it is drawn.
    """
    if found.rails is None or not rows or len(rows) != len(flat.bends):
        return
    bent = 1.0 / plate.radii.mean(axis=0)
    sites = np.linspace(0.0, len(bent) - 1.0, len(found.rails[0]))
    middle, lines = 0.5 * (found.rails[0] + found.rails[1]), flat.bends.mean(axis=1)
    near = np.linalg.norm(middle[None] - lines[:, None], axis=-1).argmin(axis=1)
    stated = 1.0 / _columns(rows, ["radius_mm"])[:, 0]
    sides = bending_sides(*plate.four_sided) * _drawn_side(found.rails)
    for row, at, own in zip(rows, sites[near].astype(int).tolist(), stated.tolist(), strict=True):
        own, way = abs(own), np.sign(own)
        around = bent[max(at - 1, 0) : at + 3]
        if around.min() > NEARLY_FLAT and (sides[max(at - 1, 0) : at + 3] == -way).all():
            what = f"sign of the radius of bend line {row.get('bend')}"
            findings.add(
                flat.mark, what, "-" if way > 0.0 else "+", "+" if way > 0.0 else "-", name
            )
        # At a knot the curvature has a peak; it lies within half a step of a sample.
        peak = BENT + 0.5 * float(np.abs(np.diff(around)).max(initial=0.0))
        low, high = (1.0 - BEND) * around.min() - peak, (1.0 + BEND) * around.max() + peak
        if max(own, float(around.min())) > NEARLY_FLAT and not low <= own <= high:
            what = f"radius of bend line {row.get('bend')} in mm"
            words = f"{1.0 / around.max():.1f} to {1.0 / around.min():.1f}"
            findings.add(flat.mark, what, words, 1.0 / own, name)


def _drawn_side(rails: tuple[Array, Array]) -> float:
    """+1 if a drawing shows the side of the strip's normals between its rails laid flat, (n, 2)."""
    (ax, ay), (bx, by) = rails[0][-1] - rails[0][0], rails[1][0] - rails[0][0]
    return float(np.sign(ax * by - ay * bx))
