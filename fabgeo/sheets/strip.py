"""Strips: all pieces on a coil or board of given width, as short as possible; two engines.

Glossary
--------
density
    Area of the pieces over the strip's width times the length used.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import cycle

import numpy as np

from fabgeo.errors import PartError
from fabgeo.sheets.packing import alike, pack_strip
from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.shelf import shelves
from fabgeo.sheets.stock import Placement, Sheet, Stock
from fabgeo.sheets.verify import check_sheet

ENGINES = ("packingsolver", "spyrrow")


@dataclass(frozen=True)
class Strip:
    """A verified layout on a strip.

    Attributes
    ----------
    length : float
        mm used.
    density : float
    placements : tuple of Placement
    engine : str
        Which made it: "packingsolver", "spyrrow" or "rows".
    """

    length: float
    density: float
    placements: tuple[Placement, ...]
    engine: str


def nest_strip(
    pieces: Sequence[Piece],
    width: float,
    spacing: float = 0.0,
    seconds: float = 60.0,
    seed: int = 0,
    engines: Sequence[str] | None = None,
) -> Strip:
    """Lay all pieces (each mark once) on a strip: the shortest verified layout.

    Parameters
    ----------
    seconds : float
        Wall clock; the engines work side by side.
    engines : sequence of str, optional
        Of `ENGINES`. If None, both where there are more than two cores; else the first alone,
        which found shorter strips with both cores than the two with one each.

    Raises
    ------
    PartError
        If a piece is wider than the strip.
    """
    from joblib import cpu_count

    best = _rows(pieces, width, spacing)
    if engines is None:
        engines = ENGINES if cpu_count() > 2 else ENGINES[:1]

    def laid(engine: str) -> list[Placement]:
        if engine == "spyrrow":
            return _spyrrow(pieces, width, spacing, seconds, seed, 1 if len(engines) > 1 else 2)
        return pack_strip(pieces, width, spacing, seconds)

    with ThreadPoolExecutor(max(1, len(engines))) as pool:  # they work outside Python
        found = list(pool.map(laid, engines))
    for engine, placed in zip(engines, found, strict=True):
        made = _measured(pieces, width, spacing, placed, engine)
        if made is not None and made.length < best.length:
            best = made
    return best


def _rows(pieces: Sequence[Piece], width: float, spacing: float) -> Strip:
    reach = sum(float(np.linalg.norm(np.ptp(p.polygon, axis=0))) + spacing for p in pieces)
    layout, unplaced = shelves(pieces, [Stock("strip", "", 0.0, reach, width, 1)], spacing, 0.0)
    placed = layout[0][1] if layout else []
    made = _measured(pieces, width, spacing, placed, "rows") if not unplaced else None
    if made is None:  # one after the other always fits, unless a piece is too wide
        placed = _queue(pieces, width, spacing)
        made = _measured(pieces, width, spacing, placed, "rows")
    if made is None:
        raise PartError("strip", "the pieces laid one after the other fail the check")
    return made


def _queue(pieces: Sequence[Piece], width: float, spacing: float) -> list[Placement]:
    placements, x = [], 0.0
    for piece in pieces:
        for rotation in piece.trials():
            x0, y0, x1, y1 = piece.box(rotation)
            if y1 - y0 <= width:
                placements.append(Placement(piece.mark, x - x0, -y0, rotation))
                x += x1 - x0 + spacing
                break
        else:
            raise PartError(f"part {piece.mark}", f"is wider than the strip of {width:g} mm")
    return placements


def _measured(
    pieces: Sequence[Piece], width: float, spacing: float, placed: list[Placement], engine: str
) -> Strip | None:
    """The layout with its true length, or None if it is not sound."""
    contours = {piece.mark: piece.contour for piece in pieces}
    if sorted(p.mark for p in placed) != sorted(contours):
        return None
    ends = [contours[p.mark].moved(p.x, p.y, p.rotation).bounds() for p in placed]
    left, right = min(end[0] for end in ends), max(end[2] for end in ends)
    shifted = tuple(Placement(p.mark, p.x - left, p.y, p.rotation) for p in placed)
    length = right - left
    sheet = Sheet("strip", Stock("strip", "", 0.0, length, width), shifted, 0.0)
    if check_sheet(sheet, contours, spacing, 0.0):
        return None
    area = sum(piece.area for piece in pieces)
    return Strip(length, area / (length * width), shifted, engine)


def _spyrrow(
    pieces: Sequence[Piece], width: float, spacing: float, seconds: float, seed: int, workers: int
) -> list[Placement]:
    import spyrrow

    kinds = alike(pieces)
    items = [
        spyrrow.Item(
            str(k),
            [tuple(point) for point in kind[0].polygon.tolist()],
            len(kind),
            None if kind[0].rotations is None else np.degrees(kind[0].rotations).tolist(),
        )
        for k, kind in enumerate(kinds)
    ]
    marks = [cycle([piece.mark for piece in kind]) for kind in kinds]
    config = spyrrow.StripPackingConfig(
        early_termination=True,
        min_items_separation=spacing or None,
        total_computation_time=max(1, int(seconds)),
        num_workers=workers,
        seed=seed,
    )
    solution = spyrrow.StripPackingInstance("strip", width, items).solve(config)
    return [
        Placement(
            next(marks[int(item.id)]),
            float(item.translation[0]),
            float(item.translation[1]),
            float(np.radians(item.rotation)),
        )
        for item in solution.placed_items
    ]


def largest_remnant(sheet: Sheet, pieces: dict[str, Piece]) -> tuple[float, float]:
    """Length and width of the rectangle left free at the sheet's right end: stock for later."""
    right = 0.0
    for p in sheet.placements:
        right = max(right, pieces[p.mark].box(p.rotation)[2] + p.x)
    return sheet.stock.length - right, sheet.stock.width
