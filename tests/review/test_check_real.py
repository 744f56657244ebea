"""Faults put into a package that a build wrote: conical, with cells, beams and point fixings."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
import test_check_faults as faults

from fabgeo.build import build_package
from fabgeo.project import parse_project
from fabgeo.review.check import check_package
from fabgeo.review.manifest import package_files, sha256_of

pytestmark = pytest.mark.slow

PROJECT = {
    "name": "Pavilion",
    "surface": {
        "unit": "m",
        "u": [-2.0, 3.0],
        "v": [-3.0, 2.5],
        "x": "u",
        "y": "v + 0.05*u",
        "z": "3 - 0.045*u**2 - 0.06*v**2 + 0.004*u*v*v",
    },
    "strips": {"kind": "conical", "count": 3},
    "panels": {"length": 2000.0, "joint": 12.0, "tolerance": 1.5, "thickness": 4.0},
    "cells": {"depth": -250.0, "walls": True},
    "beams": {"section": "I", "depth": 220.0, "standoff": 60.0, "flange_width": 140.0},
    "connectors": {"spacing": 900.0, "standoff": 57.0, "reach": 16.0},
    "nesting": {"steps": 1},
    "stock": [
        {"material": "aluminium", "length": 8000.0, "width": 4000.0},
        {"material": "steel", "length": 8000.0, "width": 2500.0},
    ],
    "drawings": False,
}


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pavilion") / "out"
    build_package(parse_project(PROJECT), folder)
    return folder


def test_the_check_finds_nothing_and_measures_what_the_build_says(package: Path) -> None:
    report = check_package(package)
    assert report.ok, list(report.lines())
    stated = json.loads((package / "checks/review.json").read_text())["summary"]
    assert report.measured["solids"] == stated["solids"]
    assert report.measured["edge_length_error_mm"] < 0.02
    assert report.measured["shared_edge_error_mm"] < 0.02
    assert report.measured["refold_error_mm"] < 0.05
    assert report.measured["panel_twist_max_deg"] < 0.02


def lost_fixing(folder: Path) -> None:
    path = folder / "schedules" / "connectors.csv"
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join([lines[0], *lines[2:]]))


def wrong_cell(folder: Path) -> None:
    faults.cell(folder, "cells", "C-01-00", "volume_m3", lambda v: f"{float(v) * 1.002:.6f}")


def heavy_beam(folder: Path) -> None:
    faults.cell(folder, "beams", "B-01-1", "mass_kg", lambda v: f"{float(v) + 1.0:.3f}")


def wrong_web(folder: Path) -> None:
    faults.cell(folder, "plates", "B-01-1-WEB", "radius_min_mm", lambda v: f"{float(v) * 1.03:.1f}")


def moved_point(folder: Path) -> None:
    path = folder / "setout" / "points.csv"

    def moved(found: re.Match[str]) -> str:
        return f"{found[1]}{float(found[2]) + 100.0:.4f}"

    text = re.sub(rf"({faults.A}/2,)([-\d.]+)", moved, path.read_text(), count=1)
    path.write_text(text)


def lost_point(folder: Path) -> None:
    path = folder / "setout" / "points.csv"
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(line for line in lines if not line.startswith(f"{faults.A}/3,")))


def leaning_normal(folder: Path) -> None:
    path = folder / "setout" / "points.csv"
    lines = path.read_text().splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if line.startswith(f"{faults.A}/3,"))
    cells = lines[at].split(",")
    lines[at] = ",".join([*cells[:4], f"{float(cells[4]) + 0.01:.8f}", *cells[5:]])
    path.write_text("".join(lines))


def small_box(folder: Path) -> None:
    faults.cell(folder, "panels", faults.A, "box_width_mm", lambda v: f"{float(v) * 0.9:.1f}")


def oversized_beam(folder: Path) -> None:
    faults.cell(folder, "beams", "B-01-1", "transport", lambda _: "too large")


def late_panel(folder: Path) -> None:
    faults.cell(folder, "panels", faults.A, "erection_order", lambda _: "999")


def smooth_edge(folder: Path) -> None:
    faults.cell(folder, "panels", faults.A, "kink_max_deg", lambda v: f"{float(v) - 1.5:.4f}")


FAULTS: dict[Callable[[Path], None], set[str]] = {
    faults.moved_vertex: {faults.A},
    faults.scaled_part: {faults.A},
    faults.open_outline: {faults.A},
    faults.missing_hole: {faults.A},
    faults.swapped_drawings: {faults.A, faults.B},
    faults.swapped_labels: {faults.A, faults.B},
    faults.lost_part: {faults.A},
    faults.swapped_names: {faults.A, faults.B},
    faults.renamed_solid: {faults.A},
    faults.wrong_radius: {faults.A},
    faults.wrong_mass: {faults.A},
    faults.wrong_class: {faults.A},
    faults.wrong_sheet: {faults.A},
    faults.wrong_figure: {faults.A},
    wrong_cell: {"C-01-00"},
    heavy_beam: {"B-01-1"},
    wrong_web: {"B-01-1-WEB"},
    moved_point: {faults.A},
    lost_point: {faults.A},
    leaning_normal: {faults.A},
    small_box: {faults.A},
    oversized_beam: {"B-01-1"},
    late_panel: {faults.A, "C-00-01"},
    smooth_edge: {faults.A},
}


@pytest.mark.parametrize("fault", list(FAULTS), ids=lambda fault: fault.__name__)
def test_a_fault_is_named_by_its_part(
    package: Path, tmp_path: Path, fault: Callable[[Path], None]
) -> None:
    report = _after(package, tmp_path, fault)
    parts = {part for part in report.parts if re.match(r"[A-Z]-\d", part)}
    allowed = {"P-77-77"} if fault is faults.renamed_solid else set()
    assert FAULTS[fault] <= parts <= FAULTS[fault] | allowed, list(report.lines())


def test_a_fixing_without_a_row_is_named(package: Path, tmp_path: Path) -> None:
    first = (package / "schedules" / "connectors.csv").read_text().splitlines()[1].split(",")[0]
    assert first in _after(package, tmp_path, lost_fixing).parts


def _after(package: Path, tmp_path: Path, fault: Callable[[Path], None]):
    """The report after a fault; hashes are renewed, so that only measurements can find it."""
    folder = tmp_path / "out"
    shutil.copytree(package, folder)
    fault(folder)
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["files"] = {k: sha256_of(p) for k, p in package_files(folder).items()}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return check_package(folder)
