"""The schedules among themselves: marks once, the workbook as the CSV files."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from zipfile import ZipFile

from fabgeo.review.columns import TABLES
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage

BOOK = "schedules/fabgeo.xlsx"
LARGEST_BOOK = 1 << 30  # bytes, unpacked

type Row = dict[str, str]


def check_tables(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Compare the tables with each other; nothing is measured here."""
    del measured
    for name, rows in package.tables.items():
        key = {"sheets": "file", "bom": None}.get(name, "mark")
        counts = Counter(row.get(key, "") for row in rows) if key else {}
        for mark, count in counts.items():
            if count != 1 or not mark:
                findings.add(mark or name, "rows of this mark", 1, count, f"schedules/{name}.csv")
    _workbook(package, findings)


def _workbook(package: WrittenPackage, findings: Findings) -> None:
    """The workbook holds the same rows as the CSV files."""
    from openpyxl import load_workbook

    path = package.folder / BOOK
    if not path.is_file():
        return
    try:
        with ZipFile(path) as archive:
            size = sum(info.file_size for info in archive.infolist())
        if size > LARGEST_BOOK:
            findings.add(BOOK, "workbook", "of bearable size", f"{size >> 20} MiB unpacked")
            return
        book = load_workbook(path, read_only=True)
    except Exception as error:  # whatever a broken archive raises in the library
        findings.add(BOOK, "workbook", "readable", str(error))
        return
    for name, rows in package.tables.items():
        if not rows:
            continue
        if name not in book.sheetnames:
            findings.add(BOOK, f"sheet {name}", "present", "missing")
            continue
        lines = [v for v in book[name].iter_rows(values_only=True) if any(x is not None for x in v)]
        if _same_headings(name, list(rows[0]), lines[0] if lines else (), findings):
            _same_rows(name, rows, lines[1:], findings)


def _same_headings(
    name: str, columns: list[str], headings: Sequence[object], findings: Findings
) -> bool:
    """Whether the workbook's headings are the names of the CSV's columns, units in brackets."""
    said = [str(heading) for heading in headings if heading is not None]
    units = {column.name: column.unit for column in TABLES[name]}
    expected = [_heading(column, units.get(column, "")) for column in columns]
    for words, column in zip(expected, columns, strict=True):
        if words not in said:
            findings.add(BOOK, f"heading of {column} in sheet {name}", words, "missing")
    for words in said:
        if words not in expected:
            findings.add(f"schedules/{name}.csv", "column by the workbook", words, "missing")
    if said != expected and sorted(said) == sorted(expected):
        findings.add(BOOK, f"headings of sheet {name}", "in the order of the CSV", "another")
    return len(said) == len(expected)


def _heading(column: str, unit: str) -> str:
    words = column.replace("_", " ")
    return f"{words.rpartition(' ')[0]} [{unit}]" if unit else words


def _same_rows(
    name: str, rows: list[Row], lines: Sequence[tuple[object, ...]], findings: Findings
) -> None:
    if len(rows) != len(lines):
        findings.add(BOOK, f"rows of {name}", len(rows), len(lines))
        return
    for row, line in zip(rows, lines, strict=True):
        for (column, text), value in zip(row.items(), _padded(line, len(row)), strict=False):
            if not _equal(text, value):
                who = row.get("mark") or row.get("file") or row.get("item") or name
                findings.add(who, f"{column} in the workbook", text, value, BOOK)


def _padded(line: tuple[object, ...], count: int) -> Iterable[object]:
    return (*line, *([None] * (count - len(line))))


def _equal(text: str | None, value: object) -> bool:
    """A CSV cell and a workbook's; numbers may be written otherwise."""
    if value is None:
        return not text
    if isinstance(value, int | float):
        try:
            return math.isclose(float(text or ""), value, rel_tol=1e-9, abs_tol=1e-12)
        except ValueError:
            return False
    return str(value) == (text or "")
