"""Sheets and the bill of materials against the rows that they count."""

from __future__ import annotations

import math
import re
from collections import Counter
from pathlib import PurePosixPath

from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number

SIDES = re.compile(r"(?:stock sheet )?([\d.]+) ?x ?([\d.]+)(?: mm)?")
ROUNDED = 0.006  # mm, of a thickness with two decimals

type Row = dict[str, str]
type Key = tuple[str, str, str]


def check_bill(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Compare sheets.csv with its files' names, bom.csv with all rows; nothing is measured here."""
    del measured
    stock = package.project.get("stock")
    named = {str(own.get("name")) for own in stock if isinstance(own, dict)} if isinstance(
        stock, list) else set()  # fmt: skip
    for row in package.tables["sheets"]:
        _sheet(row, named, findings)
    if package.tables["bom"]:
        _bill(package, findings)


def _sheet(row: Row, named: set[str], findings: Findings) -> None:
    """A sheet lies in the folder of its material and thickness, under its own name."""
    file = row.get("file", "")
    path = PurePosixPath(file)
    material, _, words = path.parent.name.rpartition("_")
    for key, expected in (("material", material), ("sheet", path.stem)):
        if row.get(key) and row[key] != expected:
            findings.add(file, f"{key} by its file's name", expected, row[key])
    thickness = number({"": words.removesuffix("mm")}, "")
    stated = number(row, "thickness_mm")
    if thickness is not None and stated is not None:
        findings.near(file, "thickness_mm by its folder", thickness, stated, ROUNDED)
    sides = SIDES.fullmatch(row.get("stock", ""))
    if sides and row["stock"] not in named:
        for key, words in zip(("length_mm", "width_mm"), sides.groups(), strict=True):
            expected, found = number({"": words}, ""), number(row, key)
            if expected is not None and found is not None:
                findings.near(file, f"{key} of its stock", expected, found, 0.5)


def _bill(package: WrittenPackage, findings: Findings) -> None:
    """Counts, areas and masses of bom.csv are those of the rows that an item stands for."""
    groups = _groups(package)
    rows = [(_key(row), row) for row in package.tables["bom"]]
    for key, count in Counter(key for key, _ in rows).items():
        if count > 1:
            findings.add(_words(key), "rows of this item", 1, count, "schedules/bom.csv")
    stated = dict(rows)
    for key in sorted(groups.keys() | stated.keys()):
        name, own, row = _words(key), groups.get(key, []), stated.get(key, {})
        findings.near(name, "count", len(own), number(row, "count") or 0.0, 0.0)
        if key[0].startswith("stock sheet"):
            continue
        for column, within in (("area_m2", 6e-5), ("mass_kg", 6e-3)):
            total = math.fsum(number(r, column) or 0.0 for r in own)
            slack = within + 6e-4 * len(own) * (column == "mass_kg")
            findings.near(name, column, total, number(row, column) or 0.0, slack)


def _groups(package: WrittenPackage) -> dict[Key, list[Row]]:
    """Rows of the other tables by the item of bom.csv that counts them."""
    groups: dict[Key, list[Row]] = {}
    items = (
        ("panels", lambda row: f"panel, {row.get('class') or 'unclassified'}"),
        ("plates", lambda row: f"plate, {(row.get('role') or '').replace('_', ' ')}"),
        ("connectors", lambda row: f"connector, {row.get('product', '')}"),
        ("sheets", lambda row: f"stock sheet {row.get('length_mm')} x {row.get('width_mm')} mm"),
    )
    for table, item in items:
        for row in package.tables[table]:
            groups.setdefault(_key({**row, "item": item(row)}), []).append(row)
    return groups


def _key(row: Row) -> Key:
    """Item, material and thickness; sides of stock to one decimal, as sheets.csv has them."""
    item = row.get("item", "")
    sides = SIDES.fullmatch(item)
    if sides:
        words = " x ".join(
            f"{number({'': side}, ''):.1f}".removesuffix(".0") for side in sides.groups()
        )
        item = f"stock sheet {words} mm"
    return item, row.get("material") or "", row.get("thickness_mm") or ""


def _words(key: Key) -> str:
    return f"bom {' '.join(word for word in key if word)}"
