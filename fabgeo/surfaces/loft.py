"""The smooth surface through planar parallel sections."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array
from fabgeo.surfaces.parametric import ParametricSurface
from fabgeo.surfaces.quadgrid import interpolating_chart
from fabgeo.surfaces.sections import Sections


class SectionSurface(ParametricSurface):
    """The smooth surface through sections: bicubic, C2, every level between them planar too.

    u is the height along the planes' normal, v the mean arc length along corresponding points
    (periodic where the sections are closed). Two sections give a ruled surface, three a quadratic.

    Parameters
    ----------
    sections : Sections
    name : str
        For messages.
    columns : int, optional
        Corresponding points a section; default eight times the points of the longest, 160 to 480.

    Attributes
    ----------
    sections : Sections
    correspondence : str
        "parallel tangents" or "arc length".
    """

    def __init__(
        self, sections: Sections, name: str = "sections", columns: int | None = None
    ) -> None:
        self.sections = sections
        self.correspondence = "parallel tangents" if sections.convex else "arc length"
        most = max(len(p) for p in sections.points)
        count = columns or int(np.clip(8 * most, 160, 480))
        points = sections.grid(count)
        mean = float(np.mean([c.length for c in sections.curves]))
        ends = np.arange(count + 1) / count if sections.closed else np.linspace(0.0, 1.0, count)
        chart = interpolating_chart(
            points, False, sections.closed, rows=sections.heights, columns=mean * ends
        )
        super().__init__(name, [chart])

    def section_grid(self, columns: int) -> Array:
        """Corresponding points (sections, columns, 3): a start for strips between sections."""
        return self.sections.grid(columns)
