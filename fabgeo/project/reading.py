"""Reading project files: every wrong key and value is named, with the nearest right one."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fabgeo.errors import InputError
from fabgeo.project.spelling import mean
from fabgeo.project.tables import Table
from fabgeo.project.whole import Project


def read_project(path: Path | str) -> Project:
    """Read and check a project file.

    Raises
    ------
    InputError
        If the file is missing, is no TOML, or holds unknown keys or wrong values; all of them are
        named together, unknown keys with the nearest known one.
    """
    path = Path(path)
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(str(path), "no such file", "check the path, or run: fabgeo init") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), f"cannot be read as UTF-8 text: {error}") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(str(path), f"is not valid TOML: {error}", "mend that line") from None
    return parse_project(data, str(path))


def parse_project(data: dict[str, Any], where: str = "project") -> Project:
    """Check project data that is already parsed; see `read_project`."""
    try:
        return Project.model_validate(data)
    except ValidationError as error:
        lines = [_line(item) for item in error.errors()]
        raise InputError(where, "; ".join(lines), "mend the keys named") from None


def _line(item: Any) -> str:
    path = ".".join(str(part) for part in item["loc"])
    if item["type"] == "extra_forbidden":
        keys = _keys_at(item["loc"][:-1])
        return f"unknown key {path}{mean(str(item['loc'][-1]), keys)}"
    if item["type"] == "missing":
        return f"[{path}] is missing" if "." not in path else f"{path} is missing"
    message = str(item["msg"]).removeprefix("Value error, ")
    found = "" if isinstance(item["input"], dict | list) else f", found {item['input']!r}"
    return (f"{path}: " if path else "") + message + found


def _keys_at(location: tuple[int | str, ...]) -> list[str]:
    table: Any = Project
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
