"""Flat parts and sheets of the page: every outline once, referred to by sheets and details."""

from __future__ import annotations

import math

import numpy as np

from fabgeo.arrays import Array
from fabgeo.panels.flat import FlatHole, FlatPart
from fabgeo.review import svg
from fabgeo.review.record import ReviewRecord

UNIT = 0.1  # mm: one step of the page's paths
TOLERANCE = 0.2  # mm: what an outline on the page may be off; the DXF is what is cut


def contour(part: FlatPart) -> Array:
    """Points (k, 2) of the closed outline, the first not repeated."""
    return np.concatenate([edge.points[:-1] for edge in part.outline])


def thinned(points: Array, tolerance: float = TOLERANCE) -> Array:
    """Fewer points of a closed contour, none off by more than the tolerance."""
    from shapely import LinearRing

    ring = LinearRing(points).simplify(tolerance, preserve_topology=True)
    return np.asarray(ring.coords)[:-1]


def hole_path(hole: FlatHole) -> str:
    """A round hole as a circle, a slot as its two circles joined."""
    if hole.slot <= 0.0:
        return svg.circle_path(hole.centre, hole.diameter / 2.0, UNIT)
    way = np.array([math.cos(hole.angle), math.sin(hole.angle)])
    across = np.array([-way[1], way[0]]) * hole.diameter / 2.0
    turn = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 9)[:, None]
    cap = np.cos(turn) * way * hole.diameter / 2.0 + np.sin(turn) * across
    half = way * hole.slot / 2.0
    points = np.concatenate([hole.centre + half + cap, hole.centre - half - cap])
    return svg.path(points, UNIT, closed=True)


def flat_symbols(record: ReviewRecord, numbers: dict[str, int]) -> str:
    """One group a flat part: outline, holes, bend lines; y turned upwards by whoever uses it."""
    groups = []
    for mark, number in numbers.items():
        part = record.flats[mark]
        points = contour(part)
        low, high = points.min(axis=0), points.max(axis=0)
        bends = _every(part.bends, 24)
        lines = "".join(
            svg.path(np.stack([b.start, b.end]), UNIT) for b in bends if math.isfinite(b.radius)
        )
        holes = "".join(hole_path(hole) for hole in part.holes)
        groups.append(
            f'<g id="f{number}" data-box="{low[0]:.1f} {low[1]:.1f} {high[0]:.1f} {high[1]:.1f}">'
            f'<path class="cut" d="{svg.path(thinned(points), UNIT, closed=True)}"/>'
            + (f'<path class="bend" d="{lines}"/>' if lines else "")
            + (f'<path class="hole" d="{holes}"/>' if holes else "")
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
                f'<use href="#f{numbers[p.mark]}" data-mark="{svg.text(p.mark)}" transform="'
                f"translate({p.x:.2f} {p.y:.2f}) rotate({math.degrees(p.rotation):.4f}) "
                f'scale({UNIT})"/>'
                for p in sheet.placements
                if p.mark in numbers
            )
            key = f"{nest.material}_{nest.thickness:g}mm/{sheet.name}"
            marks = ", ".join(p.mark for p in sheet.placements)
            figures.append(
                f'<figure class="sheet" data-sheet="{svg.text(key)}"><figcaption><b>'
                f"{svg.text(sheet.name)}</b> {svg.text(nest.material)} {nest.thickness:g} mm, "
                f"{length:g} x {width:g} mm, {len(sheet.placements)} parts, "
                f"{100.0 * sheet.utilisation:.1f} % used</figcaption>"
                f'<svg viewBox="-10 -10 {length + 20:g} {width + 20:g}" role="img">'
                f"<title>{svg.text(sheet.name)}: {svg.text(marks)}</title>"
                f'<g transform="matrix(1 0 0 -1 0 {width:g})"><rect class="stock" '
                f'width="{length:g}" height="{width:g}"/>{uses}</g></svg></figure>'
            )
        for mark, reason in sorted(nest.unplaced.items()):
            figures.append(f"<p class=unplaced>✗ {svg.text(mark)}: {svg.text(reason)}</p>")
    return "".join(figures)


def _every[T](items: tuple[T, ...], most: int) -> tuple[T, ...]:
    """At most `most` of the items, evenly picked."""
    if len(items) <= most:
        return items
    keep = np.linspace(0, len(items) - 1, most).round().astype(int)
    return tuple(items[k] for k in keep)
