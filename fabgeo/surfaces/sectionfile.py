"""Section files: CSV and JSON."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.surfaces.sections import Sections, checked_sections

COLUMNS = ("section", "x", "y", "z")
LARGEST_FILE = 128 << 20


def read_sections(path: str | Path, closed: bool | None = None) -> Sections:
    """Planar parallel sections from a CSV or JSON file, in the file's own unit.

    CSV: a header with the columns section, x, y, z (others are passed over); rows of one section
    follow each other along it. JSON: a list of objects ``{"z": 3.5, "points": [[x, y], ...]}`` or
    ``{"points": [[x, y, z], ...]}``, each with an optional ``"name"``; or such a list under the
    key ``"sections"``.

    Raises
    ------
    InputError
        With the line or section concerned, and whatever `sections.checked_sections` refuses.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(str(path), "there is no such file", "check the path")
    if path.stat().st_size > LARGEST_FILE:
        raise InputError(path.name, f"the file is larger than {LARGEST_FILE >> 20} MiB")
    text = path.read_text(encoding="utf-8-sig", errors="replace")
    parse = parse_json if path.suffix.lower() == ".json" else parse_csv
    names, curves = parse(path.name, text)
    return checked_sections(path.name, curves, names, closed)


def parse_csv(name: str, text: str) -> tuple[list[str], list[Array]]:
    """Names and points (k, 3) of the sections of a CSV text."""
    delimiter = ";" if text.split("\n", 1)[0].count(";") >= 3 else ","
    reader = csv.reader(io.StringIO(text), delimiter=delimiter)
    sections: dict[str, list[list[float]]] = {}
    place: list[int] = []
    try:
        for row in reader:
            where = f"{name}, line {reader.line_num}"
            words = [word.strip() for word in row]
            if not any(words) or words[0].startswith("#"):
                continue
            if not place:
                place = _columns(where, [w.lower() for w in words])
                continue
            if len(words) <= max(place):
                raise InputError(where, f"expected {max(place) + 1} columns, found {len(words)}")
            label, *numbers = (words[k] for k in place)
            sections.setdefault(label, []).append(_numbers(where, numbers))
    except csv.Error as error:
        raise InputError(f"{name}, line {reader.line_num}", f"is not CSV: {error}") from error
    return list(sections), [np.array(points) for points in sections.values()]


def _columns(where: str, header: list[str]) -> list[int]:
    missing = [column for column in COLUMNS if column not in header]
    if missing:
        raise InputError(
            where,
            f"expected a header with the columns {', '.join(COLUMNS)}; {missing[0]} is missing",
            "add the header line",
        )
    return [header.index(column) for column in COLUMNS]


def _numbers(where: str, words: list[Any]) -> list[float]:
    try:
        values = [float(word) for word in words]
    except (TypeError, ValueError):
        raise InputError(where, f"expected numbers, found {words!r}"[:200]) from None
    if not np.isfinite(values).all():
        raise InputError(where, f"a coordinate is not finite: {words!r}"[:200], "remove the point")
    return values


def parse_json(name: str, text: str) -> tuple[list[str], list[Array]]:
    """Names and points (k, 3) of the sections of a JSON text."""
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(name, f"is not JSON: {error}") from error
    if isinstance(content, dict):
        content = content.get("sections")
    if not isinstance(content, list):
        raise InputError(name, 'expected a list of sections, or {"sections": [...]}')
    names, curves = [], []
    for k, entry in enumerate(content):
        where = f"{name}, section {k}"
        if not isinstance(entry, dict) or not isinstance(entry.get("points"), list):
            raise InputError(where, 'expected an object with "points", a list of points')
        points = []
        for i, point in enumerate(entry["points"]):
            at = f"{where}, point {i}"
            if not isinstance(point, list) or len(point) not in (2, 3):
                raise InputError(at, f"expected [x, y] or [x, y, z], found {point!r}"[:200])
            if len(point) == 2 and "z" not in entry:
                raise InputError(at, 'has no z, and the section has no "z"', 'add "z": height')
            points.append(_numbers(at, [*point, entry["z"]] if len(point) == 2 else point))
        names.append(str(entry.get("name", k)))
        curves.append(np.array(points).reshape(-1, 3))
    return names, curves
