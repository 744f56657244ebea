"""Stock, placements, sheets and nests: what a nesting engine is asked and what it answers.

Glossary
--------
placement
    Rotate the part about its own origin by `rotation` (radians, counter-clockwise), then move by
    (x, y). Parts are never mirrored.
utilisation
    Area of the parts over the area of the sheets.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Stock:
    """A kind of sheet, board or remnant; sizes in mm, x along the length (and the grain)."""

    name: str
    material: str
    thickness: float
    length: float
    width: float
    quantity: int | None = None
    cost: float | None = None


@dataclass(frozen=True)
class Placement:
    """Where one part lies on a sheet."""

    mark: str
    x: float
    y: float
    rotation: float


@dataclass(frozen=True)
class Sheet:
    """One sheet with its parts; the origin is its lower left corner."""

    name: str
    stock: Stock
    placements: tuple[Placement, ...]
    utilisation: float


@dataclass(frozen=True)
class Nest:
    """All sheets of one material and thickness, and the parts that fit none, by reason."""

    material: str
    thickness: float
    sheets: tuple[Sheet, ...]
    unplaced: dict[str, str]
    utilisation: float
    spacing: float
    margin: float
