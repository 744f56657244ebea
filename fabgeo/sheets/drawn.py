"""A flat part as it is cut: contours fitted, its mark placed.

Glossary
--------
pierces
    Times the beam or tool enters the sheet: one a contour.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fabgeo.panels.flat import FlatPart
from fabgeo.sheets.biarc import dense, part_contour
from fabgeo.sheets.contour import Contour, hole_contour
from fabgeo.sheets.dxf_document import DxfStyle
from fabgeo.sheets.mark import Mark, place_mark


@dataclass(frozen=True)
class Drawn:
    """A part ready to be nested and written anywhere: contours and mark in its own plane."""

    part: FlatPart
    outer: Contour
    holes: tuple[Contour, ...]
    label: Mark

    @property
    def mark(self) -> str:
        """The part's mark."""
        return self.part.mark

    @property
    def contours(self) -> tuple[Contour, ...]:
        """All that is cut: the outline, then the holes."""
        return (self.outer, *self.holes)


def drawn(part: FlatPart, style: DxfStyle | None = None) -> Drawn:
    """Fit contours and place the mark."""
    style = style or DxfStyle()
    outer = outer_contour(part, style)
    holes = tuple(hole_contour(hole) for hole in part.holes)
    return Drawn(part, outer, holes, place_mark(part.mark, outer, part.holes, style.mark_height))


def with_contour(part: FlatPart, style: DxfStyle) -> FlatPart:
    """The part with its contour fitted once, for nesting, files and pictures alike."""
    vertices = outer_contour(part, style).vertices
    return replace(part, contour=vertices, contour_tolerance=style.tolerance)


def outer_contour(part: FlatPart, style: DxfStyle) -> Contour:
    """The outline as nested and written: arcs and lines, or points of a polyline.

    Splines are written exactly; what is nested of them is their arcs and lines.
    """
    if style.outline != "polylines":
        return part_contour(part, style.tolerance)
    if part.contour is not None and not part.contour[:, 2].any():
        return part_contour(part, style.tolerance)
    import shapely

    pieces = []
    for edge in part.outline:
        points = edge.points if len(edge.points) == 2 else dense(edge)[0]
        line = shapely.simplify(shapely.LineString(points), style.tolerance * 0.9)
        pieces.append(shapely.get_coordinates(line)[:-1])
    points = np.concatenate(pieces)
    return Contour(np.column_stack([points, np.zeros(len(points))]))
