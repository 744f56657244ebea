"""Faults of drawings that outlines and holes don't show: layers, engraved marks, bend lines."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Callable
from pathlib import Path

import ezdxf
import pytest
from ezdxf.document import Drawing
from review_package import write_package

from fabgeo.review.check import check_package

A, B = "P-00-01", "P-01-00"
SHEET = "cut/nests/steel_3mm/SHEET-001.dxf"


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("drawings") / "roof"
    write_package(folder, 2, 3)
    return folder


def part(folder: Path, mark: str = A) -> Path:
    return folder / "cut" / "parts" / f"{mark}.dxf"


def sheet(folder: Path) -> Path:
    return folder / SHEET


def change(path: Path, how: Callable[[Drawing], object]) -> None:
    drawing = ezdxf.readfile(path)
    how(drawing)
    drawing.saveas(path)


def rows(folder: Path, mark: str, how: Callable[[list[dict[str, str]]], object]) -> None:
    """Rewrite a table of bend lines."""
    path = part(folder, mark).with_suffix(".bends.csv")
    with path.open(encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    how(table)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(table[0]))
        writer.writeheader()
        writer.writerows(table)


def cut_line(folder: Path) -> None:
    change(part(folder), lambda d: d.modelspace().add_line((0, 0), (9, 9), {"layer": "CUT_OUTER"}))


def cut_arc(folder: Path) -> None:
    attributes = {"layer": "HOLES"}
    change(part(folder), lambda d: d.modelspace().add_arc((99, 99), 9, 0, 90, attributes))


def cut_text(folder: Path) -> None:
    change(part(folder), lambda d: d.modelspace().add_text("x", dxfattribs={"layer": "HOLES"}))


def strange_layer(folder: Path) -> None:
    change(part(folder), lambda d: d.modelspace().add_line((0, 0), (9, 9), {"layer": "EXTRA"}))


def no_unit(folder: Path) -> None:
    lines = part(folder).read_text("utf-8").split("\n")
    at = lines.index("$INSUNITS") - 1
    part(folder).write_text("\n".join(lines[:at] + lines[at + 4 :]), "utf-8", newline="")


def mark_outside(folder: Path) -> None:
    def moved(drawing: Drawing) -> None:
        (text,) = drawing.modelspace().query("TEXT")
        text.dxf.insert = (-500.0, -500.0)

    change(part(folder), moved)


def _strokes(drawing: Drawing) -> list:
    return list(drawing.modelspace().query('*[layer=="MARK"]'))


def no_strokes(folder: Path) -> None:
    change(part(folder), lambda d: [d.modelspace().delete_entity(e) for e in _strokes(d)])


def mirrored_strokes(folder: Path) -> None:
    """Letters that read from the other side only."""

    def mirror(drawing: Drawing) -> None:
        for stroke in _strokes(drawing):
            stroke.set_points([(-x, y) for x, y in stroke.get_points("xy")], "xy")

    change(part(folder), mirror)


def engraved_as_another(folder: Path) -> None:
    """The strokes of B in the file of A, the text as it should be."""
    strokes = [e.get_points("xy") for e in _strokes(ezdxf.readfile(part(folder, B)))]
    no_strokes(folder)

    def draw(drawing: Drawing) -> None:
        for points in strokes:
            drawing.modelspace().add_lwpolyline(points, "xy", dxfattribs={"layer": "MARK"})

    change(part(folder), draw)


def swapped_on_the_sheet(folder: Path) -> None:
    """Strokes of two parts exchanged on their sheet, the texts as they should be."""

    def swap(drawing: Drawing) -> None:
        texts = {t.dxf.text: t.dxf.insert for t in drawing.modelspace().query("TEXT")}
        a, b = texts[A], texts[B]
        for stroke in _strokes(drawing):
            points = stroke.get_points("xy")
            if abs(points[0][1] - a.y) < 100.0 and abs(points[0][0] - a.x) < 500.0:
                stroke.set_points([(x + b.x - a.x, y + b.y - a.y) for x, y in points], "xy")
            elif abs(points[0][1] - b.y) < 100.0 and abs(points[0][0] - b.x) < 500.0:
                stroke.set_points([(x + a.x - b.x, y + a.y - b.y) for x, y in points], "xy")

    change(sheet(folder), swap)


def turned_bend(folder: Path) -> None:
    def turn(table: list[dict[str, str]]) -> None:
        table[3]["radius_mm"] = str(-float(table[3]["radius_mm"]))

    rows(folder, A, turn)


def no_bend_on_the_sheet(folder: Path) -> None:
    change(sheet(folder), lambda d: d.modelspace().delete_entity(d.modelspace().query("LINE")[0]))


def bend_moved_on_the_sheet(folder: Path) -> None:
    change(sheet(folder), lambda d: d.modelspace().query("LINE")[0].translate(1.0, 0.0, 0.0))


def turned_over(folder: Path) -> None:
    """The outline as seen from below: by its extrusion, its numbers are the same."""

    def turn(drawing: Drawing) -> None:
        (outline,) = drawing.modelspace().query('*[layer=="CUT_OUTER"]')
        outline.dxf.extrusion = (0.0, 0.0, -1.0)

    change(part(folder), turn)


def cut_line_on_the_sheet(folder: Path) -> None:
    change(sheet(folder), lambda d: d.modelspace().add_line((0, 0), (9, 9), {"layer": "CUT_INNER"}))


def other_title(folder: Path) -> None:
    def rename(drawing: Drawing) -> None:
        (title,) = (t for t in drawing.modelspace().query("TEXT") if "steel" in t.dxf.text)
        title.dxf.text = title.dxf.text.replace("steel", "aluminium")

    change(sheet(folder), rename)


def other_stock(folder: Path) -> None:
    """Wider by 5 mm."""

    def stretch(drawing: Drawing) -> None:
        (stock,) = drawing.modelspace().query('*[layer=="SHEET"]')
        stock.set_points([(x, y + 5.0 * (y > 0.0)) for x, y in stock.get_points("xy")], "xy")

    change(sheet(folder), stretch)


FAULTS = {
    cut_line: A,
    cut_arc: A,
    cut_text: A,
    strange_layer: A,
    no_unit: A,
    mark_outside: A,
    no_strokes: A,
    mirrored_strokes: A,
    engraved_as_another: A,
    swapped_on_the_sheet: A,
    turned_bend: A,
    turned_over: A,
    no_bend_on_the_sheet: "P-00-00",
    bend_moved_on_the_sheet: "P-00-00",
    cut_line_on_the_sheet: SHEET,
    other_title: SHEET,
    other_stock: SHEET,
}


def test_drawings_as_written_have_no_finding(package: Path) -> None:
    assert check_package(package).ok


@pytest.mark.slow
@pytest.mark.parametrize("fault", list(FAULTS), ids=lambda fault: fault.__name__)
def test_a_fault_of_a_drawing_is_measured(
    package: Path, tmp_path: Path, fault: Callable[[Path], None]
) -> None:
    folder = tmp_path / "roof"
    shutil.copytree(package, folder)
    fault(folder)
    found = [f for f in check_package(folder).findings if "sha256" not in f.what]
    assert FAULTS[fault] in {f.part for f in found}, found
    others = {f.part for f in found if f.part.startswith("P-")} - {FAULTS[fault]}
    assert others <= ({B} if fault is swapped_on_the_sheet else set()), found
