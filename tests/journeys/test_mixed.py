"""Structures of two layers from project files to solids and flat parts (paper, Fig. 7)."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fabgeo.arrays import dot, unit
from fabgeo.build import Package, build_package, design
from fabgeo.cad.readback import read_package_step
from fabgeo.errors import GeometryError, InputError
from fabgeo.fitting.store import save_model
from fabgeo.project import parse_project
from fabgeo.strips import exact
from fabgeo.structures.fixing import Fixing, LocalHole

RING, TUBE = 12_000.0, 6000.0
LOW, HIGH = np.pi / 2 - 0.2, np.pi / 2 + 0.2  # around the top circle of a torus, a roof


def _parallels(folder: Path) -> str:
    """Strips along parallel circles: a conical model with its chords on the torus."""
    angle = np.linspace(LOW, HIGH, 4)
    model = exact.revolution(
        RING + TUBE * np.cos(angle), TUBE * np.sin(angle), opening=0.3, segments=6
    )
    save_model(folder / "parallels.json", model.interpolant())
    return "parallels.json"


def _project(folder: Path, **tables: Any) -> dict[str, Any]:
    return {
        "name": "Roof",
        "surface": {
            "unit": "mm",
            "define": {"R": RING, "r": TUBE},
            "x": "(R + r * cos(v)) * cos(u)",
            "y": "(R + r * cos(v)) * sin(u)",
            "z": "r * sin(v)",
            "u": [0.0, 0.3],
            "v": [LOW, HIGH],
        },
        "strips": {"kind": "conical", "start": "model", "model": _parallels(folder)},
        "panels": {"count": 2, "thickness": 3.0, "tolerance": 3.0},
        "drawings": False,
        "limits": {"deviation_over_sag_limit": 4.0},
        **tables,
    }


def _built(folder: Path, data: dict[str, Any]) -> Package:
    return build_package(parse_project(data), folder / "out", base=folder)


def _whole(made: Package) -> None:
    """Every plate is a sound solid of its volume and a flat part."""
    plates = {plate.mark for plate in made.design.plates}
    assert plates == set(made.flats)
    for mark in plates:
        built = made.built[mark]
        assert built.report is not None, built.failure
        assert built.report.sound
        assert built.report.tolerance <= 1e-3
        assert built.volume_error is not None
        assert built.volume_error <= 1e-6


@pytest.mark.slow
def test_straight_beams_on_the_mesh_of_the_panels_corners(tmp_path: Path) -> None:
    beams = {"layout": "mesh", "depth": 150.0, "standoff": 27.0, "flange_width": 160.0}
    made = _built(tmp_path, _project(tmp_path, beams=beams, connectors={"end_distance": 160.0}))
    _whole(made)
    assert len(made.design.beams) == 4 * 2  # edges times bays
    (remark,) = made.design.remarks
    assert "quad mesh" in remark
    # The gap is what an edge of the model leaves its chord by, in the bay where that is most.
    away = []
    for bay in made.design.beams[:2]:
        edges = made.design.model.points(np.linspace(bay.u0, bay.u1, 65))
        chord = unit(edges[:, -1:] - edges[:, :1])
        off = edges - edges[:, :1]
        away.append(np.linalg.norm(off - dot(off, chord)[..., None] * chord, axis=-1).max())
    gaps = [float(word) for word in remark.split() if word.replace(".", "").isdigit()]
    assert gaps[0] == pytest.approx(max(away), abs=0.006)  # printed in hundredths
    # Edges are nearly the circles that they began as: a chord's sagitta.
    a, b = edges[0, 0], edges[0, -1]
    radius = np.hypot(*a[:2])
    assert gaps[0] == pytest.approx(np.linalg.norm(b - a) ** 2 / (8.0 * radius), rel=0.1)
    assert made.design.connectors
    assert {k.beam for k in made.design.connectors} <= {b.mark for b in made.design.beams}


@pytest.mark.slow
def test_beams_of_a_second_model_cross_those_of_the_first(tmp_path: Path) -> None:
    across = exact.meridians(
        RING, TUBE - 400.0, np.linspace(0.02, 0.28, 4), LOW, HIGH, segments=6
    ).interpolant()
    save_model(tmp_path / "across.json", across)
    section = {"depth": 150.0, "flange_width": 100.0}
    data = _project(tmp_path, beams=section, crossed={"model": "across.json", **section})
    made = _built(tmp_path, data)
    _whole(made)
    marks = {beam.mark for beam in made.design.beams}
    assert {f"B-{edge:02d}-1" for edge in range(8)} <= marks  # four edges of each model
    (remark,) = made.design.remarks
    angle, low, high = (float(x) for x in re.findall(r"\d+\.\d+", remark)[:3])
    assert angle > 80.0  # the fit is free to turn the first model a little on the torus
    assert 390.0 <= low <= high <= 410.0  # the second lies 400 mm inside


def test_a_model_along_the_first_and_a_missing_one_are_refused(tmp_path: Path) -> None:
    beams = {"depth": 150.0}
    data = _project(tmp_path, beams=beams, crossed={"model": "parallels.json"})
    with pytest.raises(GeometryError, match="meet at"):
        design(parse_project(data), base=tmp_path)
    data = _project(tmp_path, beams=beams, crossed={"model": "none.json"})
    with pytest.raises(InputError, match=r"none\.json"):
        design(parse_project(data), base=tmp_path)


def test_crossed_needs_beams(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="both are needed"):
        parse_project(_project(tmp_path, crossed={"model": "parallels.json"}))


@pytest.mark.slow
def test_a_bracket_of_the_user_goes_through_the_build(tmp_path: Path) -> None:
    def bracket(fixing: Fixing) -> object:
        import build123d as b3d

        low = (b3d.Align.CENTER, b3d.Align.CENTER, b3d.Align.MIN)
        return b3d.Box(60, 40, fixing.stand_off, align=low) - b3d.Cylinder(5.5, 200)

    own = Fixing(
        name="BLOCK",
        edge_distance=45.0,
        base_length=60.0,
        base_width=40.0,
        panel_holes=(LocalHole(diameter=11.0),),
        flange_holes=(LocalHole(diameter=11.0, slot=10.0, angle=np.pi / 2),),
        maker=bracket,
    )
    data = _project(tmp_path, beams={"depth": 150.0, "flange_width": 180.0}, connectors={})
    made = build_package(parse_project(data), tmp_path / "out", base=tmp_path, fixing=own)
    _whole(made)
    assert made.design.connectors
    assert {k.product.split("-")[0] for k in made.design.connectors} == {"BLOCK"}
    parts = read_package_step(made.path / "model" / "connectors.step")
    assert len(parts) == len(made.design.connectors)
    for part in parts:
        assert part.report.sound
        high = float(part.product.removeprefix("BLOCK-"))
        volume = high * (60.0 * 40.0 - np.pi * 5.5**2)
        assert part.report.volume == pytest.approx(volume, rel=1e-9)
    bored = sum(len(plate.holes) for plate in made.design.panels)
    assert bored == len(made.design.connectors)
