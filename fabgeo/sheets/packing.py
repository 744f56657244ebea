"""PackingSolver as one call: pieces on one stock, layouts as placements.

Glossary
--------
sheet
    As much area of the pieces as possible on one sheet (a knapsack).
strip
    All pieces on a strip of fixed width, as short as possible.

The engine rotates a piece about its origin, then adds its `bl_corner`; so do our placements.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from importlib import import_module
from itertools import cycle
from typing import Any

import numpy as np

from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.stock import Placement, Stock

QUEUE = 16  # of the deterministic tree search: 1 CPU second for 24 candidates on a sheet
FEW, ROOMY = 25, 2.0  # pieces of a strip that begins short; areas of them on it
TRYING = 0.1  # of the seconds at most, to see whether they have room
STRIP = 4000.0  # its width to the engine, whose search does worse where numbers are small


def pack_sheet(
    pieces: Sequence[Piece],
    stock: Stock,
    spacing: float,
    margin: float,
    seconds: float | None = None,
    queue: int = QUEUE,
) -> list[Placement]:
    """As much area as possible on one sheet by the tree search: unverified.

    Equal input gives equal output unless `seconds` cut it short. Time grows with `queue`.
    """
    irregular = _engine()
    builder = _asked(irregular, pieces, spacing)
    builder.set_objective(irregular.Objective.Knapsack)
    shape = irregular.build_rectangle(stock.length - 2 * margin, stock.width - 2 * margin)
    builder.add_bin_type(shape, copies=1)
    parameters = _searching(irregular, seconds, queue)
    solution = irregular.optimize(builder.build(), parameters).solution
    sheets = _placed(solution, [[piece] for piece in pieces], margin)
    return sheets[0] if sheets else []


def pack_strip(
    pieces: Sequence[Piece], width: float, spacing: float, seconds: float
) -> list[Placement]:
    """All pieces on a strip of the given width, as short as found in time: unverified.

    What the engine finds depends on the length it begins on. `FEW` pieces begin on `ROOMY` times
    their area, or so much more that its quickest search places them all; more begin on a length
    that holds all one after the other.
    """
    irregular = _engine()
    end, scale, kinds = time.monotonic() + seconds, STRIP / width, alike(pieces)
    sizes = [float(np.linalg.norm(np.ptp(piece.polygon, axis=0))) + spacing for piece in pieces]

    def laid(room: float, parameters: Any) -> list[Placement]:
        builder = irregular.InstanceBuilder()
        builder.set_item_item_minimum_spacing(spacing * scale)
        for kind in kinds:
            shape = _shape(irregular, kind[0], scale)
            builder.add_item_type(shape, allowed_rotations=_degrees(kind[0]), copies=len(kind))
        builder.set_objective(irregular.Objective.OpenDimensionX)
        builder.add_bin_type(irregular.build_rectangle(room * scale, STRIP), copies=1)
        sheets = _placed(irregular.optimize(builder.build(), parameters).solution, kinds, 0.0)
        return [replace(p, x=p.x / scale, y=p.y / scale) for p in sheets[0]] if sheets else []

    room = sum(sizes)
    if len(pieces) <= FEW:
        short = max([ROOMY * sum(piece.area for piece in pieces) / width, *sizes])
        quick = _searching(irregular, TRYING * seconds, 1)
        while short < room and len(laid(short, quick)) < len(pieces):
            short *= ROOMY
        room = min(short, room)
    parameters = irregular.OptimizeParameters()
    parameters.verbosity_level = 0
    parameters.time_limit = max(end - time.monotonic(), 0.1)
    return laid(room, parameters)


def alike(pieces: Sequence[Piece]) -> list[list[Piece]]:
    """Pieces of the same polygon and rotations together: engines need not tell them apart."""
    kinds: dict[tuple[bytes, tuple[float, ...] | None], list[Piece]] = {}
    for piece in pieces:
        kinds.setdefault((piece.polygon.tobytes(), piece.rotations), []).append(piece)
    return list(kinds.values())


def _engine() -> Any:
    return import_module("packingsolver.irregular")


def _asked(irregular: Any, pieces: Sequence[Piece], spacing: float) -> Any:
    builder = irregular.InstanceBuilder()
    builder.set_item_item_minimum_spacing(spacing)
    for piece in pieces:
        shape = _shape(irregular, piece)
        builder.add_item_type(shape, allowed_rotations=_degrees(piece), copies=1)
    return builder


def _searching(irregular: Any, seconds: float | None, queue: int) -> Any:
    parameters = irregular.OptimizeParameters()
    parameters.verbosity_level = 0
    parameters.optimization_mode = irregular.OptimizationMode.NotAnytimeDeterministic
    parameters.use_tree_search = True
    parameters.not_anytime_tree_search_queue_size = queue
    if seconds is not None:
        parameters.time_limit = max(seconds, 0.1)
    return parameters


def _shape(irregular: Any, piece: Piece, scale: float = 1.0) -> Any:
    return irregular.build_shape([tuple(point) for point in (scale * piece.polygon).tolist()])


def _placed(
    solution: Any, kinds: Sequence[Sequence[Piece]], margin: float
) -> list[list[Placement]]:
    """Placements, sheet by sheet; every piece of a kind once, more than there are twice."""
    marks = [cycle([piece.mark for piece in kind]) for kind in kinds]
    return [
        [
            Placement(
                next(marks[item.item_type_id]),
                item.bl_corner.x + margin,
                item.bl_corner.y + margin,
                float(np.radians(item.angle)),
            )
            for item in found.items
        ]
        for k in range(solution.number_of_different_bins())
        for found in [solution.bin(k)]
        for _ in range(found.copies)
    ]


def _degrees(piece: Piece) -> list[tuple[float, float, bool]]:
    if piece.rotations is None:
        return [(0.0, 360.0, False)]
    return [(float(np.degrees(r)), float(np.degrees(r)), False) for r in piece.rotations]
