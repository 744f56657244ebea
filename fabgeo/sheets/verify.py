"""The exact check of a layout, whoever made it: what an engine says never counts.

Glossary
--------
claim
    What a layout must fulfil: every part exactly once, inside the sheet less its margin, all parts
    apart by the spacing, rotations allowed, no more sheets of a stock than there are.

Contours are compared as polygons that hold every outward arc (tangents) at most `ARC` mm off, so
that a layout that passes keeps its claims within 2 `ARC`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from fabgeo.sheets.contour import Contour
from fabgeo.sheets.stock import Nest, Placement, Sheet

ARC = 0.005  # mm, of the polygons
SLACK = 0.02  # mm, what a distance may fall short of the claim


def allowed_rotations(grain: str) -> tuple[float, ...] | None:
    """Rotations in radians that a grain allows; None: any."""
    table = {
        "along": (0.0, np.pi),
        "steps": (0.0, np.pi / 2.0, np.pi, 1.5 * np.pi),
    }
    return table.get(grain)


def check_sheet(
    sheet: Sheet, contours: Mapping[str, Contour], spacing: float, margin: float
) -> list[str]:
    """Every violation on one sheet, in words; an empty list: the sheet is sound.

    Margins are measured on exact arcs; distances between all pairs of parts by shapely.
    """
    problems: list[str] = []
    stock = sheet.stock
    polygons = []
    for placement in sheet.placements:
        moved = contours[placement.mark].moved(placement.x, placement.y, placement.rotation)
        x0, y0, x1, y1 = moved.bounds()
        room = min(x0, y0, stock.length - x1, stock.width - y1)
        if room < margin - SLACK:
            problems.append(
                f"{sheet.name}: {placement.mark} is {room:.3f} mm from the edge, expected {margin}"
            )
        polygons.append(shapely.Polygon(moved.points(ARC, outside=True)))
    marks = [placement.mark for placement in sheet.placements]
    return problems + _too_near(sheet.name, marks, polygons, spacing)


def _too_near(
    name: str, marks: Sequence[str], polygons: Sequence[shapely.Polygon], spacing: float
) -> list[str]:
    problems = [
        f"{name}: the outline of {mark} crosses itself"
        for mark, polygon in zip(marks, polygons, strict=True)
        if not polygon.is_valid
    ]
    if problems or len(polygons) < 2:
        return problems
    shapes: np.ndarray = np.array(polygons, dtype=object)
    tree = shapely.STRtree(shapes)
    near = tree.query(shapes, predicate="dwithin", distance=max(spacing - SLACK, 0.0))
    for i, j in near.T:
        if i >= j:
            continue
        first, second = polygons[i], polygons[j]
        gap = float(shapely.distance(first, second))
        if gap > 0.0:
            problems.append(
                f"{name}: {marks[i]} and {marks[j]} are {gap:.3f} mm apart, expected {spacing}"
            )
            continue
        common: BaseGeometry = first.intersection(second)
        if spacing > 0.0 or _thickness(common) > SLACK:
            problems.append(f"{name}: {marks[i]} and {marks[j]} overlap by {common.area:.2f} mm2")
    return problems


def _thickness(overlap: BaseGeometry) -> float:
    """About the width of an overlap: touching parts share slivers thinner than the tolerance."""
    return 2.0 * overlap.area / overlap.length if overlap.length > 0.0 else 0.0


def check_nest(
    nest: Nest,
    contours: Mapping[str, Contour],
    rotations: Mapping[str, tuple[float, ...] | None] | None = None,
    quantities: Mapping[str, int] | None = None,
) -> list[str]:
    """Every violation of a whole nest.

    Parameters
    ----------
    contours : mapping
        Outer contour by mark of every part that was asked for.
    rotations : mapping, optional
        Allowed rotations by mark; None: any.
    quantities : mapping, optional
        How many of each mark were asked for; 1 where missing.
    """
    problems: list[str] = []
    placed = Counter(p.mark for sheet in nest.sheets for p in sheet.placements)
    for mark in sorted(contours):
        asked, found = (quantities or {}).get(mark, 1), placed[mark]
        if found > asked:
            problems.append(f"{mark} is placed {found} times, expected {asked}")
        if found < asked and mark not in nest.unplaced:
            problems.append(
                f"{mark} is placed {found} times, expected {asked}, and no reason given"
            )
    for mark in sorted(set(placed) - set(contours)):
        problems.append(f"{mark} is placed but was not asked for")
    for sheet in nest.sheets:
        if not all(p.mark in contours for p in sheet.placements):
            continue
        problems += check_sheet(sheet, contours, nest.spacing, nest.margin)
        problems += _turned(sheet.name, sheet.placements, rotations or {})
    return problems + _overdrawn(nest)


def _turned(
    name: str,
    placements: Sequence[Placement],
    rotations: Mapping[str, tuple[float, ...] | None],
) -> list[str]:
    problems = []
    for placement in placements:
        allowed = rotations.get(placement.mark)
        if allowed is None:
            continue
        away = np.array(allowed) - placement.rotation
        if np.abs(np.remainder(away + np.pi, 2 * np.pi) - np.pi).min() > 1e-6:
            degrees = np.degrees(placement.rotation)
            problems.append(f"{name}: {placement.mark} is turned by {degrees:.3f} deg: not allowed")
    return problems


def _overdrawn(nest: Nest) -> list[str]:
    used: dict[str, int] = {}
    limit = {sheet.stock.name: sheet.stock.quantity for sheet in nest.sheets}
    for sheet in nest.sheets:
        used[sheet.stock.name] = used.get(sheet.stock.name, 0) + 1
    return [
        f"stock {name}: {used[name]} used of {quantity}"
        for name, quantity in limit.items()
        if quantity is not None and used[name] > quantity
    ]
