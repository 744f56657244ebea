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

from collections.abc import Sequence
from importlib import import_module
from typing import Any

import numpy as np

from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.stock import Placement, Stock

QUEUE = 16  # of the deterministic tree search: 1 CPU second for 24 candidates on a sheet


def pack_sheet(
    pieces: Sequence[Piece],
    stock: Stock,
    spacing: float,
    margin: float,
    seconds: float | None = None,
    queue: int = QUEUE,
    worth: Sequence[float] | None = None,
) -> list[Placement]:
    """As much area (or `worth`) as possible on one sheet by the tree search: unverified.

    Equal input gives equal output unless `seconds` cut it short. Time grows with `queue`.
    """
    irregular = _engine()
    builder = _asked(irregular, pieces, spacing, worth)
    builder.set_objective(irregular.Objective.Knapsack)
    shape = irregular.build_rectangle(stock.length - 2 * margin, stock.width - 2 * margin)
    builder.add_bin_type(shape, copies=1)
    parameters = _searching(irregular, seconds, queue)
    sheets = _placed(irregular.optimize(builder.build(), parameters).solution, pieces, margin)
    return sheets[0] if sheets else []


def pack_strip(
    pieces: Sequence[Piece], width: float, spacing: float, seconds: float
) -> list[Placement]:
    """All pieces on a strip of the given width, as short as found in time: unverified."""
    irregular = _engine()
    builder = _asked(irregular, pieces, spacing)
    builder.set_objective(irregular.Objective.OpenDimensionX)
    reach = sum(float(np.linalg.norm(np.ptp(piece.polygon, axis=0))) for piece in pieces)
    builder.add_bin_type(irregular.build_rectangle(reach + spacing * len(pieces), width), copies=1)
    parameters = irregular.OptimizeParameters()
    parameters.verbosity_level = 0
    parameters.time_limit = max(seconds, 0.1)
    sheets = _placed(irregular.optimize(builder.build(), parameters).solution, pieces, 0.0)
    return sheets[0] if sheets else []


def _engine() -> Any:
    return import_module("packingsolver.irregular")


def _asked(
    irregular: Any, pieces: Sequence[Piece], spacing: float, worth: Sequence[float] | None = None
) -> Any:
    builder = irregular.InstanceBuilder()
    builder.set_item_item_minimum_spacing(spacing)
    for k, piece in enumerate(pieces):
        builder.add_item_type(
            irregular.build_shape([tuple(point) for point in piece.polygon.tolist()]),
            allowed_rotations=_degrees(piece),
            copies=1,
            profit=None if worth is None else worth[k],
        )
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


def _placed(solution: Any, pieces: Sequence[Piece], margin: float) -> list[list[Placement]]:
    return [
        [
            Placement(
                pieces[item.item_type_id].mark,
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
