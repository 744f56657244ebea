"""More pieces than are laid out together: some at a time."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from fabgeo.sheets.cover import Cover
from fabgeo.sheets.pieces import Piece
from fabgeo.sheets.shelf import Layout
from fabgeo.sheets.stock import remaining

if TYPE_CHECKING:
    from fabgeo.sheets.nest import Rules

BATCH, GIVEN_UP = 240, 2  # pieces of a batch, and sheets of it that the next one takes over


def batched(
    pieces: Sequence[Piece], rules: Rules, end: float, seed: int, steps: int | None
) -> Layout:
    """Many pieces, some at a time: a batch's worst sheets are given up to the next."""
    random = np.random.default_rng(seed)
    waiting = [pieces[int(k)] for k in random.permutation(len(pieces))]
    areas = {piece.mark: piece.area for piece in pieces}
    layout: Layout = []
    while waiting:
        now, some = time.monotonic(), waiting[:BATCH]
        share = len(some) / len(waiting)
        cover = Cover(some, rules, now + share * max(0.0, end - now), seed, steps)
        best = min(cover.layouts(), key=partial(_shortfall, len(some)))
        waiting = waiting[BATCH:]
        if not best:
            break
        if waiting:
            best = sorted(best, key=lambda s: sum(areas[p.mark] for p in s[1]) / s[0].price)
            by_mark = {piece.mark: piece for piece in some}
            few = min(GIVEN_UP, len(best) // 4)
            given_up = [by_mark[p.mark] for _, placed in best[:few] for p in placed]
            del best[:few]
            waiting = given_up + waiting
        layout += best
        rules = replace(rules, stocks=tuple(remaining(rules.stocks, best)))
    return layout


def _shortfall(count: int, layout: Layout) -> tuple[int, float]:
    return count - sum(len(placed) for _, placed in layout), sum(s.price for s, _ in layout)
