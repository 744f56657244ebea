"""Faults in one cell of a schedule or a setting-out point: each is named by part and column."""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import openpyxl
import pytest
from test_check_real import PROJECT

from fabgeo.build import build_package
from fabgeo.project import parse_project
from fabgeo.review.check import check_package
from fabgeo.review.findings import Finding
from fabgeo.review.manifest import package_files, sha256_of

pytestmark = pytest.mark.slow

POINTS = "setout/points"


def times(by: float) -> Callable[[str], str]:
    return lambda text: f"{float(text) * by:.{len(text.partition('.')[2])}f}"


def plus(by: float) -> Callable[[str], str]:
    return lambda text: f"{float(text) + by:.{len(text.partition('.')[2])}f}"


def to(text: str) -> Callable[[str], str]:
    return lambda _: text


def far_apex(text: str) -> str:
    x, _, rest = text.removeprefix("'").partition(" ")
    return f"'{float(x) + 500.0:.2f} {rest}"


FAULTS: list[tuple[str, str, str, Callable[[str], str]]] = [
    ("panels", "P-01-01", "axis_or_apex", far_apex),
    ("panels", "P-00-00", "connectors", plus(1)),
    ("panels", "P-00-00", "cell", plus(1)),
    ("panels", "P-00-01", "mass_kg", to("")),
    ("panels", "P-00-01", "transport", to("")),
    ("panels", "P-01-00", "box_length_mm", plus(30.0)),
    ("panels", "P-02-01", "kink_edge", to("P-00-01")),
    ("panels", "P-02-01", "slit_max_mm", to("9.0")),
    ("panels", "P-02-00", "forming", to("flat")),
    ("panels", "P-00-01", "flange_mm", plus(4.0)),
    ("panels", "P-00-00", "developability_mm", to("0.50000")),
    ("panels", "P-00-00", "plank_sag_mm", to("4.000")),
    ("panels", "P-00-00", "edge_congruence_mm", to("4.0000")),
    ("plates", "W-01-00", "bevel_start_mm", to("3.00")),
    ("plates", "B-01-1-WEB", "bevel_end_mm", to("3.00")),
    ("beams", "B-03-1", "groove_deg", to("30.0")),
    ("beams", "B-03-1", "weld_gap_mm", to("3.00")),
    ("plates", "B-01-1-FLO", "camber_mm", plus(5.0)),
    ("plates", "B-01-1-FLI", "role", to("web")),
    ("plates", "W-01-01", "parent", to("W-02-01")),
    ("beams", "B-02-1", "length_mm", times(1.01)),
    ("beams", "B-02-1", "depth_min_mm", plus(-5.0)),
    ("beams", "B-02-1", "depth_max_mm", plus(-1.0)),
    ("beams", "B-02-1", "edge", plus(1)),
    ("cells", "C-01-01", "box_height_mm", plus(100.0)),
    ("cells", "C-01-01", "strip", plus(1)),
    ("connectors", "K-01-00-1", "panel", to("P-00-00")),
    ("connectors", "K-01-00-1", "beam", to("B-03-1")),
    ("connectors", "K-01-00-2", "mass_kg", times(1.2)),
    ("sheets", "SHEET-001", "material", to("oak")),
    ("sheets", "SHEET-001", "thickness_mm", plus(1.0)),
    ("bom", "plate, web", "count", plus(1)),
    ("bom", "stock sheet 8000 x 6000 mm", "count", plus(1)),
    (POINTS, "P-00-01/2", "nx", lambda text: f"{-float(text):.8f}"),
    (POINTS, "P-00-01/3", "role", to("beam node")),
    (POINTS, "P-00-01/4", "point", to("P-00-01/9")),
    (POINTS, "B-01-1/1", "nx", plus(0.03)),
    (POINTS, "K-00-00-1", "nx", plus(0.03)),
]
WORDS = {"nx": "normal of", "point": "name of", "role": "role of"}
"""How findings begin of columns that they do not name."""


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pavilion") / "out"
    build_package(parse_project(PROJECT), folder)
    return folder


@pytest.fixture(scope="module")
def found(package: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Finding]:
    """What is found where all faults are in, the workbook aside, which is as it was."""

    def spoil(folder: Path) -> None:
        for table, name, column, change in FAULTS:
            spoilt(folder, table, name, column, change)

    findings = after(package, tmp_path_factory.mktemp("faults"), spoil)
    return [finding for finding in findings if "workbook" not in finding.what]


def spoilt(folder: Path, table: str, name: str, column: str, change: Callable[[str], str]) -> None:
    """Change a column of the first row of a name, by its first column."""
    path = folder / (f"{table}.csv" if "/" in table else f"schedules/{table}.csv")
    with path.open(encoding="utf-8", newline="") as stream:
        names, *rows = list(csv.reader(stream))
    row = next(row for row in rows if row[0] == name)
    row[names.index(column)] = change(row[names.index(column)])
    with path.open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows([names, *rows])


def after(package: Path, tmp_path: Path, spoil: Callable[[Path], None]) -> tuple[Finding, ...]:
    """Findings of a spoilt copy, its hashes renewed."""
    folder = tmp_path / "out"
    shutil.copytree(package, folder)
    spoil(folder)
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["files"] = {k: sha256_of(p) for k, p in package_files(folder).items()}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return check_package(folder).findings


def test_nothing_is_found_in_the_package_as_it_was_built(package: Path) -> None:
    assert not check_package(package).findings


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: f"{fault[1]} {fault[2]}")
def test_a_cell_is_named_by_its_part_and_column(
    found: list[Finding], fault: tuple[str, str, str, Callable[[str], str]]
) -> None:
    table, name, column, _ = fault
    part = name.partition("/")[0] if table == POINTS else name
    words = WORDS.get(column, column) if table == POINTS else column
    assert any(part in own.part and own.what.startswith(words) for own in found), [
        str(own) for own in found if part in own.part
    ]


def test_lost_files_and_changed_headings_are_named(package: Path, tmp_path: Path) -> None:
    def spoil(folder: Path) -> None:
        for lost in ("schedules/sheets.csv", "schedules/bom.csv"):
            (folder / lost).unlink()
        path = folder / "schedules" / "fabgeo.xlsx"
        book = openpyxl.load_workbook(path)
        book["beams"].cell(1, 3, "depth min [mm]")
        book.save(path)

    parts = {finding.part for finding in after(package, tmp_path, spoil)}
    assert parts >= {"schedules/sheets.csv", "schedules/bom.csv", "schedules/fabgeo.xlsx"}
