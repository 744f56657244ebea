"""The schedules: CSV files, one workbook with all of them, and the setting-out points.

The CSV names are the contract's; people read the workbook: frozen and bold headers with units,
filters, colours on verdicts. Text that a spreadsheet would run as a formula is disarmed.
"""

from __future__ import annotations

import csv
import datetime
import io
import math
import os
import re
import zipfile
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from fabgeo.review.columns import BOM, SETOUT, TABLES, Column
from fabgeo.review.record import ReviewRecord, Row
from fabgeo.review.verdicts import judged
from fabgeo.sheets.preview import sheet_figures

COLOURS = {"good": "FFD5E8F0", "warn": "FFFCE3B4", "fail": "FFF4C0B0"}


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
    written = [
        _write_csv(schedules / f"{name}.csv", TABLES[name], rows) for name, rows in tables.items()
    ]
    written.append(_write_xlsx(schedules / "fabgeo.xlsx", tables))
    if record.setout:
        setout.mkdir(parents=True, exist_ok=True)
        written.append(_write_csv(setout / "points.csv", SETOUT, setout_rows(record)))
    return written


def tables_of(record: ReviewRecord) -> dict[str, list[Row]]:
    """Every schedule's rows by table name; a table without rows was not asked for and is left out.

    Sheets and the bill of materials are counted from the nests and from the other tables.
    """
    record = judged(record)
    tables = {
        "panels": list(record.panels),
        "plates": list(record.plates),
        "beams": list(record.beams),
        "cells": list(record.cells),
        "connectors": list(record.connectors),
        "sheets": sheet_rows(record),
        "bom": bom_rows(record),
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


def bom_rows(record: ReviewRecord) -> list[Row]:
    """The bill of materials: plates by kind, material and thickness, connectors by product."""
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
    for row in sheet_rows(record):
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


def _write_csv(path: Path, columns: Sequence[Column], rows: Iterable[Row]) -> Path:
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([column.name for column in columns])
        for row in rows:
            writer.writerow([cell_text(row.get(c.name), c.decimals) for c in columns])
    return path


def _write_xlsx(path: Path, tables: dict[str, list[Row]]) -> Path:
    from openpyxl import Workbook

    book = Workbook()
    book.remove(book.worksheets[0])
    for name, rows in tables.items():
        _fill_sheet(book.create_sheet(name), TABLES[name], rows)
    if not book.worksheets:
        book.create_sheet("bom").append([c.name for c in BOM])
    moment = _build_time()
    book.properties.creator = "fabgeo"
    book.properties.created = book.properties.modified = moment
    stream = io.BytesIO()
    book.save(stream)
    _repack(stream, path, moment)
    return path


def _fill_sheet(sheet: Any, columns: Sequence[Column], rows: list[Row]) -> None:
    from openpyxl.styles import Alignment, Font, PatternFill
    from openpyxl.utils import get_column_letter

    fills = {key: PatternFill("solid", fgColor=value) for key, value in COLOURS.items()}
    for at, column in enumerate(columns, start=1):
        words = column.name
        if column.unit:
            words = f"{column.name.rsplit('_', 1)[0].replace('_', ' ')} [{column.unit}]"
        cell = sheet.cell(1, at, words.replace("_", " "))
        cell.font = Font(bold=True)
        cell.alignment = Alignment(wrap_text=True, vertical="top")
        letter = get_column_letter(at)
        sheet.column_dimensions[letter].width = 40 if column.name in ("reason", "marks") else 13
    for line, row in enumerate(rows, start=2):
        for at, column in enumerate(columns, start=1):
            value = row.get(column.name)
            if value is None:
                continue
            text = cell_text(value, column.decimals)
            number = column.decimals is not None and text not in ("", "inf", "-inf")
            cell = sheet.cell(line, at)
            if number and not isinstance(value, str):
                cell.value = float(text) if column.decimals else int(text)
                cell.number_format = "0" + ("." + "0" * column.decimals if column.decimals else "")
            else:
                cell.value = text
                cell.data_type = "s"
            if column.name == "verdict" and text in fills:
                cell.fill = fills[text]
    sheet.freeze_panes = "B2"
    sheet.auto_filter.ref = f"A1:{get_column_letter(len(columns))}{len(rows) + 1}"
    sheet.page_setup.orientation = "landscape"
    sheet.page_setup.fitToHeight = 0
    sheet.sheet_properties.pageSetUpPr.fitToPage = True
    sheet.print_title_rows = "1:1"


def _repack(stream: io.BytesIO, path: Path, moment: datetime.datetime) -> None:
    """Write the workbook's archive with one fixed time stamp: equal input gives equal files."""
    stamp = (max(moment.year, 1980), *moment.timetuple()[1:6])
    with zipfile.ZipFile(stream) as source, zipfile.ZipFile(path, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name == "docProps/core.xml":
                data = _fixed_core(data, moment)
            info = zipfile.ZipInfo(name, stamp)
            info.compress_type = zipfile.ZIP_DEFLATED
            target.writestr(info, data)


def _fixed_core(data: bytes, moment: datetime.datetime) -> bytes:
    """The document properties with the build's time; openpyxl stamps "modified" when it saves."""
    stamp = moment.strftime("%Y-%m-%dT%H:%M:%SZ").encode()
    return re.sub(rb"(<dcterms:modified[^>]*>)[^<]*", rb"\g<1>" + stamp, data)


def _build_time() -> datetime.datetime:
    """SOURCE_DATE_EPOCH if set, else the start of 1980: schedules depend on their input alone."""
    epoch = int(os.environ.get("SOURCE_DATE_EPOCH", "315532800"))
    return datetime.datetime.fromtimestamp(epoch, datetime.UTC).replace(tzinfo=None)


def _stock_key(row: Row) -> tuple[str, float]:
    return str(row.get("material") or ""), float(row.get("thickness_mm") or 0.0)


def _total(rows: Iterable[Row], key: str) -> float | None:
    values = [row.get(key) for row in rows]
    return math.fsum(float(v) for v in values if v is not None) if any(values) else None
