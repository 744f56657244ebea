"""The schedules among themselves: marks once, the bill of materials, the workbook."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from zipfile import ZipFile

from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number

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
    _bill(package, findings)
    _workbook(package, findings)


def _bill(package: WrittenPackage, findings: Findings) -> None:
    """Counts, areas and masses of bom.csv are those of the rows that an item stands for."""
    tables = package.tables
    if not tables["bom"]:
        return
    groups: dict[tuple[str, str, str], list[Row]] = {}
    for row in tables["panels"]:
        item = f"panel, {row.get('class') or 'unclassified'}"
        groups.setdefault(_key(item, row), []).append(row)
    for row in tables["plates"]:
        item = f"plate, {(row.get('role') or '').replace('_', ' ')}"
        groups.setdefault(_key(item, row), []).append(row)
    for row in tables["connectors"]:
        groups.setdefault((f"connector, {row.get('product', '')}", "", ""), []).append(row)
    stated = {_key(row.get("item", ""), row): row for row in tables["bom"]
              if not row.get("note")}  # fmt: skip
    for key in sorted(groups.keys() | stated.keys()):
        name = f"bom {' '.join(word for word in key if word)}"
        own, row = groups.get(key, []), stated.get(key, {})
        findings.near(name, "count", len(own), number(row, "count") or 0.0, 0.0)
        for column, within in (("area_m2", 6e-5), ("mass_kg", 6e-3)):
            total = math.fsum(number(r, column) or 0.0 for r in own)
            slack = within + 6e-4 * len(own) * (column == "mass_kg")
            findings.near(name, column, total, number(row, column) or 0.0, slack)


def _key(item: str, row: Row) -> tuple[str, str, str]:
    return item, row.get("material") or "", row.get("thickness_mm") or ""


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
        lines = book[name].iter_rows(min_row=2, values_only=True)
        _same_rows(name, rows, [line for line in lines if any(v is not None for v in line)],
                   findings)  # fmt: skip


def _same_rows(
    name: str, rows: list[Row], lines: list[tuple[object, ...]], findings: Findings
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
