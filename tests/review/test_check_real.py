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
    "beams": {"section": "I", "depth": 220.0, "standoff": 60.0, "flange_width": 160.0},
    "connectors": {"spacing": 900.0, "standoff": 57.0, "reach": 16.0},
    "nesting": {"steps": 1},
    "stock": [
        {"material": "aluminium", "length": 8000.0, "width": 6000.0},
        {"material": "steel", "length": 12000.0, "width": 2500.0},
    ],
    "drawings": False,
}

CONE = "P-01-01"  # replaced by a cone, where faults.A stays as fitted


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


def part_points(text: str, mark: str) -> set[str]:
    """Numbers of the 3D points that a product's solid is made of."""
    entities = dict(re.findall(r"^#(\d+) ?= ?((?:.|\n)*?);$", text, re.MULTILINE))
    shape = next(
        own for own in entities.values()
        if own.startswith("ADVANCED_BREP_SHAPE_REPRESENTATION")
        and any(mark in e for e in _above(entities, own))
    )  # fmt: skip
    seen: set[str] = set()
    waiting = [n for n in re.findall(r"#(\d+)", shape) if "BREP" in entities[n]]
    while waiting:
        number = waiting.pop()
        if number not in seen:
            seen.add(number)
            waiting += re.findall(r"#(\d+)", entities[number])
    return {n for n in seen if entities[n].startswith("CARTESIAN_POINT")
            and entities[n].count(",") == 3}  # fmt: skip


def _above(entities: dict[str, str], shape: str) -> list[str]:
    """The products that a shape belongs to."""
    own = next(n for n, e in entities.items() if e is shape)
    for entity in entities.values():
        if entity.startswith("SHAPE_DEFINITION_REPRESENTATION") and f"#{own})" in entity:
            chain = [re.findall(r"#(\d+)", entity)[0]]
            for _ in range(3):
                chain.append(re.findall(r"#(\d+)", entities[chain[-1]])[0])
            return [entities[chain[-1]]]
    return []


def moved_solid(mark: str, by: float) -> Callable[[Path], None]:
    def fault(folder: Path) -> None:
        def change(text: str) -> str:
            points = part_points(text, f"'{mark}'")

            def moved(found: re.Match[str]) -> str:
                if found[1] not in points:
                    return found[0]
                x, y, z = (float(v) for v in found[3].split(","))
                return f"{found[0].rpartition('(')[0]}({x!r},{y + by!r},{z!r}))"

            return re.sub(r"#(\d+) ?= ?(CARTESIAN_POINT\('[^']*',)\(([^)]*)\)\)", moved, text)

        faults.step(folder, change)

    fault.__name__ = f"moved_{mark}"
    return fault


def moved_fixing(folder: Path) -> None:
    """The place of the first connector's product, 2 mm aside."""

    row = (folder / "schedules" / "connectors.csv").read_text().splitlines()[1].split(",")
    place = [float(value) for value in row[4:7]]  # rounded

    def change(text: str) -> str:
        for found in re.finditer(r"CARTESIAN_POINT\s*\('',\(([^()]*)\)", text):
            point = [float(value) for value in found[1].split(",")]
            if point == pytest.approx(place, abs=0.006):
                x = found[1].split(",")[0]
                moved = found[0].replace(x, repr(point[0] + 2.0), 1)
                return text.replace(found[0], moved)
        raise AssertionError(f"no point at {place}")

    faults.step(folder, change)


def holed(folder: Path) -> str:
    """The first panel with a round hole."""
    for path in sorted((folder / "cut" / "parts").glob("P-*.dxf")):
        if "\nCIRCLE\n" in path.read_text():
            return path.stem
    raise AssertionError("no panel has a round hole")


def wide_hole(folder: Path) -> None:
    def change(lines: list[str]) -> list[str]:
        return faults.shift(lines, faults.entity(lines, "CIRCLE", "HOLES"), "40", 0, 0.5)

    faults.groups(faults.part_file(folder, holed(folder)), change)


