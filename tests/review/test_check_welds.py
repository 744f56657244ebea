"""Bevels, grooves and gaps of plates that are known in closed form; how straight planks lie."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fabgeo.review.check_planks import check_planks
from fabgeo.review.check_welds import check_welds
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage
from fabgeo.review.solid_plate import SolidPlate, _thickness

T, GAP = 10.0, 3.0
RUN = T * np.tan(np.radians(30.0))  # of a groove of 60 degrees


def line(a: Any, b: Any) -> np.ndarray:
    return np.linspace(np.array(a, dtype=float), np.array(b, dtype=float), 65)


def web(mark: str, x0: float, x1: float, begin: float, end: float) -> SolidPlate:
    """A flat web 100 mm high from x0 to x1, one skin of it longer by a run at each end."""
    edges = (
        line([x0, 0, 0], [x1, 0, 0]),
        line([x1, 0, 0], [x1, 100, 0]),
        line([x1, 100, 0], [x0, 100, 0]),
        line([x0, 100, 0], [x0, 0, 0]),
    )
    through = np.array([[0, 0, T], [end, 0, T], [0, 0, T], [-begin, 0, T]])
    volume, centre = 100.0 * T * (x1 - x0), np.zeros(3)
    return SolidPlate(mark, volume, centre, edges, (True,) * 4, T, (), through=through)


def package(beams: list[dict[str, str]], plates: list[dict[str, str]]) -> WrittenPackage:
    project = {"beams": {"bevel": 60.0, "weld_gap": GAP}}
    own = WrittenPackage(Path(), {"project": project})
    own.__dict__["tables"] = {"beams": beams, "plates": plates}
    nodes = {"B-01-1": (0.0, 1000.0), "B-01-2": (1000.0, 2000.0)}
    own.__dict__["setout"] = {
        beam: [
            {"point": f"{beam}/{k}", "x": f"{x}", "y": "0", "z": "0"} for k, x in enumerate(ends, 1)
        ]
        for beam, ends in nodes.items()
    }
    return own


def rows() -> tuple[list[dict[str, str]], list[dict[str, str]]]:
    """Two segments welded to each other: one is bevelled at its end, the next at its start."""
    beams = [
        {"mark": f"B-01-{k}", "groove_deg": "60.0", "weld_gap_mm": f"{GAP:.2f}"} for k in (1, 2)
    ]
    plates = [
        {"mark": f"B-01-{k}-WEB", "parent": f"B-01-{k}", "role": "web",
         f"bevel_{end}_mm": f"{RUN:.2f}"} for k, end in ((1, "end"), (2, "start"))
    ]  # fmt: skip
    return beams, plates


def found(beams: list[dict[str, str]], plates: list[dict[str, str]]) -> list[tuple[str, str]]:
    half = 0.5 * (GAP + RUN)
    measured, findings = Measured(), Findings()
    measured.plates = {
        "B-01-1-WEB": web("B-01-1-WEB", 0.0, 1000.0 - half, 0.0, RUN),
        "B-01-2-WEB": web("B-01-2-WEB", 1000.0 + half, 2000.0, RUN, 0.0),
    }
    check_welds(package(beams, plates), measured, findings)
    return [(finding.part, finding.what.partition(" ")[0]) for finding in findings.items]


def test_segments_are_welded_as_their_rows_say() -> None:
    assert not found(*rows())


@pytest.mark.parametrize(
    ("table", "mark", "changes", "expected"),
    [
        (1, "B-01-1-WEB", {"bevel_end_mm": "6.50"}, {"bevel_end_mm"}),
        (1, "B-01-1-WEB", {"bevel_end_mm": ""}, {"bevel_end_mm"}),
        (1, "B-01-2-WEB", {"bevel_end_mm": "2.00"}, {"bevel_end_mm"}),
        (
            1,
            "B-01-2-WEB",
            {"bevel_start_mm": "", "bevel_end_mm": "5.77"},
            {"bevel_start_mm", "bevel_end_mm"},
        ),
        (0, "B-01-2", {"groove_deg": "50.0"}, {"groove_deg"}),
        (0, "B-01-2", {"groove_deg": ""}, {"groove_deg"}),
        (0, "B-01-1", {"weld_gap_mm": "4.00"}, {"weld_gap_mm"}),
    ],
)
def test_what_the_solids_have_not_is_named(
    table: int, mark: str, changes: dict[str, str], expected: set[str]
) -> None:
    own = rows()
    next(row for row in own[table] if row["mark"] == mark).update(changes)
    names = found(*own)
    assert {part for part, _ in names} == {mark}
    assert {what for _, what in names} == expected


def test_bevelled_sides_do_not_make_a_plate_thicker() -> None:
    square = line([0, 0, 0], [100, 0, 0]), line([0, 0, T], [100, 0, T])
    slanted = square[0], square[1] + [RUN, 0.0, 0.0]
    assert _thickness([square, slanted, square, slanted]) == pytest.approx(T, rel=1e-12)
    assert _thickness([square] * 4) == pytest.approx(T, rel=1e-12)


def test_a_plank_sags_as_the_arc_that_it_is() -> None:
    """A flat ring's sector of 0.2 rad between 5.0 and 5.4 m: R (1 - cos 0.1)."""
    angles = np.linspace(-0.1, 0.1, 65)
    arc = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(65)])
    inner, outer = 5000.0 * arc, 5400.0 * arc
    edges = inner, line(inner[-1], outer[-1]), outer[::-1], line(outer[0], inner[0])
    plate = SolidPlate("P-00-00", 1.0, np.zeros(3), edges, (False, True, False, True), 3.0, ())
    sag = 5200.0 * (1.0 - np.cos(0.1))
    measured = Measured(plates={"P-00-00": plate})
    sides = {"flat_length_mm": "2000", "flat_width_mm": "500", "area_m2": "0.5"}
    for stated, share, named in ((sag, 0.5, 0), (sag + 0.1, 0.5, 1), (sag, 0.6, 1)):
        row = {"mark": "P-00-00", "plank_sag_mm": f"{stated:.3f}", "plank_yield": f"{share:.4f}"}
        own, findings = (
            WrittenPackage(Path(), {"project": {"strips": {"kind": "geodesic"}}}),
            Findings(),
        )
        own.__dict__["tables"] = {"panels": [row | sides]}
        check_planks(own, measured, findings)
        assert len(findings.items) == named
