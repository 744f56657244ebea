"""Flat parts and sheets of the page: every outline once, referred to by sheets and details."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from fabgeo.arrays import Array
from fabgeo.panels.flat import FlatHole, FlatPart
from fabgeo.review import svg
from fabgeo.review.record import ReviewRecord

UNIT = 0.1  # mm: one step of the page's paths
BENDS = 12  # bend lines drawn of a part: all are in its file and in its table
TOLERANCE = 0.2  # mm: what an outline on the page may be off; the DXF is what is cut


def contour(part: FlatPart) -> Array:
    """Points (k, 2) of the closed outline, the first not repeated."""
    return np.concatenate([edge.points[:-1] for edge in part.outline])


def thinned(points: Array, tolerance: float = TOLERANCE) -> Array:
    """Fewer points of a closed contour, none off by more than the tolerance."""
    from shapely import LinearRing

    ring = LinearRing(points).simplify(tolerance, preserve_topology=True)
    return np.asarray(ring.coords)[:-1]


def hole_paths(holes: Sequence[FlatHole]) -> str:
    """Holes as strokes as wide as they are, with round ends: a point each, or a slot's line."""
    by_width: dict[float, list[FlatHole]] = defaultdict(list)
    for hole in holes:
        by_width[hole.diameter].append(hole)
    paths = []
    for width, own in by_width.items():
        centres = np.array([hole.centre for hole in own])
        angles = np.array([hole.angle for hole in own])
        halves = np.array([[0.5 * hole.slot] for hole in own])
        way = halves * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        drawn = svg.lines(centres - way, centres + way, UNIT)
        paths.append(f'<path class="hole" stroke-width="{width / UNIT:.0f}" d="{drawn}"/>')
    return "".join(paths)


def flat_symbols(record: ReviewRecord, numbers: dict[str, int]) -> str:
    """One group a flat part: outline, holes, bend lines; y turned upwards by whoever uses it."""
    groups = []
    for mark, number in numbers.items():
        part = record.flats[mark]
        points = contour(part)
        low, high = points.min(axis=0), points.max(axis=0)
        bent = _every([bend for bend in part.bends if math.isfinite(bend.radius)], BENDS)
        starts, ends = np.array([bend.start for bend in bent]), np.array([b.end for b in bent])
        groups.append(
            f'<g id="f{number}" data-box="{low[0]:.1f} {low[1]:.1f} {high[0]:.1f} {high[1]:.1f}">'
            f'<path class="cut" d="{svg.path(thinned(points), UNIT, closed=True)}"/>'
            + (f'<path class="bend" d="{svg.lines(starts, ends, UNIT)}"/>' if bent else "")
            + hole_paths(part.holes)
            + "</g>"
        )
    return f'<svg width="0" height="0" aria-hidden="true"><defs>{"".join(groups)}</defs></svg>'


def sheet_pictures(record: ReviewRecord, numbers: dict[str, int]) -> str:
    """Every sheet with its parts in place."""
    figures = []
    for nest in record.nests:
        for sheet in nest.sheets:
            length, width = sheet.stock.length, sheet.stock.width
            uses = "".join(
                f'<use href="#f{numbers[p.mark]}" transform="translate({p.x:.1f} {p.y:.1f}) '
                f'rotate({math.degrees(p.rotation):.6g}) scale({UNIT:g})"/>'
                for p in sheet.placements
                if p.mark in numbers
            )
            key = f"{nest.material}_{nest.thickness:g}mm/{sheet.name}"
            marks = ", ".join(p.mark for p in sheet.placements)
            figures.append(
                f'<figure class="sheet" data-sheet="{svg.text(key)}"><figcaption><b>'
                f"{svg.text(sheet.name)}</b> {svg.text(nest.material)} {nest.thickness:g} mm, "
                f"{length:g} x {width:g} mm, {_parts(len(sheet.placements))}, "
                f"{100.0 * sheet.utilisation:.1f} % used</figcaption>"
                f'<svg viewBox="-10 -10 {length + 20:g} {width + 20:g}" role="img">'
                f"<title>{svg.text(sheet.name)}: {svg.text(marks)}</title>"
                f'<g transform="matrix(1 0 0 -1 0 {width:g})"><rect class="stock" '
                f'width="{length:g}" height="{width:g}"/>{uses}</g></svg></figure>'
            )
        for mark, reason in sorted(nest.unplaced.items()):
            figures.append(f"<p class=unplaced>✗ {svg.text(mark)}: {svg.text(reason)}</p>")
    return "".join(figures)


def _parts(count: int) -> str:
    return f"{count} part" + "s" * (count != 1)


def _every[T](items: list[T], most: int) -> list[T]:
    """At most `most` of the items, evenly picked."""
    if len(items) <= most:
        return items
    keep = np.linspace(0, len(items) - 1, most).round().astype(int)
    return [items[k] for k in keep]
