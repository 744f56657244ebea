"""Slits that pieces too small to make leave: their widths in closed form, and in a package."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np
import pytest

from fabgeo import build_package
from fabgeo.build.slits import slits_of
from fabgeo.build.trimming import trim_plates
from fabgeo.review.check import check_package
from fabgeo.strips.fence import Fence
from fabgeo.strips.model import Patch
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Plate

CELL, RULING, JOINT = 1800.0, 1700.0, 10.0


class Line:
    """Inside is where x is less than `start` on the first edge and more by a slant beyond it."""

    corners = np.empty((0, 3))

    def __init__(self, start: float, slant: float) -> None:
        self.start, self.slant = start, slant

    def __call__(self, points: np.ndarray) -> np.ndarray:
        across = self.start + self.slant * points[:, 1] - points[:, 0]
        return across / np.hypot(1.0, self.slant)


def flat(cell: int) -> tuple[Patch, Plate]:
    """A cell of a flat strip along x, rulings along y, joints taken off its ends."""
    low, high = CELL * cell + JOINT / 2.0, CELL * (cell + 1) - JOINT / 2.0
    knots = np.repeat([low, high], 4)
    sites = np.linspace(low, high, 4)
    first = np.column_stack([sites, np.zeros(4), np.zeros(4)])
    mid = RuledPatch.through(knots, sites, first, first + np.array([0.0, RULING, 0.0]))
    patch = Patch(0, cell, CELL * cell, CELL * (cell + 1))
    sides = {"end": 1} if cell == 0 else {"start": 0}
    shared = {side: Patch(0, other, 0.0, 1.0).mark for side, other in sides.items()}
    return patch, Plate(patch.mark, patch.mark, "panel", mid, 3.0, "aluminium", shared=shared)


@pytest.mark.parametrize("left", [12.0, 30.0, 75.0])
def test_a_slit_is_as_wide_as_what_was_left_out_and_its_joints(left: float) -> None:
    """The boundary comes in shortly before the first cell's end and runs on beside the second."""
    patches, plates = zip(*(flat(cell) for cell in (0, 1)), strict=True)
    fence = cast(Fence, Line(CELL - JOINT / 2.0 - left, 0.1))
    cuts, trims = trim_plates(patches, plates, fence, JOINT)
    assert [cut.plate.mark for cut in cuts] == ["P-00-00", "P-00-01"]
    assert trims.slivers == ("P-00-00",)
    assert "end" not in cuts[0].plate.shared
    (slit,) = slits_of({cut.whole.mark: [cut] for cut in cuts})
    assert slit.panels == ("P-00-00", "P-00-01")
    assert slit.width == pytest.approx(left + 1.5 * JOINT, abs=1e-6)
    assert "slits of up to" in str(replace(trims, slits=(slit,)))


def test_no_slit_where_nothing_was_left_out() -> None:
    patches, plates = zip(*(flat(cell) for cell in (0, 1)), strict=True)
    cuts, trims = trim_plates(patches, plates, cast(Fence, Line(CELL + 300.0, 0.1)), JOINT)
    assert slits_of({cut.whole.mark: [cut] for cut in cuts if cut.patch.cell < 2}) == ()
    assert "slit" not in str(trims)


PROJECT = {
    "name": "Slant",
    "surface": {
        "unit": "m",
        "u": [-3.0, 3.0],
        "v": [-2.4, 2.4],
        "x": "u + 0.06*v",
        "y": "v",
        "z": "4 - 0.05*(u + 0.06*v)**2 - 0.002*v**2",
    },
    "strips": {"kind": "general", "start": "principal", "count": 3, "segments": 6},
    "panels": {"length": 1500.0, "tolerance": 2.0, "choice": "single"},
    "stock": [{"material": "aluminium", "length": 9000.0, "width": 4000.0}],
    "nesting": {"steps": 1},
    "drawings": False,
}


@pytest.mark.slow
def test_a_package_states_its_slits_and_the_check_measures_them(tmp_path: Path) -> None:
    out = tmp_path / "out"
    trims = build_package(PROJECT, out).design.trims
    assert trims is not None
    slits = trims.slits
    assert len(slits) == 2
    report = check_package(out)
    assert report.ok, list(report.lines())
    table = out / "schedules" / "panels.csv"
    rows = list(csv.DictReader(table.read_text("utf-8").splitlines()))
    for slit in slits:
        for mark, other in (slit.panels, slit.panels[::-1]):
            row = next(row for row in rows if row["mark"] == mark)
            assert row["slit_edges"] == other
            assert row["verdict"] == "warn"
            assert f"mm stay open to {other}" in row["reason"]
            assert float(row["slit_max_mm"]) == pytest.approx(slit.width, abs=0.06)
    first, second = slits[0].panels
    text = table.read_text("utf-8")
    stated = f"{slits[0].width:.1f},"
    table.write_text(text.replace(f"{stated}{second}", f"{slits[0].width - 3.0:.1f},{second}"))
    assert [
        f.part for f in check_package(out).findings if "slit_max_mm of its solid" in f.what
    ] == [first]
