"""Tables that flow through the columns of a page and go on where there is room.

Glossary
--------
column
    A part of the page that tables are set into from its top, one under the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from fabgeo.review.paper import Box, Paper

STEP = 10.5  # points from line to line
HEAD = 4.0 + STEP  # of the title over the table and of the table's own head
GAP = 15.0  # to the next title
LEAST = 3  # lines of a table that are worth its head


class Table(NamedTuple):
    """A table with its title; every line holds a text for each of the heads."""

    title: str
    heads: tuple[str, ...]
    lines: tuple[tuple[str, ...], ...]
    widths: tuple[float, ...]


class Set(NamedTuple):
    """A table, or a piece of it, with its title at (x, y)."""

    x: float
    y: float
    table: Table


def flow(tables: Sequence[Table], columns: Sequence[Box]) -> tuple[list[Set], list[Table]]:
    """Set tables into columns in their order; returns them and what has found no room."""
    found: list[Set] = []
    rest = [table for table in tables if table.lines]
    for column in columns:
        y = column.y + column.height - 7.0
        while rest:
            table, *after = rest
            room = int((y - column.y - HEAD) // STEP)
            if room < min(LEAST, len(table.lines)):
                break
            found.append(Set(column.x, y, table._replace(lines=table.lines[:room])))
            y -= HEAD + STEP * len(table.lines[:room]) + GAP
            rest = after
            if table.lines[room:]:
                title = table.title.partition(" (")[0].removesuffix(", continued") + ", continued"
                rest = [table._replace(title=title, lines=table.lines[room:]), *after]
                break
    return found, rest


def draw_tables(paper: Paper, tables: Sequence[Set]) -> None:
    """Draw what `flow` has set."""
    for x, y, table in tables:
        paper.heading(x, y, table.title)
        paper.table(x, y - 4.0, table.heads, table.lines, table.widths)
