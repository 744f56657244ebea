"""Twenty deliberate faults put into a written package: each is named by its part."""

from __future__ import annotations

import csv
import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from review_package import write_package

from fabgeo.review.check import check_package
from fabgeo.review.manifest import package_files, sha256_of

A, B = "P-00-01", "P-01-00"


@pytest.fixture(scope="session")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("package") / "roof"
    write_package(folder, 2, 3)
    return folder


def test_an_untouched_package_has_no_finding(package: Path) -> None:
    report = check_package(package)
    assert report.ok, list(report.lines())
    assert report.measured["solids"] == 6
    assert report.measured["outline_error_mm"] < 0.06  # the writer's tolerance is 0.05 mm
    assert report.measured["refold_error_mm"] < 1e-3
    assert report.measured["edge_length_error_mm"] < 5e-3


def groups(path: Path, change: Callable[[list[str]], list[str]]) -> None:
    """Rewrite a DXF file's lines."""
    lines = path.read_text("utf-8").split("\n")
    path.write_text("\n".join(change(lines)), "utf-8", newline="")


def entity(lines: list[str], kind: str, layer: str, number: int = 0) -> tuple[int, int]:
    """First and last line of an entity, by its kind and layer."""
    found = -1
    for k in range(0, len(lines) - 1, 2):
        if lines[k].strip() == "0" and lines[k + 1].strip() == kind:
            end = next(j for j in range(k + 2, len(lines), 2) if lines[j].strip() == "0")
            own = [lines[j + 1].strip() for j in range(k, end, 2) if lines[j].strip() == "8"]
            if own == [layer]:
                found += 1
                if found == number:
                    return k, end
    raise LookupError(f"{kind} on {layer}")


def shift(lines: list[str], part: tuple[int, int], code: str, number: int, by: float) -> list[str]:
    at = [k for k in range(part[0], part[1], 2) if lines[k].strip() == code][number]
    lines[at + 1] = repr(float(lines[at + 1]) + by)
    return lines


def scale(lines: list[str], part: tuple[int, int], by: float) -> list[str]:
    for k in range(part[0], part[1], 2):
        if lines[k].strip() in ("10", "20"):
            lines[k + 1] = repr(float(lines[k + 1]) * by)
    return lines


def cell(folder: Path, table: str, mark: str, column: str, change: Callable[[str], str]) -> None:
    """Change one cell of a schedule."""
    path = folder / "schedules" / f"{table}.csv"
    with path.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    for row in rows:
        if row["mark"] == mark:
            row[column] = change(row[column])
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def part_file(folder: Path, mark: str = A) -> Path:
    return folder / "cut" / "parts" / f"{mark}.dxf"


def sheet_of(folder: Path, mark: str = A) -> Path:
    found = [p for p in (folder / "cut" / "nests").glob("*/*.dxf") if mark in p.read_text()]
    return found[0]


def step(folder: Path, change: Callable[[str], str]) -> None:
    path = folder / "model" / "facade.step"
    before = path.read_text("utf-8")
    after = change(before)
    assert after != before
    path.write_text(after, "utf-8", newline="")


def moved_vertex(folder: Path) -> None:
    def change(lines: list[str]) -> list[str]:
        return shift(lines, entity(lines, "LWPOLYLINE", "CUT_OUTER"), "20", 3, 0.5)

    groups(part_file(folder), change)


def moved_corner(folder: Path) -> None:
    def change(lines: list[str]) -> list[str]:
        return shift(lines, entity(lines, "LWPOLYLINE", "CUT_OUTER"), "10", 0, -0.5)

    groups(part_file(folder), change)


def scaled_part(folder: Path) -> None:
    def change(lines: list[str]) -> list[str]:
        return scale(lines, entity(lines, "LWPOLYLINE", "CUT_OUTER"), 1.001)

    groups(part_file(folder), change)


def open_outline(folder: Path) -> None:
    def change(lines: list[str]) -> list[str]:
        first, last = entity(lines, "LWPOLYLINE", "CUT_OUTER")
        at = next(k for k in range(first, last, 2) if lines[k].strip() == "70")
        lines[at + 1] = "0"
        return lines

    groups(part_file(folder), change)


def crossed_outline(folder: Path) -> None:
    def change(lines: list[str]) -> list[str]:
        return shift(lines, entity(lines, "LWPOLYLINE", "CUT_OUTER"), "20", 2, 4000.0)

    groups(part_file(folder), change)


def missing_hole(folder: Path) -> None:
    def change(lines: list[str]) -> list[str]:
        first, last = entity(lines, "CIRCLE", "HOLES")
        return lines[:first] + lines[last:]

    groups(part_file(folder), change)


def swapped_drawings(folder: Path) -> None:
    a, b = part_file(folder, A), part_file(folder, B)
    one, other = a.read_text(), b.read_text()
    a.write_text(other, newline="")
    b.write_text(one, newline="")


def swapped_labels(folder: Path) -> None:
    for mark, other in ((A, B), (B, A)):
        path = part_file(folder, mark)
        path.write_text(re.sub(rf"\n{mark}\n", f"\n{other}\n", path.read_text()), newline="")


def lost_part(folder: Path) -> None:
    part_file(folder).unlink()


def removed_from_sheet(folder: Path) -> None:
    def change(lines: list[str]) -> list[str]:
        first, last = entity(lines, "LWPOLYLINE", "CUT_OUTER")
        return lines[:first] + lines[last:]

    groups(sheet_of(folder, "P-00-00"), change)


