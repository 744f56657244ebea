"""Rows of boxes: a sound layout within milliseconds, always there before an engine has begun.

Glossary
--------
shelf
    A row of parts side by side along the sheet; as high as its highest part (first fit decreasing
    height, Coffman et al. 1980).
"""

from __future__ import annotations

from collections.abc import Sequence

from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.stock import Placement, Stock

type Layout = list[tuple[Stock, list[Placement]]]


def shelves(
    pieces: Sequence[Piece], stocks: Sequence[Stock], spacing: float, margin: float
) -> tuple[Layout, dict[str, str]]:
    """Lay all pieces in rows of boxes on as few sheets as that allows.

    Returns
    -------
    layout : list of (Stock, placements)
    unplaced : dict
        Marks that fit no stock (or found none left), by reason.
    """
    boxes = [_box(piece, stocks, margin) for piece in pieces]
    unplaced = {
        piece.mark: _too_large(piece, stocks, margin)
        for piece, box in zip(pieces, boxes, strict=True)
        if box is None
    }
    order = sorted((b for b in boxes if b is not None), key=lambda b: (-b.height, -b.width))
    sheets: list[_Open] = []
    left = {stock.name: stock.quantity for stock in stocks}
    for box in order:
        if any(sheet.take(box, spacing, margin) for sheet in sheets):
            continue
        for stock in sorted(stocks, key=_price):
            fresh = _Open(stock)
            if left[stock.name] != 0 and fresh.take(box, spacing, margin):
                sheets.append(fresh)
                count = left[stock.name]
                left[stock.name] = None if count is None else count - 1
                break
        else:
            unplaced[box.mark] = "no sheet of the stock is left for it"
    return [(sheet.stock, sheet.placements) for sheet in sheets], unplaced


def fits(piece: Piece, stock: Stock, margin: float) -> bool:
    """Whether the piece alone fits the stock in one of its trial rotations."""
    return _box(piece, [stock], margin) is not None


class _Box:
    def __init__(self, piece: Piece, rotation: float) -> None:
        x0, y0, x1, y1 = piece.box(rotation)
        self.mark, self.rotation = piece.mark, rotation
        self.low = (x0, y0)
        self.width, self.height = x1 - x0, y1 - y0


class _Open:
    def __init__(self, stock: Stock) -> None:
        self.stock = stock
        self.rows: list[list[float]] = []  # y, height, x reached
        self.placements: list[Placement] = []

    def take(self, box: _Box, spacing: float, margin: float) -> bool:
        right, top = self.stock.length - margin, self.stock.width - margin
        for row in self.rows:
            if box.height <= row[1] and row[2] + box.width <= right:
                self._put(box, row, spacing)
                return True
        y = self.rows[-1][0] + self.rows[-1][1] + spacing if self.rows else margin
        if y + box.height > top or margin + box.width > right:
            return False
        self.rows.append([y, box.height, margin])
        self._put(box, self.rows[-1], spacing)
        return True

    def _put(self, box: _Box, row: list[float], spacing: float) -> None:
        x, y = row[2] - box.low[0], row[0] - box.low[1]
        self.placements.append(Placement(box.mark, x, y, box.rotation))
        row[2] += box.width + spacing


def _box(piece: Piece, stocks: Sequence[Stock], margin: float) -> _Box | None:
    """The lowest box of the piece that fits some stock."""
    found = []
    for rotation in piece.trials():
        box = _Box(piece, rotation)
        if any(
            box.width <= s.length - 2 * margin and box.height <= s.width - 2 * margin
            for s in stocks
        ):
            found.append(box)
    return min(found, key=lambda b: b.height, default=None)


def _price(stock: Stock) -> float:
    return stock.cost if stock.cost is not None else stock.length * stock.width


def _too_large(piece: Piece, stocks: Sequence[Stock], margin: float) -> str:
    x0, y0, x1, y1 = piece.box(piece.trials()[0])
    largest = max(stocks, key=lambda s: s.length * s.width, default=None)
    if largest is None:
        return "there is no stock of its material and thickness"
    return (
        f"{x1 - x0:.0f} x {y1 - y0:.0f} mm fits no stock: the largest has "
        f"{largest.length - 2 * margin:.0f} x {largest.width - 2 * margin:.0f} mm within its margin"
    )
