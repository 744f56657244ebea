"""Reading project files: every wrong key and value is named, with the nearest right one."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fabgeo.arrays import checked_path, read_text, shown
from fabgeo.errors import InputError
from fabgeo.project.whole import Project

LARGEST_FILE = 1 << 20
# Tables in tables without end: the parser's memory grows with the square of their number.
ENDLESS = re.compile(r"""(?<![\w-])(?:(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){100}""")


def read_project(path: Path | str) -> Project:
    """Read and check a project file.

    Raises
    ------
    InputError
        If the file is missing, is no TOML, or holds unknown keys or wrong values; all of them are
        named together, unknown keys with the nearest known one.
    """
    path = checked_path("project file", path)
    text = read_text(path, "check the path, or run: fabgeo init", LARGEST_FILE)
    try:
        if ENDLESS.search(text):
            raise ValueError("a key of more than 100 parts")
        data = tomllib.loads(text)
    except RecursionError:
        raise InputError(str(path), "is not valid TOML: nested without end", "mend it") from None
    except ValueError as error:
        raise InputError(str(path), f"is not valid TOML: {error}", "mend that line") from None
    return parse_project(data, str(path))


def parse_project(data: Mapping[str, Any], where: str = "project") -> Project:
    """Check project data that is already parsed; see `read_project`."""
    if not isinstance(data, Mapping) or not all(isinstance(key, str) for key in data):
        raise InputError(where, f"expected tables by their names, found {shown(data)}")
    try:
        return Project(**data)
    except InputError as error:
        raise InputError(where, error.problem, error.cure) from None