def nested_twice(folder: Path) -> None:
    def change(lines: list[str]) -> list[str]:
        first, last = entity(lines, "LWPOLYLINE", "CUT_OUTER", 1)
        again = list(lines[first:last])
        text_first, text_last = entity(lines, "TEXT", "INFO", 2)
        text = list(lines[text_first:text_last])
        both = again + text
        for k in range(0, len(both), 2):
            if both[k].strip() == "20":
                both[k + 1] = repr(float(both[k + 1]) + 4000.0)
        return lines[:last] + both + lines[last:]

    groups(sheet_of(folder), change)


def overlapping(folder: Path) -> None:
    def change(lines: list[str]) -> list[str]:
        for kind, layer, number in (("LWPOLYLINE", "CUT_OUTER", 1), ("TEXT", "INFO", 2)):
            first, last = entity(lines, kind, layer, number)
            for k in range(first, last, 2):
                if lines[k].strip() == "20":
                    lines[k + 1] = repr(float(lines[k + 1]) - 200.0)
        return lines

    groups(sheet_of(folder), change)


def swapped_names(folder: Path) -> None:
    def change(text: str) -> str:
        return text.replace(f"'{A}'", "'~'").replace(f"'{B}'", f"'{A}'").replace("'~'", f"'{B}'")

    step(folder, change)


def renamed_solid(folder: Path) -> None:
    step(folder, lambda text: text.replace(f"'{A}'", "'P-77-77'"))


def turned_face(folder: Path) -> None:
    def change(text: str) -> str:
        shells = re.findall(r"CLOSED_SHELL\('[^']*',\(([^)]*)\)\)", text)
        face = shells[1].split(",")[0].strip()  # of the second panel
        pattern = rf"({re.escape(face)}\s*=\s*ADVANCED_FACE\((?:[^;]*)),\.([TF])\.\)"
        return re.sub(pattern, lambda m: f"{m[1]},.{'F' if m[2] == 'T' else 'T'}.)", text, count=1)

    step(folder, change)


def lost_face(folder: Path) -> None:
    def change(text: str) -> str:
        shells = list(re.finditer(r"CLOSED_SHELL\('[^']*',\(([^)]*)\)\)", text))
        faces = shells[1][1].split(",")
        return text[: shells[1].start(1)] + ",".join(faces[1:]) + text[shells[1].end(1) :]

    step(folder, change)


def wrong_radius(folder: Path) -> None:
    cell(folder, "panels", A, "radius_min_mm", lambda value: f"{float(value) * 1.1:.1f}")


def wrong_mass(folder: Path) -> None:
    cell(folder, "panels", A, "mass_kg", lambda value: f"{float(value) * 1.01:.3f}")


def wrong_thickness(folder: Path) -> None:
    cell(folder, "panels", A, "thickness_mm", lambda _: "4.00")


def wrong_class(folder: Path) -> None:
    cell(folder, "panels", A, "class", lambda _: "flat")


def wrong_area(folder: Path) -> None:
    cell(folder, "panels", A, "area_m2", lambda value: f"{float(value) + 0.001:.6f}")


def wrong_sheet(folder: Path) -> None:
    cell(folder, "panels", A, "sheet", lambda _: "SHEET-099")


def wrong_centre(folder: Path) -> None:
    cell(folder, "panels", A, "cog_z_mm", lambda value: f"{float(value) + 1.0:.1f}")


def wrong_figure(folder: Path) -> None:
    path = folder / "checks" / "review.json"
    review = json.loads(path.read_text())
    review["parts"][A]["refold_error_mm"] = 0.5
    path.write_text(json.dumps(review))


FAULTS = {
    moved_vertex: {A},
    moved_corner: {A},
    scaled_part: {A},
    open_outline: {A},
    crossed_outline: {A},
    missing_hole: {A},
    swapped_drawings: {A, B},
    swapped_labels: {A, B},
    lost_part: {A},
    removed_from_sheet: {"P-00-00"},
    nested_twice: {A},
    overlapping: {A},
    swapped_names: {A, B},
    renamed_solid: {A},
    turned_face: {A},
    lost_face: {A},
    wrong_radius: {A},
    wrong_mass: {A},
    wrong_thickness: {A},
    wrong_class: {A},
    wrong_area: {A},
    wrong_sheet: {A},
    wrong_centre: {A},
    wrong_figure: {A},
}


@pytest.mark.slow
@pytest.mark.parametrize("fault", list(FAULTS), ids=lambda fault: fault.__name__)
def test_a_fault_is_named_by_its_part(
    package: Path, tmp_path: Path, fault: Callable[[Path], None]
) -> None:
    """Hashes are renewed after the fault, so that only measurements can find it."""
    folder = tmp_path / "roof"
    shutil.copytree(package, folder)
    fault(folder)
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["files"] = {k: sha256_of(p) for k, p in package_files(folder).items()}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    report = check_package(folder)
    assert FAULTS[fault] <= set(report.parts), list(report.lines())
    strangers: set[str] = {p for p in report.parts if p.startswith("P-")} - FAULTS[fault]
    allowed = {"P-77-77"} if fault is renamed_solid else set()
    if fault in (overlapping, nested_twice):  # whatever it comes to lie on is named too
        allowed |= {"P-00-00", "P-00-02", B, "P-01-01", "P-01-02"}
    assert strangers <= allowed, list(report.lines())


def test_an_altered_file_is_named_by_hash_and_by_measurement(package: Path, tmp_path: Path) -> None:
    folder = tmp_path / "roof"
    shutil.copytree(package, folder)
    moved_corner(folder)
    findings = [f for f in check_package(folder).findings if f.part == A]
    assert any("sha256" in f.what for f in findings)
    assert any(f.what == "outline" for f in findings)
