"""Axes of cylinders and apexes of cones as the schedule states them, against the solids' rulings.

A cone's rulings pass through its apex at one angle to its axis, the half angle; a cylinder's are
parallel to its axis, and its edges lie at one distance from it, the radius.
"""

from __future__ import annotations

import re

import numpy as np

from fabgeo.arrays import Array, cross, unit
from fabgeo.review.findings import Findings
from fabgeo.review.package import number
from fabgeo.review.solid_plate import SolidPlate

APEX = 0.02  # mm: two decimals are written; whole panels missed it by 0.007 at most
SHORT = 2e-4  # mm: rulings that reach 300 times as far as they are long missed it by 0.03
ANGLE = 0.0015  # degrees: half angles have three decimals; rulings were off by 5e-4 at most
DISTANCE = 0.06  # mm: radii have one decimal
RADIUS = 1.5e-5  # relative: 500 edges were off by 4e-6 at most
NUMBERS = re.compile(r"\s*'?" + r"\s+".join([r"([-+.\deE]+)"] * 3))


def check_axis(
    mark: str, kind: str, row: dict[str, str], plate: SolidPlate, findings: Findings
) -> None:
    """Compare axis_or_apex and half_angle_deg of a cylinder's or cone's row with its solid."""
    text, rails = row.get("axis_or_apex") or "", plate.rails()
    if not text or rails is None:
        return
    place, _, direction = text.partition(";")
    found = [NUMBERS.fullmatch(words.rstrip()) for words in (place, direction)]
    try:
        point, axis = (np.array(own.groups() if own else (), dtype=float) for own in found)
    except ValueError:
        point, axis = np.empty(0), np.empty(0)
    if not (point.shape == axis.shape == (3,) and np.linalg.norm(axis) > 0.0):
        findings.add(mark, "axis_or_apex", "a point and a direction", text)
        return
    axis, rulings = unit(axis), unit(rails[1] - rails[0])
    sine = np.linalg.norm(cross(rulings, np.broadcast_to(axis, rulings.shape)), axis=1)
    angles = np.degrees(np.arctan2(sine, np.abs(rulings @ axis)))
    if kind == "cone":
        ways = np.linalg.norm(rails[1] - rails[0], axis=1), np.linalg.norm(point - rails[0], axis=1)
        within = APEX + SHORT * float((ways[1] / ways[0]).max())
        _cone(mark, row, angles, cross(point - rails[0], rulings), within, findings)
    else:
        _cylinder(mark, row, angles, cross(np.concatenate(rails) - point, axis), findings)


def _cone(
    mark: str,
    row: dict[str, str],
    angles: Array,
    missed: Array,
    within: float,
    findings: Findings,
) -> None:
    """Angles (n,) of the rulings to the axis, and how they miss the apex (n, 3)."""
    off = float(np.linalg.norm(missed, axis=1).max())
    if not off <= within:
        findings.add(
            mark, "axis_or_apex: apex on its solid's rulings", "on all", f"{off:.2f} mm off"
        )
    if float(np.ptp(angles)) > ANGLE:
        words = f"from {angles.min():.3f} to {angles.max():.3f} deg"
        findings.add(mark, "axis_or_apex: angle to its solid's rulings", "one", words)
        return
    half = number(row, "half_angle_deg")
    if half is not None:
        findings.near(mark, "half_angle_deg of its solid", float(angles.mean()), half, ANGLE)


def _cylinder(
    mark: str, row: dict[str, str], angles: Array, away: Array, findings: Findings
) -> None:
    """Angles (n,) of the rulings to the axis, and the edges' points from there (n, 3)."""
    if float(angles.max()) > ANGLE:
        words = f"{angles.max():.3f} deg off"
        findings.add(mark, "axis_or_apex: axis along its solid's rulings", "parallel", words)
        return
    radius = number(row, "radius_min_mm")
    if radius is not None:
        off = float(np.abs(np.linalg.norm(away, axis=1) - radius).max())
        if not off <= DISTANCE + RADIUS * radius:
            what = "axis_or_apex: radius_min_mm from its solid"
            findings.add(mark, what, f"{radius:.1f} mm", f"{off:.2f} mm off")
