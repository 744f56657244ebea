"""What an engine packs: an outward-safe polygon of few vertices for every part.

Glossary
--------
outward-safe
    The polygon holds the exact contour; it is at most `2 GROWTH` larger, so that what an engine
    lays apart is apart. Few straight lines are packed as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import shapely

from fabgeo.arrays import Array, set_frozen
from fabgeo.panels.flat import FlatPart
from fabgeo.panels.unfold import smallest_rectangle
from fabgeo.sheets.biarc import part_contour
from fabgeo.sheets.contour import Contour
from fabgeo.sheets.verify import allowed_rotations

GROWTH = 1.0  # mm; engines slow down with vertices, the loss is a few tenths of a percent
MOST_VERTICES = 40
PLAIN = 24


@dataclass(frozen=True)
class Piece:
    """A part as the engines see it.

    Attributes
    ----------
    mark : str
    contour : Contour
        Exact outline.
    polygon : (k, 2) array
        Outward-safe, counter-clockwise.
    rotations : tuple of float or None
        Allowed rotations in radians; None: any.
    area : float
        Of the exact outline, mm2.
    """

    mark: str
    contour: Contour
    polygon: Array
    rotations: tuple[float, ...] | None
    area: float
    _boxes: dict[float, tuple[float, float, float, float]] = field(
        default_factory=dict, repr=False, compare=False
    )

    def __post_init__(self) -> None:
        set_frozen(self, "polygon", ("k", 2))

    def turned(self, rotation: float) -> Array:
        """Polygon rotated about the origin."""
        c, s = np.cos(rotation), np.sin(rotation)
        return self.polygon @ np.array([[c, s], [-s, c]])

    def box(self, rotation: float) -> tuple[float, float, float, float]:
        """Exact box of the part rotated about the origin: x and y least, x and y greatest."""
        if rotation not in self._boxes:
            self._boxes[rotation] = self.contour.moved(0.0, 0.0, rotation).bounds()
        return self._boxes[rotation]

    def trials(self) -> tuple[float, ...]:
        """A few rotations worth trying: those allowed, or the smallest rectangle's."""
        if self.rotations is not None:
            return self.rotations
        angle, _, _ = smallest_rectangle(self.polygon)
        return tuple(angle + k * np.pi / 2.0 for k in range(4))


def piece_of(
    part: FlatPart,
    tolerance: float = 0.05,
    rotations: tuple[float, ...] | str | None = None,
    growth: float = GROWTH,
) -> Piece:
    """Make the piece of a flat part; `rotations` None: by its grain, "free": any."""
    contour = part_contour(part, tolerance)
    allowed = allowed_rotations(part.grain) if rotations is None else rotations
    return Piece(
        mark=part.mark,
        contour=contour,
        polygon=safe_polygon(contour, growth),
        rotations=None if isinstance(allowed, str) or allowed is None else tuple(allowed),
        area=contour.area,
    )


def safe_polygon(contour: Contour, growth: float = GROWTH, most: int = MOST_VERTICES) -> Array:
    """Polygon of at most `most` vertices that holds the contour (tolerance grows if it must).

    A contour of `PLAIN` straight lines or fewer is its own polygon.
    """
    if len(contour.vertices) <= min(PLAIN, most) and not contour.vertices[:, 2].any():
        return contour.starts
    while True:
        exact = shapely.Polygon(contour.points(min(growth, 0.05), outside=True))
        # Grown by g with sharp corners, a line that strays less than g still holds the contour.
        grown = shapely.buffer(exact, growth, join_style="mitre", mitre_limit=5.0)
        coarse = shapely.simplify(grown, 0.95 * growth)
        points = shapely.get_coordinates(shapely.orient_polygons(coarse).exterior)[:-1]
        if len(points) <= most and shapely.contains(coarse, exact):
            return points
        growth *= 1.5
