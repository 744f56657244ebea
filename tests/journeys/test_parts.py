"""Several geodesic models side by side, built as one package."""

from __future__ import annotations

import csv
import json
import re
import tomllib
from collections import Counter
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import dblquad

from fabgeo.build import Package, build_package, design
from fabgeo.build.fitted import parts_of
from fabgeo.build.seams import between
from fabgeo.build.trimming import area
from fabgeo.errors import InputError
from fabgeo.fitting.planks import opposite_congruence
from fabgeo.fitting.starts.net import model_through
from fabgeo.fitting.store import load_model
from fabgeo.project import parse_project
from fabgeo.review.check import check_package
from fabgeo.strips.measures import measure
from fabgeo.structures.panels import Layer, panels
from fabgeo.structures.parts import Plate
from fabgeo.structures.patches import CutRule, cut

MODELS, STRIPS = 3, 3
BOWL = """
name = "Roof of three models"
drawings = false
[surface]
unit = "m"
u = [-1.0, 1.0]
v = [-1.5, 1.5]
x = "u"
y = "v"
z = "-0.06*u**2 - 0.05*v**2"
[strips]
kind = "geodesic"
start = "geodesic"
parts = 3
count = 3
[panels]
count = 1
joint = 0.0
thickness = 12.0
material = "wood"
choice = "single"
tolerance = 0.001
[panels.materials]
P-05-00 = "oak"
[materials.oak]
density = 700.0
E = 11000.0
yield_stress = 30.0
rolls_radius = 2000.0
[nesting]
rotations = "grain"
steps = 1
[[stock]]
material = "wood"
length = 4000.0
width = 260.0
[[stock]]
material = "oak"
length = 4000.0
width = 260.0
"""
AREA = dblquad(lambda v, u: np.hypot(1.0, np.hypot(0.12 * u, 0.1 * v)), -1.0, 1.0, -1.5, 1.5)[0]


def project(text: str = BOWL, **strips: Any) -> dict[str, Any]:
    data = tomllib.loads(text)
    data["strips"].update(strips)
    return data


@pytest.fixture(scope="module")
def roof(tmp_path_factory: pytest.TempPathFactory) -> Package:
    return build_package(project(), tmp_path_factory.mktemp("parts") / "out")


