"""What one step of the check hands to the next."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from fabgeo.arrays import Array
from fabgeo.review.solid_plate import SolidPlate

if TYPE_CHECKING:
    from fabgeo.review.check_neighbours import Joint


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


@dataclass(frozen=True)
class Piece:
    """A solid of a fixing's product: its name, its box from `low` to `high`, (3,) each.

    In the product's frame: z along the fixing's axis, from the flange's outer face to the panel.
    """

    name: str
    low: Array
    high: Array

    @property
    def kind(self) -> str:
        """Its name without size and number: bolt, washer, base plate."""
        return self.name.partition(" M")[0].rstrip("0123456789 ")

    @property
    def place(self) -> Array:
        """Middle (2,) of the box, seen along the axis."""
        return 0.5 * (self.low + self.high)[:2]


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
    roots: set[str] = field(default_factory=set)
    """Names of the assemblies that nothing in the model holds: one, the project's."""
    unsound: set[str] = field(default_factory=set)
    """Solids that are not one valid, closed solid turned outwards."""
    fixings: dict[tuple[str, ...], Array] = field(default_factory=dict)
    """Placement (4, 4) of every connector in the model, by the names from the root down to it."""
    products: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Name of the product that is placed in a connector, if it has one of its own."""
    pieces: dict[str, tuple[Piece, ...]] = field(default_factory=dict)
    """Of every product of fixings, by its name."""
    flats: dict[str, FlatFile] = field(default_factory=dict)
    edge_errors: dict[str, Array] = field(default_factory=dict)
    """Flat length less the solid's of every edge, in the order of the plate's edges, mm."""
    joints: list[Joint] = field(default_factory=list)
    """All that face each other, where every panel lies as it is stated to."""
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
        for product, pieces in other.pieces.items():  # a product may be in several shares
            own = self.pieces.get(product, ())
            known = {piece.name for piece in own}
            self.pieces[product] = (*own, *(piece for piece in pieces if piece.name not in known))
        self.parts += other.parts
        for name, count in other.names.items():
            self.names[name] = self.names.get(name, 0) + count
        self.unsound |= other.unsound
        self.roots |= other.roots
        for mark, names in other.on_sheets.items():
            self.on_sheets.setdefault(mark, []).extend(names)
        for key, value in other.figures.items():
            self.worst(key, value)

    def worst(self, key: str, value: float) -> None:
        """Keep the largest value seen of a figure."""
        self.figures[key] = max(self.figures.get(key, 0.0), value)
