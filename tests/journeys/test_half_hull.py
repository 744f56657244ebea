"""A real CAD export, half a ship's hull: 12 trimmed faces with a fin, read and built."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from journey_helpers import fabgeo as command

import fabgeo
from fabgeo.surfaces.creases import sharpest

pytestmark = pytest.mark.slow

SKIN = [0, 1, 2, 3]  # without the bilge keel, a fin 50 mm thick, and the boss of the shaft
MIDSHIP = """
name = "Midship"
[surface]
file = "{file}"
faces = [0]
scale = 0.1
[strips]
count = 4
[panels]
length = 2200.0
joint = 8.0
tolerance = 3.0
[nesting]
seconds = 1.0
[[stock]]
material = "aluminium"
length = 6000.0
width = 2000.0
"""


def kernel_faces(path: Path) -> list:
    """The faces of a STEP file as the CAD kernel holds them."""
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    explorer, found = TopExp_Explorer(reader.OneShape(), TopAbs_FACE), []
    while explorer.More():
        found.append(TopoDS.Face_s(explorer.Current()))
        explorer.Next()
    return found


def test_its_faces_are_measured_and_its_fin_is_no_fold(shared_data: Path) -> None:
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    path = shared_data / "surfaces" / "half-hull.step"
    surface = fabgeo.read_surface(path)
    areas = []
    for face in kernel_faces(path):
        properties = GProp_GProps()
        BRepGProp.SurfaceProperties_s(face, properties, 1e-4)
        areas.append(properties.Mass())
    large = np.array(areas) > 1e6  # the fin's two end caps are 0.02 m2
    assert np.array(surface.face_areas)[large] == pytest.approx(np.array(areas)[large], rel=1e-2)
    assert surface.area == pytest.approx(sum(areas), rel=1e-3)
    assert len(surface.loops) == 1  # a disc: every other edge is shared
    crease = sharpest(surface)
    assert crease is not None
    assert 90.0 <= crease.degrees < 100.0  # the fin's flank on the skin, not flank against flank
    skin = fabgeo.read_surface(path, faces=SKIN)
    smooth = sharpest(skin)
    assert smooth is None or smooth.degrees < 7.0


def test_its_midship_builds_and_passes_its_check(shared_data: Path, tmp_path: Path) -> None:
    project = tmp_path / "midship.toml"
    project.write_text(MIDSHIP.format(file=(shared_data / "surfaces" / "half-hull.step").resolve()))
    done = command("build", project, "--out", tmp_path / "out", "--jobs", "1")
    assert done.code == 0, done.out + done.err
    review = json.loads((tmp_path / "out/checks/review.json").read_text())
    assert review["summary"]["failed_verdicts"] == 0
    assert review["summary"]["twist_max_deg"] <= 0.02
    checked = command("check", tmp_path / "out")
    assert checked.code == 0, checked.out
    assert "nothing found" in checked.out