def moved_hole(folder: Path) -> None:
    def change(lines: list[str]) -> list[str]:
        return faults.shift(lines, faults.entity(lines, "CIRCLE", "HOLES"), "10", 0, 1.0)

    faults.groups(faults.part_file(folder, holed(folder)), change)


def moved_bend(folder: Path) -> None:
    def change(lines: list[str]) -> list[str]:
        own = faults.entity(lines, "LINE", "RULINGS", 3)
        return faults.shift(faults.shift(lines, own, "10", 0, 15.0), own, "11", 0, 15.0)

    faults.groups(faults.part_file(folder), change)


def wrong_bend(folder: Path) -> None:
    path = faults.part_file(folder).with_suffix(".bends.csv")
    lines = path.read_text().splitlines()
    cells = lines[4].split(",")
    lines[4] = ",".join([*cells[:-1], f"{float(cells[-1]) * 1.1:.3f}"])
    path.write_text("\n".join(lines) + "\n")


def mirrored_part(folder: Path) -> None:
    def change(lines: list[str]) -> list[str]:
        for k in range(0, len(lines) - 1, 2):
            if lines[k].strip() in ("10", "11", "42") and k > lines.index("ENTITIES"):
                lines[k + 1] = repr(-float(lines[k + 1]))
        return lines

    faults.groups(faults.part_file(folder), change)


def lost_sheet(folder: Path) -> None:
    faults.sheet_of(folder).unlink()


def twice_in_schedule(folder: Path) -> None:
    path = folder / "schedules" / "panels.csv"
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join([*lines, next(x for x in lines if x.startswith(f"{faults.A},"))]))


def in_metres(folder: Path) -> None:
    faults.cell(folder, "beams", "B-01-1", "length_mm", lambda v: f"{float(v) / 1000:.2f}")


def other_class(folder: Path) -> None:
    faults.cell(folder, "panels", CONE, "class", lambda _: "developable")


def other_layer(folder: Path) -> None:
    path = faults.part_file(folder)
    path.write_text(path.read_text().replace("\nCUT_OUTER\n", "\nRULINGS\n"), newline="")


def other_figure(folder: Path) -> None:
    path = folder / "checks" / "review.json"
    review = json.loads(path.read_text())
    review["parts"][faults.A]["gap_max_mm"] += 0.01
    path.write_text(json.dumps(review))


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
    moved_solid(faults.A, 2.0): {faults.A},
    moved_solid("C-01-00", 2.0): {"C-01-00"},
    moved_solid("B-01-1-FLI", 2.0): {"B-01-1", "B-01-1-FLI"},
    moved_bend: {faults.A},
    wrong_bend: {faults.A},
    mirrored_part: {faults.A},
    twice_in_schedule: {faults.A},
    in_metres: {"B-01-1"},
    other_class: {CONE},
    other_layer: {faults.A},
    other_figure: {faults.A},
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


@pytest.mark.parametrize("fault", [wide_hole, moved_hole], ids=lambda fault: fault.__name__)
def test_a_wrong_hole_is_named(
    package: Path, tmp_path: Path, fault: Callable[[Path], None]
) -> None:
    assert set(_after(package, tmp_path, fault).parts) == {holed(package)}


def test_a_moved_fixing_is_named(package: Path, tmp_path: Path) -> None:
    first = (package / "schedules" / "connectors.csv").read_text().splitlines()[1].split(",")[0]
    assert set(_after(package, tmp_path, moved_fixing).parts) == {first}


def test_all_parts_of_a_lost_sheet_are_named(package: Path, tmp_path: Path) -> None:
    sheet = faults.sheet_of(package)
    marks = set(re.findall(r"\b[PBW]-\d[\w-]+", sheet.read_text()))
    assert marks <= set(_after(package, tmp_path, lost_sheet).parts)


def _after(package: Path, tmp_path: Path, fault: Callable[[Path], None]):
    """The report after a fault; hashes are renewed, so that only measurements can find it."""
    folder = tmp_path / "out"
    shutil.copytree(package, folder)
    fault(folder)
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["files"] = {k: sha256_of(p) for k, p in package_files(folder).items()}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return check_package(folder)
