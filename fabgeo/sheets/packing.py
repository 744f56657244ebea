"""PackingSolver as one call: pieces on one stock, layouts as placements.

Glossary
--------
bin packing
    All pieces on as few sheets as possible.
knapsack
    As much area of the pieces as possible on one sheet.

The engine rotates a piece about its origin, then adds its `bl_corner`; so do our placements.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Any, Literal

import numpy as np

from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.stock import Placement, Stock

type Task = Literal["bins", "knapsack"]


def pack(
    pieces: Sequence[Piece],
    stock: Stock,
    spacing: float,
    margin: float,
    seconds: float,
    task: Task = "bins",
    deterministic: bool = False,
) -> list[list[Placement]]:
    """Sheets of one stock as PackingSolver lays them: unverified.

    Parameters
    ----------
    seconds : float
        Wall clock; without effect where `deterministic`.
    """
    irregular: Any = import_module("packingsolver.irregular")
    builder = irregular.InstanceBuilder()
    objective = irregular.Objective
    builder.set_objective(objective.Knapsack if task == "knapsack" else objective.BinPacking)
    builder.set_item_item_minimum_spacing(spacing)
    shape = irregular.build_rectangle(stock.length - 2 * margin, stock.width - 2 * margin)
    copies = 1 if task == "knapsack" else len(pieces)
    if task == "bins" and stock.quantity is not None:
        copies = min(copies, stock.quantity)
    builder.add_bin_type(shape, copies=copies)
    for piece in pieces:
        builder.add_item_type(
            irregular.build_shape([tuple(point) for point in piece.polygon.tolist()]),
            allowed_rotations=_degrees(piece),
            copies=1,
        )
    parameters = irregular.OptimizeParameters()
    parameters.verbosity_level = 0
    mode = irregular.OptimizationMode
    if deterministic:
        parameters.optimization_mode = mode.NotAnytimeDeterministic
    else:
        parameters.time_limit = max(seconds, 0.1)
    solution = irregular.optimize(builder.build(), parameters).solution
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
