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
    rims : tuple of (n, 2) arrays
        Their contours, in the same order.
    bends : (b, 2, 2) array
        Ends of the bend lines.
    area : float
        Net, in mm2.
    label : (2,) array
        Middle of the engraved mark; nan without one.
    """

    mark: str
    outline: Array
    holes: Array
    rims: tuple[Array, ...]
    bends: Array
    area: float
    label: Array


@dataclass(frozen=True)
class SheetFile:
    """One nested sheet in numbers: marks on it, net area of its parts in mm2, its stock's sides.

    `cut` is the length of all its contours in mm, `pierces` their number.
    """

    marks: tuple[str, ...]
    used: float
    size: tuple[float, float]
    cut: float
    pierces: int

    @property
    def whole(self) -> float:
        """Area of its stock in mm2."""
        return self.size[0] * self.size[1]


@dataclass
class Measured:
    """Everything measured so far."""

    plates: dict[str, SolidPlate] = field(default_factory=dict)
    volumes: dict[str, float] = field(default_factory=dict)
    centres: dict[str, Array] = field(default_factory=dict)
    cells: dict[str, Array] = field(default_factory=dict)
    """Points (k, 3) on the edges of every cell."""
    parts: int = 0
    """Placed solids of the model, the pieces of connectors too."""
    names: dict[str, int] = field(default_factory=dict)
    """How many parts have a name; a connector is one."""
    unsound: set[str] = field(default_factory=set)
    """Solids that are not one valid, closed solid turned outwards."""
    fixings: dict[tuple[str, ...], Array] = field(default_factory=dict)
    """Placement (4, 4) of every connector in the model, by the names from the root down to it."""
    products: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Name of the product that is placed in a connector, if it has one of its own."""
    flats: dict[str, FlatFile] = field(default_factory=dict)
    edge_errors: dict[str, Array] = field(default_factory=dict)
    """Flat length less the solid's of every edge, in the order of the plate's edges, mm."""
    on_sheets: dict[str, list[str]] = field(default_factory=dict)
    sheets: dict[str, SheetFile] = field(default_factory=dict)
    figures: dict[str, float] = field(default_factory=dict)

    def take(self, other: Measured) -> None:
        """Take in what was measured of other parts."""
        for name in (
            "plates",
            "volumes",
            "centres",
            "cells",
            "fixings",
            "products",
            "flats",
            "edge_errors",
            "sheets",
        ):
            getattr(self, name).update(getattr(other, name))
        self.parts += other.parts
        for name, count in other.names.items():
            self.names[name] = self.names.get(name, 0) + count
        self.unsound |= other.unsound
        for mark, names in other.on_sheets.items():
            self.on_sheets.setdefault(mark, []).extend(names)
        for key, value in other.figures.items():
            self.worst(key, value)

    def worst(self, key: str, value: float) -> None:
        """Keep the largest value seen of a figure."""
        self.figures[key] = max(self.figures.get(key, 0.0), value)
