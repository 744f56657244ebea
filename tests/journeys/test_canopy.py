"""The canopy from its STEP face to its STEP model: cells, walls, beams, fixings as they must be."""

from __future__ import annotations

from pathlib import Path

import freecad
import numpy as np
import pytest

from fabgeo.arrays import dot
from fabgeo.build import Package, build_package
from fabgeo.build.facts import twist_of
from fabgeo.cad.readback import ReadPart, read_package_step
from fabgeo.structures.parts import Plate
from fabgeo.structures.prisms import ruled_normals

PROJECT = Path(__file__).resolve().parents[2] / "fixtures" / "canopy" / "project.toml"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def canopy(tmp_path_factory: pytest.TempPathFactory) -> Package:
    return build_package(PROJECT, tmp_path_factory.mktemp("canopy") / "out")


@pytest.fixture(scope="module")
def read(canopy: Package) -> list[ReadPart]:
    return read_package_step(canopy.path / "model" / "facade.step")


def test_the_model_is_developable_and_conical_and_its_offset_exact(canopy: Package) -> None:
    summary = canopy.review["summary"]
    assert summary["twist_max_deg"] <= 0.01
    assert summary["conical_residual"] <= 1e-4
    assert summary["offset_distance_error_mm"] <= 0.01


def test_every_solid_is_sound_and_of_its_volume(canopy: Package) -> None:
    assert set(canopy.built) == {p.mark for p in (*canopy.design.plates, *canopy.design.cells)}
    for built in canopy.built.values():
        assert built.report is not None, built.failure
        assert built.report.sound, built.mark
        assert built.report.tolerance <= 1e-3, built.mark
        assert built.volume_error is None or built.volume_error <= 1e-6, built.mark


def test_every_panel_is_fixed_and_nothing_clashes(canopy: Package) -> None:
    design = canopy.design
    assert not design.complaints
    assert {k.panel for k in design.connectors} == {p.mark for p in design.panels}
    stand_offs = [fixing.stand_off for fixing in design.products.values()]
    assert max(stand_offs) - min(stand_offs) <= 8.0  # the screws' reach


def test_flanges_are_square_to_webs_and_depth_is_constant(canopy: Package) -> None:
    for beam in canopy.design.beams:
        assert beam.info["depth_max"] - beam.info["depth_min"] <= 0.05
        plates = {plate.role: plate for plate in beam.plates}
        web = _normals(plates["web"])
        for role in ("flange_outer", "flange_inner"):
            tilt = np.degrees(np.arcsin(np.abs(dot(web, _normals(plates[role])))))
            assert tilt.max() <= 0.01, plates[role].mark
            assert twist_of(plates[role]) <= 0.01


def test_the_step_file_holds_every_part_under_its_mark(
    canopy: Package, read: list[ReadPart]
) -> None:
    design = canopy.design
    solids = {part.mark for part in (*design.plates, *design.cells)}
    assert solids <= {part.name for part in read}
    fixings = {k.mark for k in design.connectors}
    assert fixings <= {name for part in read for name in part.path} | {p.name for p in read}


@pytest.mark.freecad
def test_freecad_opens_it_with_all_labels(
    canopy: Package, read: list[ReadPart], tmp_path: Path
) -> None:
    view = freecad.open_step(canopy.path / "model" / "facade.step", tmp_path, seconds=590.0)
    assert len(view.parts) == len(read)
    assert all(p.valid and p.closed for p in view.parts)
    labels = {p.label for p in view.parts} | set(view.groups)
    design = canopy.design
    assert {part.mark for part in (*design.plates, *design.cells)} <= labels
    assert {k.mark for k in design.connectors} <= labels


def _normals(plate: Plate) -> np.ndarray:
    return ruled_normals(plate.mid, np.linspace(plate.mid.u0, plate.mid.u1, 33))
