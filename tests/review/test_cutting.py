"""Packages whose outlines are written in other ways: the check knows how far they may be off."""

from __future__ import annotations

from pathlib import Path

import pytest
import test_check_faults as faults

from fabgeo import build_package
from fabgeo.review.check import check_package

PROJECT = {
    "name": "Vault",
    "surface": {
        "unit": "m",
        "u": [-2.0, 2.0],
        "v": [-2.5, 2.5],
        "x": "u + 0.1*v",
        "y": "v",
        "z": "3 - 0.06*u**2 - 0.05*v**2",
    },
    "strips": {"kind": "general", "start": "principal", "count": 2, "segments": 4},
    "panels": {"length": 2600.0, "tolerance": 2.0, "choice": "single"},
    "stock": [{"material": "aluminium", "length": 6000.0, "width": 3000.0}],
    "nesting": {"steps": 1},
    "drawings": False,
}


@pytest.mark.slow
@pytest.mark.parametrize("curves", ["arcs", "polylines", "splines"])
def test_outlines_are_judged_by_the_tolerance_that_they_are_written_to(
    tmp_path: Path, curves: str
) -> None:
    """An untouched package has no finding; a vertex off by three times the tolerance is found."""
    out = tmp_path / "out"
    package = build_package({**PROJECT, "cutting": {"curves": curves, "tolerance": 0.3}}, out)
    mark = package.design.panels[-1].mark
    report = check_package(out)
    assert report.ok, list(report.lines())
    if curves == "splines":
        return

    def change(lines: list[str]) -> list[str]:
        return faults.shift(lines, faults.entity(lines, "LWPOLYLINE", "CUT_OUTER"), "20", 1, -0.9)

    faults.groups(faults.part_file(out, mark), change)
    found = {part for part in check_package(out).parts if part.startswith("P-")}
    assert found == {mark}