@pytest.fixture(scope="module")
def rows(roof: Package) -> list[dict[str, str]]:
    with (roof.path / "schedules" / "panels.csv").open(encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


@pytest.mark.slow
def test_planks_of_all_models_cover_the_surface_and_no_more(roof: Package, rows: Any) -> None:
    assert roof.design.trims is not None
    covered = sum(float(row["area_m2"]) for row in rows)
    # Half a millimetre off the surface, on radii of 10 m, areas are off by a ten-thousandth.
    assert covered + roof.design.trims.lost / 1e6 == pytest.approx(AREA, rel=1e-4)
    assert roof.review["summary"]["covered_share"] > 0.99


@pytest.mark.slow
def test_strips_are_counted_on_and_every_mark_is_one_plank(roof: Package, rows: Any) -> None:
    marks = [row["mark"] for row in rows]
    assert marks == [f"P-{k:02d}-00" for k in range(MODELS * STRIPS)]
    assert Counter(p.mark for n in roof.nests for s in n.sheets for p in s.placements) == Counter(
        marks
    )
    assert {path.stem for path in (roof.path / "cut" / "parts").glob("*.dxf")} == set(marks)
    assert [row["mark"] for row in rows if row["material"] == "oak"] == ["P-05-00"]
    for row in rows:
        assert 0.5 < float(row["plank_yield"]) <= 1.0
        assert float(row["flat_length_mm"]) > 2000.0
        assert float(row["flat_width_mm"]) < 260.0
        assert row["sheet"]


@pytest.mark.slow
def test_developed_edges_are_opposite_across_seams_as_within_models(rows: Any) -> None:
    beside = [float(row["edge_congruence_mm"]) for row in rows[:-1]]
    assert len(beside) == MODELS * STRIPS - 1
    assert max(beside) < 1e-4 * 3000.0


@pytest.mark.slow
def test_models_meet_at_their_seams_and_the_rows_say_with_whom(roof: Package, rows: Any) -> None:
    summary = roof.review["summary"]
    assert max(summary[f"seam_{name}_max_mm"] for name in ("open", "narrow", "step")) < 0.05
    for last in (STRIPS - 1, 2 * STRIPS - 1):
        one, other = rows[last], rows[last + 1]
        assert (one["gap_edge"], other["gap_edge"]) == (other["mark"], one["mark"])
    # Both chords of a cylinder of radius R turn by their width over R.
    kinks = [float(row["kink_max_deg"]) for row in rows]
    assert kinks == pytest.approx([np.degrees(0.24 * 0.12)] * len(kinks), rel=0.1)
    assert any("seams between 3 models" in note for note in roof.record.remarks)


@pytest.mark.slow
def test_the_summary_is_the_worst_of_the_models_as_their_files_hold_them(roof: Package) -> None:
    names = ["strips.json", "strips-2.json", "strips-3.json"]
    models = [load_model(roof.path / name) for name in names]
    assert [model.info["first_strip"] for model in models] == [0, 3, 6]
    assert sorted(model.info["part"][0] for model in models) == [1, 2, 3]
    found = [measure(model, roof.design.surface) for model in models]
    summary = roof.review["summary"]
    off = [m.deviation_max.value for m in found if m.deviation_max]
    assert summary["deviation_max_mm"] == pytest.approx(max(off), rel=1e-9)
    assert min(off) < summary["deviation_rms_mm"] * 3.0 < 3.0 * max(off)
    assert max(opposite_congruence(model).max() for model in models) < 1e-4
    assert summary["surface_to_model_max_mm"] < 2.0 * max(off)  # one alone leaves metres bare
    again = project(start="model", model=str(roof.path / names[1]), parts=None, count=None)
    del again["panels"]["materials"], again["strips"]["parts"], again["strips"]["count"]
    assert design(again).model.strips == STRIPS


@pytest.mark.slow
def test_the_check_finds_nothing_and_reads_every_model(roof: Package) -> None:
    assert check_package(roof.path).findings == ()
    path = roof.path / "strips-3.json"
    whole = path.read_text(encoding="utf-8")
    data = json.loads(whole)
    data["control"][1][4][2] += 20.0
    path.write_text(json.dumps(data), encoding="utf-8")
    try:
        found = [str(finding) for finding in check_package(roof.path).findings]
    finally:
        path.write_text(whole, encoding="utf-8")
    assert any("strips.json" in line and "kink_max_deg" in line for line in found), found


@pytest.mark.slow
def test_joints_are_taken_off_at_seams_and_panels_of_several_cells_face_each_other() -> None:
    data = project(count=2)
    data["panels"] |= {"joint": 10.0, "count": 3, "materials": {}}
    made = design(data)
    assert len(made.models) == MODELS
    for name in ("open", "narrow"):
        assert made.worth[f"seam_{name}_max_mm"] < 0.1  # beside the joint's 10 mm
    shared = {plate.mark: plate.shared for plate in made.panels}
    assert all("second" in own for mark, own in shared.items() if re.match("P-0[0-4]", mark))
    assert all("first" in own for mark, own in shared.items() if re.match("P-0[1-5]", mark))
    with pytest.raises(InputError, match="3 models side by side"):
        _ = made.model


@pytest.mark.slow
def test_models_that_look_inwards_are_turned_together() -> None:
    """The same roof with the other normal: its strips are counted the other way round."""
    text = BOWL.replace('x = "u"', 'x = "-u"')
    data = project(text)
    del data["panels"]["materials"]
    made = design(data)
    ends = [own.model.points(np.array([0.0]))[[0, -1], 0] for own in made.models]
    for before, after in pairwise(ends):
        assert np.linalg.norm(before[1] - after[0]) < np.linalg.norm(before[0] - after[1])
    assert made.worth["seam_open_max_mm"] < 0.05
    assert sorted({own.part for own in made.models}) == [(1, 3), (2, 3), (3, 3)]


@pytest.mark.slow
def test_five_models_cover_a_saddle_that_one_alone_cannot_follow() -> None:
    data = project(parts=5, count=4, segments=24)
    data["surface"] |= {"u": [-5.0, 5.0], "v": [-5.0, 5.0], "z": "0.15*(v**2 - u**2)"}
    data["panels"] = {"count": 1, "joint": 0.0, "choice": "single", "tolerance": 0.001}
    del data["nesting"], data["stock"]
    made = design(data)
    assert all(own.fit.status == "converged" for own in made.models)
    assert made.trims is not None
    whole, _ = dblquad(lambda v, u: np.hypot(1.0, 0.3 * np.hypot(u, v)), -5.0, 5.0, -5.0, 5.0)
    covered = sum(area(plate.mid) for plate in made.panels) + made.trims.lost
    assert covered / 1e6 == pytest.approx(whole, rel=5e-4)
    assert max(made.worth[f"seam_{name}_max_mm"] for name in ("open", "narrow")) < 1.0
    # Strips of 1.6 m deviate by 24 mm there: their edges may lie one above the other.
    assert made.worth["seam_step_max_mm"] < 6.0


def plank(segments: int, y: float, z: float, tilt: float = 0.0) -> Plate:
    """A plank of 2000 x 200 mm along x, from y on, rising across itself by an angle."""
    x = np.linspace(0.0, 2000.0, segments + 1)
    rise = 200.0 * np.array([np.cos(tilt), np.sin(tilt)])
    rows = [np.stack([x, 0 * x + y, 0 * x + z], 1), np.stack([x, 0 * x + y, 0 * x + z], 1)]
    rows[1][:, 1:] += rise
    model = model_through(np.stack(rows), False, False)
    return panels(model, cut(model, CutRule(count=1)), Layer("panel", 0.0, 3.0, "wood"))[0]


def test_what_lies_between_two_planks_is_told_in_plane_and_across() -> None:
    one, far, near = plank(8, 0.0, 0.0), plank(5, 213.0, 4.0), plank(5, 206.0, 0.0, 0.1)
    wide = between((one, far), (one.mid, far.mid), 10.0)
    assert wide is not None
    assert (wide.open, wide.narrow, wide.step) == pytest.approx((3.0, 0.0, 4.0), abs=1e-9)
    assert wide.gap == pytest.approx(np.hypot(13.0, 4.0) - 10.0)
    assert wide.length == pytest.approx(2000.0, rel=0.02)
    tight = between((one, near), (one.mid, near.mid), 10.0)
    assert tight is not None
    halves = 10.0 * np.cos(0.05)  # drawn back in either plank, which turn by 0.1
    assert (tight.open, tight.narrow) == pytest.approx((0.0, halves - 6.0), abs=1e-9)
    assert (tight.kink_own, tight.kink_added) == pytest.approx((np.degrees(0.1), 0.0), abs=1e-9)
    assert between((one, plank(5, 900.0, 0.0)), (one.mid, one.mid), 10.0) is None


def test_a_project_of_several_models_has_a_part_for_each() -> None:
    whole = parse_project(project())
    assert [own.strips.part for own in parts_of(whole)] == [(1, 3), (2, 3), (3, 3)]
    assert all(own.strips.parts is None for own in parts_of(whole))


@pytest.mark.parametrize(
    ("changes", "table", "words"),
    [
        ({}, {"cells": {}}, r"strips\.parts: .* leave \[cells\] out"),
        ({}, {"beams": {}}, r"strips\.parts: .* leave \[beams\] out"),
        ({"start": "iso"}, {}, 'parts needs start = "geodesic"'),
        ({"part": [1, 3]}, {}, "leave one out"),
        ({"give": 20.0}, {}, "give draws one model"),
        ({"parts": 0}, {}, "parts"),
    ],
)
def test_what_several_models_cannot_carry_is_refused_by_name(
    changes: dict[str, Any], table: dict[str, Any], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        parse_project({**project(**changes), **table})
