"""DXF files: written to the contract, read back alone, sound for ezdxf's audit."""

from __future__ import annotations

import io
import re
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import shapely
from ezdxf.lldxf.tagwriter import TagWriter
from sheet_parts import wavy_part

from fabgeo.cad.read_dxf import read_dxf_sections
from fabgeo.errors import InputError
from fabgeo.panels.unfold import flat_polygon
from fabgeo.sheets.dxf import DxfStyle, write_nests, write_part, write_parts
from fabgeo.sheets.dxf_forms import Entities, Forms
from fabgeo.sheets.dxf_read import read_part, read_sheet
from fabgeo.sheets.nest import nest
from fabgeo.sheets.stock import Stock

STYLES = [
    DxfStyle(),
    DxfStyle(version="R2000"),
    DxfStyle(version="R12"),
    DxfStyle(outline="splines"),
    DxfStyle(outline="polylines"),
    DxfStyle(layers={"CUT_OUTER": "Schnitt", "INFO": "Text"}),
]


@pytest.mark.parametrize("style", STYLES, ids=lambda s: f"{s.version}-{s.outline}-{len(s.layers)}")
def test_files_pass_the_audit_and_read_back(tmp_path: Path, style: DxfStyle) -> None:
    part = wavy_part()
    path = tmp_path / f"{part.mark}.dxf"
    write_part(part, path, style)
    document = ezdxf.readfile(path)
    audit = document.audit()
    assert (audit.errors, audit.fixes) == ([], [])
    if style.version != "R12":
        assert document.header["$INSUNITS"] == 4
    found = read_part(path, style.layers)
    assert found.mark == part.mark
    assert len(found.inner) == 2
    assert len(found.bends) == 1
    assert found.area == pytest.approx(part.area, abs=0.05 * 1600.0)
    x0, y0, x1, y1 = found.outer.bounds()
    assert (x0, x1, y1) == pytest.approx((0.0, 1500.0, 700.0), abs=1e-9)
    assert y0 == pytest.approx(0.0, abs=0.05)


def test_a_straight_outline_is_one_polyline_among_splines(tmp_path: Path) -> None:
    corners = np.array([[0.0, 0.0], [400.0, 0.0], [380.0, 220.0], [10.0, 200.0]])
    plate = flat_polygon("B-00-1-EPA", "steel", 12.0, corners)
    write_part(plate, tmp_path / "plate.dxf", DxfStyle(outline="splines"))
    kinds = [e.dxftype() for e in ezdxf.readfile(tmp_path / "plate.dxf").modelspace()]
    assert not {"LINE", "SPLINE"} & set(kinds)
    assert read_part(tmp_path / "plate.dxf").area == pytest.approx(plate.area, rel=1e-9)


@pytest.mark.parametrize("version", ["R2000", "R2010"])
def test_forms_are_what_ezdxf_writes(version: str) -> None:
    document = ezdxf.new(version)
    entities = Entities(Forms(document))
    vertices = np.array([[0.1, 2.0, 0.0], [-3.0, 1 / 3, -0.25], [5e-7, 1e6, 1.0]])
    entities.line("A", (0.1, -2.5), (3.0, 1 / 3))
    entities.circle("B {x}", (1e-9, 7.0), 2.5)
    entities.polyline("A", vertices, closed=True)
    entities.polyline("A", vertices[:2], closed=False)
    entities.write("C", "P-01-02 é {8}", (4.0, 5.0), 2.5, 30.0)
    space = document.modelspace()
    own = [
        space.add_line((0.1, -2.5), (3.0, 1 / 3), dxfattribs={"layer": "A"}),
        space.add_circle((1e-9, 7.0), 2.5, dxfattribs={"layer": "B {x}"}),
        space.add_lwpolyline(vertices.tolist(), "xyb", close=True, dxfattribs={"layer": "A"}),
        space.add_lwpolyline(vertices[:2].tolist(), "xyb", dxfattribs={"layer": "A"}),
        space.add_text(
            "P-01-02 é {8}",
            dxfattribs={"layer": "C", "height": 2.5, "rotation": 30.0, "insert": (4.0, 5.0)},
        ),
    ]
    out = io.StringIO()
    for entity in own:
        entity.export_dxf(TagWriter(out, document.dxfversion))
    handles = re.compile(r"^  5\n[0-9A-F]+$", re.MULTILINE)
    assert handles.sub("", entities.text) == handles.sub("", out.getvalue())


def test_outline_is_one_closed_polyline_of_lines_and_arcs(tmp_path: Path) -> None:
    path = tmp_path / "part.dxf"
    write_part(wavy_part(), path)
    space = ezdxf.readfile(path).modelspace()
    (outline,) = space.query('*[layer=="CUT_OUTER"]')
    assert outline.dxftype() == "LWPOLYLINE"
    assert outline.closed
    assert not list(space.query('TEXT[layer!="INFO"]'))
    assert {e.dxftype() for e in space.query('*[layer=="HOLES"]')} == {"CIRCLE", "LWPOLYLINE"}


@pytest.mark.parametrize("width", [700.0, 60.0, 14.0])
def test_marks_stay_inside_and_off_the_holes(tmp_path: Path, width: float) -> None:
    part = flat_polygon(
        "P-12-34", "al", 3.0, np.array([[0, 0], [900, 0], [900, width], [0, width]])
    )
    path = tmp_path / "part.dxf"
    write_part(part, path)
    found = read_part(path)
    material = shapely.Polygon(found.outer.points()).buffer(-1.0)
    assert found.strokes, "even 14 mm take a small mark"
    for stroke in found.strokes:
        assert shapely.contains(material, shapely.LineString(stroke))


