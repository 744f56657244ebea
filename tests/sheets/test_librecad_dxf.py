"""LibreCAD opens written files and prints them at their right size."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import zlib
from pathlib import Path

import numpy as np
import pytest
from sheet_parts import wavy_part

from fabgeo.sheets.dxf import DxfStyle, write_part, write_sheet
from fabgeo.sheets.nest import nest
from fabgeo.sheets.stock import Stock

PAGE = 420.0  # mm: LibreCAD prints on A3, and what lies beyond the page stays in the file


def printed(path: Path) -> np.ndarray:
    """Size (2,) in mm of what LibreCAD prints of a file at scale 1."""
    command = shutil.which("librecad")
    if command is None:
        pytest.skip("librecad is not installed")
    made = path.with_suffix(".pdf")
    subprocess.run(
        [command, "dxf2pdf", "-p", "420x297", "-s", "1", "-o", str(made), str(path)],
        env={**os.environ, "QT_QPA_PLATFORM": "offscreen"},
        capture_output=True,
        timeout=120,
        check=True,
    )
    content = b""
    for stream in re.findall(rb"stream\r?\n(.*?)endstream", made.read_bytes(), re.DOTALL):
        try:
            content = max(content, zlib.decompress(stream), key=len)
        except zlib.error:
            continue
    page, drawing = content.split(b"W*", 1)
    wide = max(float(x) for x in re.findall(rb"([\d.]+) 0 l\n", page))
    points = np.array(re.findall(rb"(-?[\d.]+) (-?[\d.]+) [ml]\n", drawing), dtype=float)
    return np.ptp(points, axis=0) * PAGE / wide


@pytest.mark.parametrize("version", ["R12", "R2000", "R2010"])
def test_a_part_has_its_size(tmp_path: Path, version: str) -> None:
    path = tmp_path / "part.dxf"
    write_part(wavy_part(), path, DxfStyle(version=version))
    assert printed(path) == pytest.approx([1500.0, 700.0], rel=1e-3)


def test_a_sheet_has_its_size(tmp_path: Path) -> None:
    part = wavy_part()
    stock = Stock("3000", part.material, part.thickness, 3000.0, 1500.0)
    (made,) = nest([part], [stock], steps=1)
    path = tmp_path / "sheet.dxf"
    write_sheet(made.sheets[0], {part.mark: part}, path)
    length, height = printed(path)  # its title stands above it
    assert length == pytest.approx(3000.0, rel=1e-3)
    assert 1500.0 * (1.0 - 1e-3) < height < 1700.0
