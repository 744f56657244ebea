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

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace


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

    @property
    def price(self) -> float:
        """Its cost, else its area; a remnant that costs nothing is a thousandth of its area."""
        size = self.length * self.width
        return max(size if self.cost is None else self.cost, 1e-3 * size)


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


def remaining(
    stocks: Sequence[Stock], used: Iterable[tuple[Stock, list[Placement]]]
) -> list[Stock]:
    """What is left of the stock after a layout."""
    taken = Counter(stock.name for stock, _ in used)
    return [
        stock if stock.quantity is None else replace(stock, quantity=left)
        for stock in stocks
        for left in [(stock.quantity or 0) - taken[stock.name]]
        if stock.quantity is None or left > 0
    ]