def test_marks_avoid_holes(tmp_path: Path) -> None:
    part = wavy_part()
    path = tmp_path / "part.dxf"
    write_part(part, path)
    found = read_part(path)
    holes = shapely.union_all([shapely.Polygon(hole.points()) for hole in found.inner])
    for stroke in found.strokes:
        assert shapely.distance(holes, shapely.LineString(stroke)) > 1.0


def test_same_part_same_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("one", "two"):
        write_part(wavy_part(), tmp_path / f"{name}.dxf")
    one = (tmp_path / "one.dxf").read_bytes()
    assert one == (tmp_path / "two.dxf").read_bytes()
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    write_part(wavy_part(), tmp_path / "three.dxf")
    text = (tmp_path / "three.dxf").read_text()
    assert "2023-11-14T22:13:20.000000+00:00" in text
    assert "2000-01-01" not in text


def test_bend_table_beside(tmp_path: Path) -> None:
    write_part(wavy_part(), tmp_path / "P-00-00.dxf")
    lines = (tmp_path / "P-00-00.bends.csv").read_text().splitlines()
    assert lines[0] == "bend,x1_mm,y1_mm,x2_mm,y2_mm,length_mm,radius_mm"
    assert lines[1] == "1,500.000,100.000,500.000,700.000,600.000,-3000.000"


def test_sheets_hold_their_parts_at_full_size(tmp_path: Path) -> None:
    parts = {f"P-00-{k:02d}": wavy_part(f"P-00-{k:02d}") for k in range(2)}
    made = write_parts(list(parts.values()), tmp_path / "parts")
    nests = nest(list(parts.values()), [Stock("S", "al", 3.0, 3000, 1500)], seconds=0.0)
    (path,) = write_nests(nests, made, tmp_path / "nests")
    assert path.relative_to(tmp_path / "nests").as_posix() == "al_3mm/SHEET-001.dxf"
    sheet = read_sheet(path)
    assert (sheet.length, sheet.width) == (3000.0, 1500.0)
    assert sheet.title.startswith("SHEET-001  al 3 mm")
    alone = {mark: read_part(tmp_path / "parts" / f"{mark}.dxf") for mark in parts}
    assert sorted(part.mark for part in sheet.parts) == sorted(parts)
    for part in sheet.parts:
        assert part.area == pytest.approx(alone[part.mark].area, rel=1e-12)
        assert len(part.inner) == 2
        assert len(part.bends) == 1


def broken(tmp_path: Path, change: str) -> Path:
    document = ezdxf.new("R2010")
    document.header["$INSUNITS"] = 1 if change == "unit" else 4
    space = document.modelspace()
    corners = [(0, 0), (100, 0), (100, 50), (0, 50)]
    if change == "crossing":
        corners = [(0, 0), (100, 50), (100, 0), (0, 50)]
    corners = corners[: {"point": 1, "line": 2}.get(change, 4)]
    layer = "LASER" if change == "layer" else "CUT_OUTER"
    space.add_lwpolyline(corners, close=change != "open", dxfattribs={"layer": layer})
    if change == "stroke":
        space.add_lwpolyline([(20, 20)], dxfattribs={"layer": "MARK"})
    if change != "mark":
        text = "CUT_OUTER" if change == "text" else "INFO"
        space.add_text("P-1", dxfattribs={"layer": text, "insert": (20, 20)})
    path = tmp_path / "broken.dxf"
    document.saveas(path)
    return path


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("unit", "expected millimetres"),
        ("open", "open contour"),
        ("crossing", "crosses itself"),
        ("point", "encloses nothing"),
        ("line", "encloses nothing"),
        ("stroke", "a stroke on layer MARK has no length"),
        ("layer", "unknown layer 'LASER'"),
        ("text", "live text"),
        ("mark", "holds 0 marks"),
    ],
)
def test_faults_of_a_file_are_named(tmp_path: Path, change: str, message: str) -> None:
    with pytest.raises(InputError, match=f"broken.dxf.*{message}"):
        read_part(broken(tmp_path, change))


def test_a_file_without_model_space_is_named(tmp_path: Path) -> None:
    path = tmp_path / "lost.dxf"
    write_part(wavy_part("P-00-00"), path)
    path.write_text(path.read_text().replace("\nModel\n", "\nModal\n"))
    for reader in (read_part, read_dxf_sections):
        with pytest.raises(InputError, match=r"lost\.dxf"):
            reader(path)


def test_an_entity_of_no_known_kind_is_named(tmp_path: Path) -> None:
    path = tmp_path / "strange.dxf"
    write_part(wavy_part("P-00-00"), path)
    text = path.read_text()
    space = text.index("ENTITIES")
    path.write_text(text[:space] + text[space:].replace("\nLWPOLYLINE\n", "\nLWPOLY17\n", 1))
    with pytest.raises(InputError, match=r"strange\.dxf.*LWPOLY17"):
        read_part(path)


def test_a_file_that_is_no_dxf_is_named(tmp_path: Path) -> None:
    path = tmp_path / "note.dxf"
    path.write_text("hello")
    with pytest.raises(InputError, match=r"note\.dxf"):
        read_part(path)
    with pytest.raises(InputError, match="splines"):
        DxfStyle(version="R12", outline="splines")
