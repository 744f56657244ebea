"""Columns and tables that must not be empty, and the workbook's headings."""

from __future__ import annotations

from collections import defaultdict

from fabgeo.review.columns import TABLES
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number

OPTIONAL = frozenset({
    *("reason", "note", "kink_edge", "gap_edge", "sheet", "sheet_rotation_deg", "flange_mm"),
    *("radius_min_mm", "radius_max_mm", "surface_deviation_mm", "slit_max_mm", "slit_edges"),
    *("plank_sag_mm", "plank_yield", "edge_congruence_mm"),
    *("bevel_start_mm", "bevel_end_mm", "groove_deg", "weld_gap_mm"),
})  # fmt: skip
"""Columns that a sound part may leave empty beside others of its kind."""
SHAPED = frozenset({"radius_min_mm", "radius_max_mm"})
"""Of these, what every cylinder and cone has."""
STAGES = {
    "panels": (("P-",), ("schedules/panels.csv", "setout/points.csv")),
    "cells": (("C-",), ("schedules/cells.csv",)),
    "beams": (("B-",), ("schedules/beams.csv", "schedules/plates.csv")),
    "connectors": (("K-",), ("schedules/connectors.csv",)),
    "drawings": (("P-",), ("drawings/panels.pdf",)),
}
"""Stages by manifest.json: the marks that they put into the model, the files that tell of them."""

type Row = dict[str, str]


def check_columns(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Find cells without their number or word, and files that stages should have left."""
    for name, rows in package.tables.items():
        for kind in _by_kind(name, rows).values():
            _filled(name, kind, measured, findings)
    _files(package, measured, findings)


def _by_kind(name: str, rows: list[Row]) -> dict[str, list[Row]]:
    """Rows that have the same columns: of one class, of one role, items of one sort."""
    key = {"panels": "class", "plates": "role", "bom": "item"}.get(name, "")
    found: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        found[row.get(key, "").partition(",")[0].partition(" ")[0]].append(row)
    if name == "panels" and "" in found and len(found) > 1:  # a class is missing, not of a kind
        found[max(found, key=lambda kind: len(found[kind]) * bool(kind))] += found.pop("")
    return found


def _filled(name: str, rows: list[Row], measured: Measured, findings: Findings) -> None:
    """What most rows of a kind state, each states; numbers are numbers."""
    shaped = {row.get("class") for row in rows} & {"cylinder", "cone"}
    for column in TABLES[name]:
        key = column.name
        empty = [row for row in rows if not (row.get(key) or "").strip()]
        due = empty if key not in OPTIONAL or (shaped and key in SHAPED) else []
        if key == "sheet":
            due = [row for row in empty if row.get("mark") in measured.on_sheets]
        elif 2 * len(empty) > len(rows):  # rather the others are of another kind
            due = []
        for row in due:
            findings.add(_name(name, row), key, "stated", "empty", f"schedules/{name}.csv")
        if column.decimals is not None:
            for row in rows:
                found = number(row, key)
                if found is not None and found != found:
                    findings.add(_name(name, row), key, "a number", row[key])


def _name(table: str, row: Row) -> str:
    """How findings name a row."""
    if table == "bom":
        words = ("bom", row.get("item"), row.get("material"), row.get("thickness_mm"))
        return " ".join(word for word in words if word)
    return row.get("file" if table == "sheets" else "mark") or f"schedules/{table}.csv"


def _files(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Files of every stage that is asked for and whose parts are in the model or on sheets."""
    left_out = package.manifest.get("not_asked")
    left_out = left_out if isinstance(left_out, list) else []
    due = [
        file
        for stage, (starts, files) in STAGES.items()
        if stage not in left_out and any(name.startswith(starts) for name in measured.names)
        for file in files
    ]
    if package.sheet_files and "nesting" not in left_out:
        due.append("schedules/sheets.csv")
    if package.cut_rows:
        due += ["schedules/bom.csv", "schedules/fabgeo.xlsx"]
    for file in due:
        path = package.folder / file
        if not path.is_file() or (path.suffix == ".csv" and path.read_bytes().count(b"\n") < 2):
            findings.add(file, "file of a stage that the project asks for", "present", "missing")
