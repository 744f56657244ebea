"""What is wrong with project data, in words: every key and value, with the nearest right key."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import Any

from pydantic import ValidationError

from fabgeo.arrays import shown
from fabgeo.project.spelling import mean
from fabgeo.project.tables import Table

# pydantic adds the type that was tried to the place of a value that may have several.
TRIED = re.compile(r"(list|tuple|dict)\[.*\]|constrained-\w+|int|str|float")


def told(error: ValidationError, table: type[Table], data: object) -> str:
    """All that is wrong in the data of a table, in one line."""
    lines: dict[str, str] = {}
    for item in error.errors():
        location = tuple(_keys(item["loc"], data))
        key, problem = _line(item, location, table)
        lines[key] = f"{lines[key]}, or {problem}" if key in lines and key else key + problem
    return "; ".join(lines.values())


def _keys(location: Iterable[int | str], data: Any) -> Iterator[int | str]:
    """The parts of a place that are keys: of these data, or missing in them."""
    for part in location:
        try:
            data = data[part]  # a key, whatever its name
        except (LookupError, TypeError):
            if isinstance(part, str) and TRIED.fullmatch(part):
                continue
            data = None
        yield part


def _line(item: Any, location: tuple[int | str, ...], table: type[Table]) -> tuple[str, str]:
    """The key, and what is wrong with it."""
    path = ".".join(str(part) for part in location)
    if item["type"] == "extra_forbidden":
        return f"unknown key {path}", mean(str(location[-1]), _keys_at(location[:-1], table))
    if item["type"] == "missing":
        return (f"[{path}]" if "." not in path else path), " is missing"
    message = str(item["msg"]).removeprefix("Value error, ")
    found = "" if isinstance(item["input"], dict | list) else f", found {shown(item['input'])}"
    return (f"{path}: " if path else ""), message + found


def _keys_at(location: tuple[int | str, ...], whole: type[Table]) -> list[str]:
    table: Any = whole
    for part in location:
        if isinstance(part, int) or not hasattr(table, "model_fields"):
            continue
        field = table.model_fields.get(part)
        table = _table_in(field.annotation) if field else table
    return list(table.model_fields) if hasattr(table, "model_fields") else []


def _table_in(annotation: Any) -> Any:
    if isinstance(annotation, type) and issubclass(annotation, Table):
        return annotation
    inner = [_table_in(a) for a in getattr(annotation, "__args__", ())]
    return next((table for table in inner if table is not None), None)
