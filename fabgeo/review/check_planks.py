"""Panels of geodesic strips as planks: how straight they lie, how much of a plank they are.

Glossary
--------
sag
    How far the middle line of a panel laid flat is off its chord.
yield
    Area of a panel over that of the smallest rectangle around it.
congruence
    How far a panel's long edge, laid flat, is from that of its neighbour turned over.
"""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number
from fabgeo.review.solid_plate import SolidPlate, developed

COLUMNS = ("plank_sag_mm", "plank_yield", "edge_congruence_mm")
SAG = 0.01, 1e-3  # mm, and relative
YIELD = 2e-4
COUNT = 65

type Row = dict[str, str]


def check_planks(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Only geodesic strips are planks; these lie as straight as their solids laid flat."""
    kind = package.setting("strips", "kind", None)
    for row in package.tables["panels"]:
        mark = row.get("mark", "")
        if kind is not None and kind != "geodesic":
            for key in COLUMNS:
                if row.get(key):
                    findings.add(mark, key, f"none for strips of kind {kind}", row[key])
            continue
        plate, sag = measured.plates.get(mark), number(row, "plank_sag_mm")
        if sag is not None and plate is not None and plate.rails() is not None:
            found = _sag(plate)
            findings.near(mark, "plank_sag_mm of its solid", found, sag, SAG[0] + SAG[1] * found)
        _yield(mark, row, findings)


def _yield(mark: str, row: Row, findings: Findings) -> None:
    """Area over the rectangle's, of the row's own figures: others compare these with the files."""
    stated, area = number(row, "plank_yield"), number(row, "area_m2")
    length, width = number(row, "flat_length_mm"), number(row, "flat_width_mm")
    if stated is not None and area and length and width:
        findings.near(mark, "plank_yield of its area", 1e6 * area / (length * width), stated, YIELD)


def _sag(plate: SolidPlate) -> float:
    """Largest distance of the middle line from its chord, both edges taken at even lengths."""
    first, second = (_even(edge) for edge in developed(*plate.four_sided))
    middle = 0.5 * (first + second)
    chord, away = middle[-1] - middle[0], middle - middle[0]
    rise = away[:, 0] * chord[1] - away[:, 1] * chord[0]
    return float(np.abs(rise).max() / np.linalg.norm(chord))


def _even(points: Array) -> Array:
    """Points (COUNT, 2) at even lengths along a fine line (n, 2)."""
    way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    at = np.linspace(0.0, way[-1], COUNT)
    return np.column_stack([np.interp(at, way, points[:, k]) for k in (0, 1)])
