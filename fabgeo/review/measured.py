"""What one step of the check hands to the next."""

from __future__ import annotations

from dataclasses import dataclass, field

from fabgeo.arrays import Array
from fabgeo.review.solid_plate import SolidPlate


@dataclass(frozen=True)
class FlatFile:
    """One cut/parts file in numbers.

    Attributes
    ----------
    mark : str
    outline : (n, 2) array
        Points of the closed outline.
    holes : (h, 4) array
        x, y, width and length of every hole (length = width for round ones).
    bends : (b, 2, 2) array
        Ends of the bend lines.
    area : float
        Net, in mm2.
    """

    mark: str
    outline: Array
    holes: Array
    bends: Array
    area: float


@dataclass
class Measured:
    """Everything measured so far."""

    plates: dict[str, SolidPlate] = field(default_factory=dict)
    volumes: dict[str, float] = field(default_factory=dict)
    centres: dict[str, Array] = field(default_factory=dict)
    names: dict[str, int] = field(default_factory=dict)
    flats: dict[str, FlatFile] = field(default_factory=dict)
    edge_errors: dict[str, Array] = field(default_factory=dict)
    """Flat length less the solid's of every edge, in the order of the plate's edges, mm."""
    on_sheets: dict[str, list[str]] = field(default_factory=dict)
    figures: dict[str, float] = field(default_factory=dict)

    def worst(self, key: str, value: float) -> None:
        """Keep the largest value seen of a figure."""
        self.figures[key] = max(self.figures.get(key, 0.0), value)
