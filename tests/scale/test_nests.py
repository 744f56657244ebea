"""Nests of earlier builds: found, mended where little changed, laid anew where steps say so."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fabgeo.build.cache import Cache
from fabgeo.build.nests import nests_of
from fabgeo.build.progress import Clock
from fabgeo.panels.flat import FlatPart
from fabgeo.panels.unfold import unfold
from fabgeo.project import Project, parse_project
from fabgeo.sheets.pieces import piece_of
from fabgeo.sheets.stock import Nest
from fabgeo.sheets.verify import check_nest
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Plate

KNOTS = np.array([0.0, 0, 0, 0, 1, 1, 1, 1])


def plates(count: int = 40) -> list[Plate]:
    out = []
    for k in range(count):
        s = np.linspace(0.0, 500.0 + 10.0 * (k % 40), 4)
        edges = np.stack([np.stack([s, 0 * s + y, 0 * s], axis=-1) for y in (0.0, 300.0)])
        mark = f"P-{k // 60:02d}-{k % 60:02d}"
        out.append(Plate(mark, mark, "panel", RuledPatch(KNOTS, edges), 3.0, "aluminium"))
    return out


def project(**nesting: float) -> Project:
    plane = {"unit": "m", "u": [0, 9], "v": [0, 9], "x": "u", "y": "v", "z": "0*u"}
    return parse_project({"surface": plane, "panels": {}, "nesting": nesting})


def solved(asked: Project, parts: list[Plate], cache: Cache) -> tuple[list[Nest], list[FlatPart]]:
    flats = {p.mark: unfold(p.mid, p.mark, p.material, p.thickness) for p in parts}
    return nests_of(asked, parts, flats, Clock(), cache), list(flats.values())


def assert_sound(nest: Nest, flats: list[FlatPart]) -> None:
    pieces = {flat.mark: piece_of(flat) for flat in flats}
    marks = [p.mark for sheet in nest.sheets for p in sheet.placements]
    problems = check_nest(
        nest,
        {mark: pieces[mark].contour for mark in marks},
        {mark: pieces[mark].rotations for mark in marks},
        dict.fromkeys(marks, 1),
    )
    assert problems == []
    area = sum(pieces[mark].area for mark in marks)
    bought = sum(sheet.stock.length * sheet.stock.width for sheet in nest.sheets)
    assert np.isclose(nest.utilisation, area / bought, rtol=1e-9)


def test_one_part_less_leaves_the_others_where_they_are(tmp_path: Path) -> None:
    asked, parts = project(seconds=2.0), plates()
    (before,), _ = solved(asked, parts, Cache(tmp_path))
    parts[7] = replace(parts[7], material="steel")
    (alu, steel), flats = solved(asked, parts, Cache(tmp_path))
    places = {p.mark: p for sheet in before.sheets for p in sheet.placements}
    kept = {p.mark: p for sheet in alu.sheets for p in sheet.placements}
    assert kept == {mark: place for mark, place in places.items() if mark != "P-00-07"}
    assert [p.mark for sheet in steel.sheets for p in sheet.placements] == ["P-00-07"]
    for nest in (alu, steel):
        assert_sound(nest, flats)
    back, _ = solved(asked, plates(), Cache(tmp_path))
    assert back == [before]  # found as it was


@pytest.mark.slow
def test_steps_give_the_layout_of_a_first_build(tmp_path: Path) -> None:
    asked, parts = project(steps=1), plates()
    solved(asked, parts, Cache(tmp_path))
    assert solved(asked, parts[:-1], Cache(tmp_path))[0] == solved(asked, parts[:-1], Cache())[0]


@pytest.mark.slow
def test_chains_side_by_side_are_those_one_after_the_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("fabgeo.build.nests.AT_ONCE", 20)  # a small group counts as a large one
    asked, parts = project(steps=1), plates(24)
    flats = {p.mark: unfold(p.mid, p.mark, p.material, p.thickness) for p in parts}
    (one,), (two,) = (nests_of(asked, parts, flats, jobs=jobs) for jobs in (1, 2))
    assert one == two
    assert_sound(one, list(flats.values()))
    assert sorted(p.mark for s in one.sheets for p in s.placements) == sorted(flats)
    assert [s.name for s in one.sheets] == [f"SHEET-{k:03d}" for k in range(1, len(one.sheets) + 1)]
