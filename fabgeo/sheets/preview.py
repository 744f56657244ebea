"""Previews of sheets as SVG and PNG, and the figures a cutting shop asks for.

Pierces: see `fabgeo.sheets.drawn`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TypedDict
from xml.sax.saxutils import escape

import shapely

from fabgeo.panels.flat import FlatPart
from fabgeo.sheets.biarc import part_contour
from fabgeo.sheets.contour import Contour, hole_contour
from fabgeo.sheets.drawn import Drawn
from fabgeo.sheets.stock import Nest, Sheet


class SheetFigures(TypedDict):
    """Figures of a sheet or of a whole nest (mm, mm2 and kg)."""

    parts: int
    sheets: int
    parts_area_mm2: float
    sheet_area_mm2: float
    utilisation: float
    cut_length_mm: float
    pierces: int
    parts_mass_kg: float
    sheet_mass_kg: float


def sheet_figures(
    sheet: Sheet, parts: Mapping[str, FlatPart | Drawn], density: float = 7850.0
) -> SheetFigures:
    """Utilisation, weight, cut length and pierces of one sheet; density in kg/m3."""
    placed = [parts[placement.mark] for placement in sheet.placements]
    size = sheet.stock.length * sheet.stock.width
    flat = [part if isinstance(part, FlatPart) else part.part for part in placed]
    holes = [hole for part in flat for hole in part.holes]
    around = sum(math.pi * hole.diameter + 2.0 * hole.slot for hole in holes)
    area = sum(part.area for part in flat)
    per_area = sheet.stock.thickness * density * 1e-9
    return SheetFigures(
        parts=len(placed),
        sheets=1,
        parts_area_mm2=area,
        sheet_area_mm2=size,
        utilisation=area / size,
        cut_length_mm=around + sum(_outer(part).length for part in placed),
        pierces=len(placed) + len(holes),
        parts_mass_kg=area * per_area,
        sheet_mass_kg=size * per_area,
    )


def nest_figures(
    nest: Nest, parts: Mapping[str, FlatPart | Drawn], density: float = 7850.0
) -> SheetFigures:
    """The same over all sheets of a nest."""
    each = [sheet_figures(sheet, parts, density) for sheet in nest.sheets]
    size = sum(f["sheet_area_mm2"] for f in each)
    area = sum(f["parts_area_mm2"] for f in each)
    return SheetFigures(
        parts=sum(f["parts"] for f in each),
        sheets=len(each),
        parts_area_mm2=area,
        sheet_area_mm2=size,
        utilisation=area / size if size else 0.0,
        cut_length_mm=sum(f["cut_length_mm"] for f in each),
        pierces=sum(f["pierces"] for f in each),
        parts_mass_kg=sum(f["parts_mass_kg"] for f in each),
        sheet_mass_kg=sum(f["sheet_mass_kg"] for f in each),
    )


def _contours(part: FlatPart | Drawn) -> tuple[Contour, ...]:
    if isinstance(part, Drawn):
        return part.contours
    return (_outer(part), *(hole_contour(hole) for hole in part.holes))


def _outer(part: FlatPart | Drawn) -> Contour:
    return part.outer if isinstance(part, Drawn) else part_contour(part)


def sheet_svg(sheet: Sheet, parts: Mapping[str, FlatPart | Drawn], width: int = 900) -> str:
    """An SVG picture of a sheet: arcs stay arcs, marks are text, y points up."""
    stock = sheet.stock
    height = width * stock.width / stock.length
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height:.0f}" '
        f'viewBox="0 0 {stock.length:g} {stock.width:g}" role="img">',
        f"<title>{escape(sheet.name)}: {escape(stock.name)}, "
        f"{100.0 * sheet.utilisation:.1f} %</title>",
        f'<rect width="{stock.length:g}" height="{stock.width:g}" fill="#f4f4f2" '
        'stroke="#888" stroke-width="4"/>',
        f'<g transform="matrix(1 0 0 -1 0 {stock.width:g})" stroke="#1f4e79" stroke-width="3">',
    ]
    texts = []
    for placement in sheet.placements:
        own = _contours(parts[placement.mark])
        moved = [c.moved(placement.x, placement.y, placement.rotation) for c in own]
        path = " ".join(svg_path(contour) for contour in moved)
        lines.append(f'<path d="{path}" fill="#cfe0f0" fill-rule="evenodd"/>')
        at = shapely.point_on_surface(shapely.Polygon(moved[0].points(1.0)))
        size = min(60.0, stock.width / 25.0)
        texts.append(
            f'<text x="{at.x:.1f}" y="{stock.width - at.y:.1f}" font-size="{size:.0f}" '
            f'text-anchor="middle" font-family="sans-serif">{escape(placement.mark)}</text>'
        )
    return "\n".join([*lines, "</g>", *texts, "</svg>"])


def svg_path(contour: Contour) -> str:
    """The contour as an SVG path of lines and exact arcs."""
    x, y = contour.starts[0]
    words = [f"M{x:.3f} {y:.3f}"]
    each = zip(contour.ends, contour.vertices[:, 2], contour.radii, strict=True)
    for (x, y), bulge, radius in each:
        if bulge == 0.0 or radius > 1e7:
            words.append(f"L{x:.3f} {y:.3f}")
        else:
            large, sweep = int(abs(bulge) > 1.0), int(bulge > 0.0)
            words.append(f"A{radius:.3f} {radius:.3f} 0 {large} {sweep} {x:.3f} {y:.3f}")
    return "".join(words) + "Z"


def sheet_png(
    sheet: Sheet, parts: Mapping[str, FlatPart | Drawn], path: Path, dpi: int = 110
) -> None:
    """Write the same picture as PNG."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Polygon, Rectangle

    stock = sheet.stock
    figure = Figure(figsize=(10.0, 10.0 * stock.width / stock.length + 0.4), layout="constrained")
    axes = figure.add_subplot()
    axes.add_patch(
        Rectangle((0, 0), stock.length, stock.width, facecolor="#f4f4f2", edgecolor="#888")
    )
    for placement in sheet.placements:
        for k, contour in enumerate(_contours(parts[placement.mark])):
            points = contour.moved(placement.x, placement.y, placement.rotation).points(0.2)
            fill = "#cfe0f0" if k == 0 else "#f4f4f2"
            axes.add_patch(Polygon(points, facecolor=fill, edgecolor="#1f4e79", linewidth=0.8))
            if k == 0:
                at = shapely.point_on_surface(shapely.Polygon(points))
                axes.annotate(placement.mark, (at.x, at.y), ha="center", va="center", fontsize=7)
    axes.set_xlim(-0.01 * stock.length, 1.01 * stock.length)
    axes.set_ylim(-0.01 * stock.width, 1.01 * stock.width)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(
        f"{sheet.name}  {stock.material} {stock.thickness:g} mm  {stock.length:g} x "
        f"{stock.width:g}  {100.0 * sheet.utilisation:.1f} %",
        fontsize=9,
    )
    figure.savefig(path, dpi=dpi, metadata={"Software": None})
