"""FreeCAD opens the written part at its right size in millimetres."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from sheet_parts import wavy_part

from fabgeo.sheets.dxf import DxfStyle, write_part

SCRIPT = """
import FreeCAD, Import
document = FreeCAD.newDocument("part")
Import.readDXF({path!r}, "part")
box = FreeCAD.BoundBox()
shapes = [o.Shape for o in document.Objects if hasattr(o, "Shape") and o.Shape.Edges]
for shape in shapes:
    for edge in shape.Edges:
        for point in edge.discretize(50):
            box.add(point)
print("SIZE", len(shapes), box.XMin, box.YMin, box.XMax, box.YMax)
"""


@pytest.mark.freecad
@pytest.mark.parametrize("version", ["R12", "R2000", "R2010"])
def test_freecad_reads_the_part_in_millimetres(tmp_path: Path, version: str) -> None:
    command = shutil.which("freecadcmd")
    if command is None:
        pytest.skip("freecadcmd is not installed")
    path, script = tmp_path / "part.dxf", tmp_path / "read.py"
    write_part(wavy_part(), path, DxfStyle(version=version))
    script.write_text(SCRIPT.format(path=str(path)))
    result = subprocess.run([command, str(script)], capture_output=True, text=True, timeout=300)
    (line,) = [x for x in result.stdout.splitlines() if "SIZE" in x]
    count, *box = line[line.index("SIZE") :].split()[1:]
    assert int(count) > 0
    assert [float(x) for x in box] == pytest.approx([0.0, 0.0, 1500.0, 700.0], abs=0.1)
