"""What the page's scripts read: schedules column by column, parts as rails in short steps.

Glossary
--------
words
    The different values of a column; where they repeat, each stands once and rows tell its place.
steps
    Coordinates as 16 bit numbers within a part's own box.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.review import palette
from fabgeo.review.columns import TABLES, Column
from fabgeo.review.record import ReviewRecord
from fabgeo.review.schedules import tables_of

FAMILIES = ("panels", "cells", "beams", "connectors")
STRAIGHT = 1.0  # mm: what a rail may be off; under a pixel where one part fills the view


def page_data(record: ReviewRecord, flats: Sequence[str]) -> dict[str, Any]:
    """Everything the scripts need, as plain data.

    Parameters
    ----------
    record : ReviewRecord
        Judged.
    flats : sequence of str
        Marks of the flat parts in the order of their outlines on the page.
    """
    return {
        "name": record.name,
        "tables": {
            name: {
                "columns": [[c.name, c.unit, c.decimals] for c in TABLES[name]],
                "values": [_short([_cell(c, row.get(c.name)) for row in rows])
                           for c in TABLES[name]],
            }
            for name, rows in tables_of(record).items()
        },
        "flats": list(flats),
        "parts": _parts(record),
        "classes": palette.CLASSES,
        "verdicts": palette.VERDICTS,
        "signs": palette.SIGNS,
        "cividis": palette.CIVIDIS,
    }  # fmt: skip


def _cell(column: Column, value: Any) -> Any:
    """A value rounded as in the schedules."""
    if value is not None and column.decimals is not None and not isinstance(value, str):
        number = float(value)
        if not np.isfinite(number):
            return None if np.isnan(number) else ("∞" if number > 0 else "-∞")
        return round(number, column.decimals) if column.decimals else round(number)
    return value if value is None or isinstance(value, int | float) else str(value)


def _short(values: list[Any]) -> list[Any] | dict[str, list[Any]]:
    """A column as it is, or as its words and every row's place among them if that is shorter."""
    place: dict[Any, int] = {}
    at = [place.setdefault(value, len(place)) for value in values]
    words = {"words": list(place), "at": at}
    return min(values, words, key=lambda form: len(json.dumps(form, ensure_ascii=False)))


def _parts(record: ReviewRecord) -> dict[str, Any]:
    """Rails of all parts: an index, and steps after each other."""
    index, blocks = [], []
    for part in record.shown:
        rails = thinned_rails(part.rails)
        low = rails.min(axis=(0, 1))
        size = max(float((rails.max(axis=(0, 1)) - low).max()), 1e-6)
        blocks.append(np.rint((rails - low) / size * 65535.0).astype("<u2").ravel())
        entry = [part.mark, FAMILIES.index(part.family), *rails.shape[:2]]
        entry += [round(float(v), 1) for v in low] + [round(size, 2)]
        entry += [round(float(v), 3) for v in part.normal]
        index.append(entry + [part.row] * (part.row not in ("", part.mark)))
    packed = np.concatenate(blocks).tobytes() if blocks else b""
    return {"index": index, "steps": base64.b64encode(packed).decode()}


def thinned_rails(rails: Array, within: float = STRAIGHT) -> Array:
    """Every second point of the rails (N, k, 3) left out as long as none is off by more.

    The same points are left of every rail: faces between them stay ruled.
    """
    count = rails.shape[1]
    for stride in (8, 4, 2):
        if (count - 1) % stride or count <= stride:
            continue
        kept = rails[:, ::stride]
        share = (np.arange(count) % stride / stride)[:, None]
        before = np.repeat(kept[:, :-1], stride, axis=1)
        after = np.repeat(kept[:, 1:], stride, axis=1)
        straight = before + share[:-1] * (after - before)
        if np.linalg.norm(rails[:, :-1] - straight, axis=-1).max() <= within:
            return kept
    return rails
