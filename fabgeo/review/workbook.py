"""All schedules in one workbook: frozen and bold headers with units, filters, coloured verdicts.

openpyxl makes the workbook with its headers and styles; the many rows are put into its sheets as
text, which is ten times as quick as cell by cell.

Glossary
--------
line
    A row's cells as text, in the order of the columns.
"""

from __future__ import annotations

import datetime
import io
import os
import re
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

from fabgeo.review.columns import BOM, TABLES, Column

COLOURS = {"good": "FFD5E8F0", "warn": "FFFCE3B4", "fail": "FFF4C0B0"}
WIDE = ("reason", "marks")  # columns of sentences and lists
ILLEGAL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")  # in XML

type Lines = Sequence[Sequence[str]]


def write_workbook(path: Path, tables: dict[str, Lines]) -> Path:
    """Write the lines of all tables, by their names, as sheets of one xlsx file.

    Equal lines give equal files; SOURCE_DATE_EPOCH sets the date in the file.
    """
    from openpyxl import Workbook

    book, rows = Workbook(), {}
    book.remove(book.worksheets[0])
    for name, lines in tables.items():
        sheet = book.create_sheet(name)
        styles = _prepared(sheet, TABLES[name], len(lines))
        number = len(book.worksheets)
        rows[f"xl/worksheets/sheet{number}.xml"] = _rows_xml(TABLES[name], lines, styles)
    if not book.worksheets:
        book.create_sheet("bom").append([c.name for c in BOM])
    moment = _build_time()
    book.properties.creator = "fabgeo"
    book.properties.created = book.properties.modified = moment
    stream = io.BytesIO()
    book.save(stream)
    _repack(stream, path, rows, moment)
    return path


def _prepared(sheet: Any, columns: Sequence[Column], count: int) -> dict[str, int]:
    """Header, filters and print layout of a sheet; the styles of its cells by column or verdict."""
    from openpyxl.styles import Alignment, Font, PatternFill
    from openpyxl.utils import get_column_letter

    styles = {}
    for at, column in enumerate(columns, start=1):
        words = column.name
        if column.unit:
            words = f"{column.name.rsplit('_', 1)[0].replace('_', ' ')} [{column.unit}]"
        cell = sheet.cell(1, at, words.replace("_", " "))
        cell.font = Font(bold=True)
        cell.alignment = Alignment(wrap_text=True, vertical="top")
        sheet.column_dimensions[get_column_letter(at)].width = 40 if column.name in WIDE else 13
        sample = sheet.cell(2, at)
        if column.decimals is not None:
            sample.number_format = "0" + ("." + "0" * column.decimals if column.decimals else "")
        styles[column.name] = sample.style_id
    for at, (verdict, colour) in enumerate(COLOURS.items(), start=1):
        sample = sheet.cell(3, at)
        sample.fill = PatternFill("solid", fgColor=colour)
        styles[verdict] = sample.style_id
    sheet.delete_rows(2, 2)
    sheet.freeze_panes = "B2"
    sheet.auto_filter.ref = f"A1:{get_column_letter(len(columns))}{count + 1}"
    sheet.page_setup.orientation = "landscape"
    sheet.page_setup.fitToHeight = 0
    sheet.sheet_properties.pageSetUpPr.fitToPage = True
    sheet.print_title_rows = "1:1"
    return styles


def _rows_xml(columns: Sequence[Column], lines: Lines, styles: dict[str, int]) -> str:
    """Rows from the second on as the sheet's XML; numbers as numbers, all else as text."""
    from openpyxl.utils import get_column_letter

    letters = [get_column_letter(at) for at in range(1, len(columns) + 1)]
    rows = []
    for number, line in enumerate(lines, start=2):
        cells = []
        for column, letter, text in zip(columns, letters, line, strict=True):
            if not text:
                continue
            style = styles[column.name]
            if column.name == "verdict":
                style = styles.get(text, style)
            if column.decimals is not None and _is_number(text):
                cells.append(f'<c r="{letter}{number}" s="{style}"><v>{text}</v></c>')
            else:
                words = escape(ILLEGAL.sub("", text))
                cells.append(
                    f'<c r="{letter}{number}" s="{style}" t="inlineStr">'
                    f'<is><t xml:space="preserve">{words}</t></is></c>'
                )
        rows.append(f'<row r="{number}">{"".join(cells)}</row>')
    return "".join(rows)


def _is_number(text: str) -> bool:
    """Whether a text of a number's column is one that a cell can hold."""
    return text not in ("inf", "-inf") and re.fullmatch(r"-?\d+(\.\d+)?", text) is not None


def _repack(
    stream: io.BytesIO, path: Path, rows: dict[str, str], moment: datetime.datetime
) -> None:
    """Write the workbook's archive with its rows and one fixed time stamp."""
    stamp = (max(moment.year, 1980), *moment.timetuple()[1:6])
    with zipfile.ZipFile(stream) as source, zipfile.ZipFile(path, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name in rows:
                data = _filled(data.decode(), rows[name]).encode()
            if name == "docProps/core.xml":
                data = _fixed_core(data, moment)
            info = zipfile.ZipInfo(name, stamp)
            info.compress_type = zipfile.ZIP_DEFLATED
            target.writestr(info, data)


def _filled(sheet: str, rows: str) -> str:
    """A sheet's XML with its rows behind the header, and its size as its filter has it."""
    used = re.search(r'<autoFilter ref="([^"]*)"', sheet)
    if used is not None:
        sheet = re.sub(r'<dimension ref="[^"]*"', f'<dimension ref="{used[1]}"', sheet, count=1)
    head, end, tail = sheet.rpartition("</sheetData>")
    return head + rows + end + tail


def _fixed_core(data: bytes, moment: datetime.datetime) -> bytes:
    """The document properties with the build's time; openpyxl stamps "modified" when it saves."""
    stamp = moment.strftime("%Y-%m-%dT%H:%M:%SZ").encode()
    return re.sub(rb"(<dcterms:modified[^>]*>)[^<]*", rb"\g<1>" + stamp, data)


def _build_time() -> datetime.datetime:
    """SOURCE_DATE_EPOCH if set, else the start of 1980: schedules depend on their input alone."""
    epoch = int(os.environ.get("SOURCE_DATE_EPOCH", "315532800"))
    return datetime.datetime.fromtimestamp(epoch, datetime.UTC).replace(tzinfo=None)
