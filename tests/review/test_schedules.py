"""Schedules, verdicts and drawings: what stands in the files is what the record says."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from review_synthetic import record

from fabgeo.errors import InputError
from fabgeo.panels.flat import FlatHole
from fabgeo.review.dxf_text import Curve
from fabgeo.review.manifest import write_manifest
from fabgeo.review.page import page_of
from fabgeo.review.record import SUMMARY_KEYS, Limit, ReviewRecord
from fabgeo.review.schedules import bom_rows, cell_text, disarmed, write_schedules
from fabgeo.review.solid_plate import developed
from fabgeo.review.verdicts import judge, judged, review_of, verdict_of, write_review


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_the_csv_says_what_the_record_says(tmp_path: Path) -> None:
    made = record(2, 3)
    write_schedules(tmp_path, made)
    rows = rows_of(tmp_path / "schedules" / "panels.csv")
    assert [row["mark"] for row in rows] == [row["mark"] for row in made.panels]
    for row, own in zip(rows, made.panels, strict=True):
        assert float(row["area_m2"]) == pytest.approx(own["area_m2"], abs=5e-7)
        assert row["kink_edge"] == ""
    points = rows_of(tmp_path / "setout" / "points.csv")
    normals = np.array([[float(row[k]) for k in ("nx", "ny", "nz")] for row in points])
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0, abs=1e-7)


def test_two_writes_are_equal_to_the_byte(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_schedules(tmp_path / name, record(2, 2))
    for path in sorted((tmp_path / "a").rglob("*.*")):
        other = tmp_path / "b" / path.relative_to(tmp_path / "a")
        assert path.read_bytes() == other.read_bytes(), path.name


def test_the_workbook_has_frozen_headers_filters_units_and_no_formula(tmp_path: Path) -> None:
    from openpyxl import load_workbook

    made = record(2, 2)
    hostile = {**made.panels[0], "material": "=HYPERLINK(1)", "reason": "@x"}
    write_schedules(tmp_path, ReviewRecord("x", panels=(hostile, *made.panels[1:])))
    sheet = load_workbook(tmp_path / "schedules" / "fabgeo.xlsx")["panels"]
    assert sheet.freeze_panes == "B2"
    assert sheet.auto_filter.ref is not None
    heads = [cell.value for cell in sheet[1]]
    assert "mass [kg]" in heads
    for line in sheet.iter_rows():
        for cell in line:
            assert cell.data_type != "f"


def test_the_workbook_says_what_the_csv_says(tmp_path: Path) -> None:
    from openpyxl import load_workbook

    made = record(2, 3)
    odd = {**made.panels[0], "material": " a < b & \x0bc ", "radius_min_mm": float("inf")}
    write_schedules(tmp_path, replace(made, panels=(odd, *made.panels[1:])))
    book = load_workbook(tmp_path / "schedules" / "fabgeo.xlsx")
    for sheet in book.worksheets:
        rows = rows_of(tmp_path / "schedules" / f"{sheet.title}.csv")
        assert sheet.max_row == len(rows) + 1
        for line, row in zip(sheet.iter_rows(min_row=2), rows, strict=True):
            for cell, text in zip(line, row.values(), strict=True):
                if cell.data_type == "n" and cell.value is not None:
                    assert float(text) == cell.value
                    assert cell.number_format in ("0", "0." + "0" * len(text.partition(".")[2]))
                else:
                    assert (cell.value or "") == text.replace("\x0b", "")
    sheet = book["panels"]
    heads = [cell.value for cell in sheet[1]]
    verdicts = {
        cell.value: cell.fill.fgColor.rgb for cell in list(sheet.columns)[heads.index("verdict")]
    }
    colours = {"good": "FFD5E8F0", "warn": "FFFCE3B4", "fail": "FFF4C0B0"}
    assert {key: verdicts.get(key, value) for key, value in colours.items()} == colours
    assert len(verdicts.keys() & colours.keys()) > 1


def test_formulas_are_disarmed_and_numbers_are_not() -> None:
    for text in ("=1+1", "+1", "-1", "@SUM(A1)", "\t=1"):
        assert disarmed(text) == "'" + text
    assert disarmed("P-03-07") == "P-03-07"
    assert cell_text(-1.25, 1) == "-1.2"
    assert cell_text(-0.0001, 2) == "0.00"
    assert cell_text(None, 2) == cell_text(float("nan"), 2) == ""
    assert cell_text(float("inf"), 1) == "inf"


def test_the_bill_of_materials_holds_every_panel_once() -> None:
    made = record(3, 4)
    rows = [row for row in bom_rows(made, []) if str(row["item"]).startswith("panel")]
    assert sum(row["count"] for row in rows) == 12
    assert sum(row["mass_kg"] for row in rows) == pytest.approx(
        sum(row["mass_kg"] for row in made.panels)
    )


def test_a_record_that_is_judged_again_keeps_its_reasons() -> None:
    made = judged(record(3, 3))
    assert judged(made).panels == made.panels
    assert any(row["reason"] for row in made.panels)


def test_the_page_shows_remarks_and_classes_over_the_tolerance() -> None:
    limit, at = Limit("deviation_max_mm", 1.0, label="Deviation"), {"deviation_max_mm": "strip 7"}
    made = record(2, 2)
    made = replace(made, where=at, limits=(*made.limits, limit), remarks=("trim: 3 panels <cut>",))
    page = page_of(made)
    assert "deviation_max_mm 6 over 1: strip 7" in page
    assert "trim: 3 panels &lt;cut&gt;" in page
    assert "Panel classes over the tolerance" in page
    assert "Every panel by itself" in page


def test_verdicts_at_and_about_their_limits() -> None:
    limit = Limit("kink_max_deg", 1.0, 3.0)
    expected = {1.0: "good", 1.0001: "warn", 3.0: "warn", 3.0001: "fail", float("nan"): "fail"}
    assert {v: verdict_of(limit, v) for v in expected} == expected
    assert verdict_of(limit, None) == "not asked"
    least = Limit("radius_min_mm", 1000.0, sense="min")
    assert verdict_of(least, 999.0) == "fail"
    assert verdict_of(least, float("inf")) == "good"
    verdict, reason = judge([limit, least], {"kink_max_deg": 2.0, "radius_min_mm": 900.0})
    assert verdict == "fail"
    assert reason.startswith("radius_min_mm 900 under 1000")
    with pytest.raises(InputError, match="no stricter"):
        Limit("x", 2.0, 1.0)


def test_review_json_has_the_contract_s_keys_and_null_where_not_asked(tmp_path: Path) -> None:
    made = record(2, 2)
    write_review(tmp_path / "review.json", made)
    review = json.loads((tmp_path / "review.json").read_text())
    assert set(review) == {"summary", "limits", "worst", "parts", "seconds"}
    for key, worst in review["worst"].items():
        assert review["parts"][worst["mark"]][key] == worst["value"]
        own = [part[key] for part in review["parts"].values() if part.get(key) is not None]
        assert worst["value"] == (max(own) if review["limits"][key]["sense"] == "max" else min(own))
    assert review["worst"]
    assert set(SUMMARY_KEYS) <= set(review["summary"])
    assert review["summary"]["twist_max_deg"] is None
    failed = [m for m, p in review["parts"].items() if p["verdict"] == "fail"]
    assert review["summary"]["failed_verdicts"] == len(failed)
    assert review_of(made) == review


def test_a_figure_that_no_part_has_counts_as_one_failed_verdict() -> None:
    made = record(2, 2)
    few = len([m for m, p in review_of(made)["parts"].items() if p["verdict"] == "fail"])
    own = replace(made, limits=(*made.limits, Limit("covered_share", 0.98, sense="min")))
    for share, more in ((0.97, 1), (0.99, 0)):
        review = review_of(replace(own, summary={**made.summary, "covered_share": share}))
        assert review["summary"]["failed_verdicts"] == few + more


def test_the_manifest_knows_every_file(tmp_path: Path) -> None:
    write_schedules(tmp_path, record(2, 2))
    (tmp_path / ".lock").write_text("x")
    manifest = write_manifest(tmp_path, name="x", project={}, versions={}, seconds={})
    assert "schedules/panels.csv" in manifest["files"]
    assert ".lock" not in manifest["files"]


def test_drawings_have_a_page_a_panel_and_are_repeatable(tmp_path: Path) -> None:
    pypdf = pytest.importorskip("pypdf")
    from fabgeo.review.drawings import write_panel_drawings

    made = record(2, 2)
    paths = [write_panel_drawings(tmp_path / f"{k}.pdf", made) for k in "ab"]
    assert paths[0].read_bytes() == paths[1].read_bytes()
    pages = pypdf.PdfReader(paths[0]).pages
    assert len(pages) == 4
    for page, row in zip(pages, made.panels, strict=True):
        words = page.extract_text()
        assert row["mark"] in words
        assert f"{row['flat_length_mm']:.2f}" in words


def test_every_hole_of_a_beam_s_plates_stands_in_the_drawings(tmp_path: Path) -> None:
    pypdf = pytest.importorskip("pypdf")
    from fabgeo.review.drawings import drawn_page, pages_of, write_panel_drawings

    made = record(2, 2)
    flange = made.flats["P-00-00"]
    centres = [np.array([100.0 + 7.25 * k, 300.0 + k]) for k in range(300)]
    holes = tuple(FlatHole(at, 9.0, 10.0, 0.3) for at in centres)
    marks = ("B-00-1-WEB", "B-00-1-FLO")
    flats = {mark: replace(flange, mark=mark, holes=holes * mark.endswith("FLO")) for mark in marks}
    plates = tuple({"mark": mark, "parent": "B-00-1", "sheet": "x/SHEET-007"} for mark in marks)
    shown = tuple(replace(made.shown[0], mark=mark, family="beams") for mark in marks)
    beams = ({"mark": "B-00-1", "length_mm": 9000.0, "mass_kg": 80.0},)
    whole = replace(made, beams=beams, plates=plates, flats={**made.flats, **flats},
                    shown=(*made.shown, *shown))  # fmt: skip
    path = write_panel_drawings(tmp_path / "a.pdf", whole)
    pages = [page.extract_text() for page in pypdf.PdfReader(path).pages]
    words = "\n".join(pages[4:])
    assert len(pages) == 6
    assert "Camber of B-00-1-WEB" in words
    assert "SHEET-007" in words
    for x, y in centres:
        assert f"{x:.2f}" in words
        assert f"{y:.2f}" in words
    drawn = [drawn_page(page) for page in reversed(pages_of(whole))][::-1]
    other = write_panel_drawings(tmp_path / "b.pdf", whole, drawn)
    assert other.read_bytes() == path.read_bytes()


def test_a_rail_whose_steps_grow_without_bound_is_laid_flat() -> None:
    """A plane strip: a parabola sampled by the root of its parameter, as cut rails are."""
    s = np.linspace(0.0, 1.0, 65)
    x = 4000.0 * (1.0 - np.sqrt(1.0 - s))
    first = np.stack([x, x**2 / 200_000.0, 0.0 * x], axis=1)
    second = np.stack([100.0 * s, 900.0 + 3.0 * s, 0.0 * s], axis=1)
    flat, other = developed(first, second)
    assert np.abs(flat[:, 1] - flat[:, 0] ** 2 / 200_000.0).max() < 0.01
    assert flat[[0, -1]] == pytest.approx(first[[0, -1], :2], abs=1e-6)
    assert other[:, 1] == pytest.approx(900.0 + 0.03 * other[:, 0], abs=1e-6)


def test_a_cone_develops_into_a_sector() -> None:
    """Radius r and slant s: a sector of radius s and angle 2 pi r / s times the turn."""
    radius, height, turn = 4000.0, 3000.0, 1.1
    slant = np.hypot(radius, height)
    t = np.linspace(0.0, turn, 65)
    ring = np.stack([radius * np.cos(t), radius * np.sin(t), np.zeros(65)], axis=1)
    apex = np.array([0.0, 0.0, height])
    a, b = ring, apex + 0.5 * (ring - apex)
    flat_a, flat_b = developed(a, b)
    angle = turn * radius / slant
    assert np.linalg.norm(flat_a[-1] - flat_a[0]) == pytest.approx(
        2 * slant * np.sin(angle / 2), abs=1e-3
    )
    assert np.linalg.norm(flat_b[-1] - flat_b[0]) == pytest.approx(
        slant * np.sin(angle / 2), abs=1e-3
    )


def test_a_bulge_of_one_is_half_a_circle() -> None:
    curve = Curve("x", np.array([[-5.0, 0.0, 1.0], [5.0, 0.0, 1.0]]), True)
    points = curve.points(0.001)
    assert np.linalg.norm(points, axis=1) == pytest.approx(5.0, abs=1e-9)
    x, y = points.T
    area = 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
    assert area == pytest.approx(np.pi * 25.0, rel=5e-4)
