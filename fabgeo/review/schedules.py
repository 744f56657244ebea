"""The schedules: CSV files, one workbook with all of them, and the setting-out points.

The CSV names are the contract's; people read the workbook (`fabgeo.review.workbook`). Text that a
spreadsheet would run as a formula is disarmed.
"""

from __future__ import annotations

import csv
import math
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from fabgeo.review.columns import SETOUT, TABLES, Column
from fabgeo.review.record import ReviewRecord, Row
from fabgeo.review.verdicts import judged
from fabgeo.review.workbook import Lines, write_workbook
from fabgeo.sheets.preview import sheet_figures


def write_schedules(folder: Path, record: ReviewRecord) -> list[Path]:
    """Write schedules/*.csv, schedules/fabgeo.xlsx and setout/points.csv; return the files.

    Parameters
    ----------
    folder : Path
        The package's folder.
    """
    tables = tables_of(record)
    schedules, setout = folder / "schedules", folder / "setout"
    schedules.mkdir(parents=True, exist_ok=True)
    lines = {name: _lines(TABLES[name], rows) for name, rows in tables.items()}
    written = [
        _write_csv(schedules / f"{name}.csv", TABLES[name], own) for name, own in lines.items()
    ]
    written.append(write_workbook(schedules / "fabgeo.xlsx", lines))
    if record.setout:
        setout.mkdir(parents=True, exist_ok=True)
        own = _lines(SETOUT, setout_rows(record))
        written.append(_write_csv(setout / "points.csv", SETOUT, own))
    return written


def tables_of(record: ReviewRecord) -> dict[str, list[Row]]:
    """Every schedule's rows by table name; a table without rows was not asked for and is left out.

    Sheets and the bill of materials are counted from the nests and from the other tables.
    """
    record = judged(record)
    sheets = sheet_rows(record)
    tables = {
        "panels": list(record.panels),
        "plates": list(record.plates),
        "beams": list(record.beams),
        "cells": list(record.cells),
        "connectors": list(record.connectors),
        "sheets": sheets,
        "bom": bom_rows(record, sheets),
    }
    return {name: rows for name, rows in tables.items() if rows}


def sheet_rows(record: ReviewRecord) -> list[Row]:
    """One row a stock sheet, in the order of the nests."""
    rows: list[Row] = []
    for nest in record.nests:
        folder = f"cut/nests/{nest.material}_{nest.thickness:g}mm"
        for sheet in nest.sheets:
            size = sheet.stock.length * sheet.stock.width
            net = sum(record.flats[p.mark].area for p in sheet.placements if p.mark in record.flats)
            known = all(p.mark in record.flats for p in sheet.placements)
            density = record.materials.get(nest.material, {}).get("density_kg_m3")
            figures = sheet_figures(sheet, record.flats, density or 0.0) if known else None
            rows.append(
                {
                    "sheet": sheet.name,
                    "material": nest.material,
                    "thickness_mm": nest.thickness,
                    "stock": sheet.stock.name,
                    "length_mm": sheet.stock.length,
                    "width_mm": sheet.stock.width,
                    "parts": len(sheet.placements),
                    "marks": " ".join(p.mark for p in sheet.placements),
                    "utilisation": net / size,
                    "cut_length_mm": figures and figures["cut_length_mm"],
                    "pierces": figures and figures["pierces"],
                    "parts_mass_kg": figures["parts_mass_kg"] if figures and density else None,
                    "sheet_mass_kg": figures["sheet_mass_kg"] if figures and density else None,
                    "file": f"{folder}/{sheet.name}.dxf",
                }
            )
    return rows


def bom_rows(record: ReviewRecord, sheets: Sequence[Row]) -> list[Row]:
    """The bill of materials: plates by kind, material and thickness, connectors by product.

    Stock to buy is counted from the rows of `sheets`.
    """
    groups: dict[tuple[str, str, float], list[Row]] = defaultdict(list)
    for row in record.panels:
        key = (f"panel, {row.get('class') or 'unclassified'}", *_stock_key(row))
        groups[key].append(row)
    for row in record.plates:
        groups[(f"plate, {str(row.get('role', '')).replace('_', ' ')}", *_stock_key(row))].append(
            row
        )
    rows: list[Row] = [
        {
            "item": item,
            "material": material,
            "thickness_mm": thickness,
            "count": len(members),
            "area_m2": _total(members, "area_m2"),
            "mass_kg": _total(members, "mass_kg"),
        }
        for (item, material, thickness), members in sorted(groups.items())
    ]
    products: dict[str, list[Row]] = defaultdict(list)
    for row in record.connectors:
        products[str(row.get("product", ""))].append(row)
    rows += [
        {"item": f"connector, {key}", "count": len(own), "mass_kg": _total(own, "mass_kg")}
        for key, own in sorted(products.items())
    ]
    stock: dict[tuple[str, str, float], int] = defaultdict(int)
    for row in sheets:
        size = f"{row['length_mm']:g} x {row['width_mm']:g} mm"
        stock[(f"stock sheet {size}", str(row["material"]), float(row["thickness_mm"]))] += 1
    rows += [
        {"item": item, "material": material, "thickness_mm": t, "count": count, "note": "to buy"}
        for (item, material, t), count in sorted(stock.items())
    ]
    return rows


def setout_rows(record: ReviewRecord) -> list[Row]:
    """Rows of setout/points.csv in the record's order."""
    names = ("x", "y", "z"), ("nx", "ny", "nz")
    return [
        {
            "point": p.point,
            **dict(zip(names[0], p.position.tolist(), strict=True)),
            **dict(zip(names[1], p.normal.tolist(), strict=True)),
            "role": p.role,
            "mark": p.mark,
        }
        for p in record.setout
    ]


def cell_text(value: Any, decimals: int | None) -> str:
    """A value as CSV text: fixed decimals, empty for None and undefined numbers, disarmed text."""
    if value is None:
        return ""
    if decimals is None or isinstance(value, str):
        return disarmed(str(value))
    number = float(value)
    if math.isnan(number):
        return ""
    if math.isinf(number):
        return "inf" if number > 0 else "-inf"
    text = f"{number:.{decimals}f}"
    return text.removeprefix("-") if float(text) == 0.0 else text


def disarmed(text: str) -> str:
    """Text that no spreadsheet takes for a formula: an apostrophe before = + - @ tab and return."""
    return f"'{text}" if text[:1] in ("=", "+", "-", "@", "\t", "\r") else text


def _lines(columns: Sequence[Column], rows: Iterable[Row]) -> Lines:
    return [[cell_text(row.get(c.name), c.decimals) for c in columns] for row in rows]


def _write_csv(path: Path, columns: Sequence[Column], lines: Lines) -> Path:
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([column.name for column in columns])
        writer.writerows(lines)
    return path


def _stock_key(row: Row) -> tuple[str, float]:
    return str(row.get("material") or ""), float(row.get("thickness_mm") or 0.0)


def _total(rows: Iterable[Row], key: str) -> float | None:
    values = [row.get(key) for row in rows]
    return math.fsum(float(v) for v in values if v is not None) if any(values) else None
