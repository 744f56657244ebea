"""The package that the command writes, seen through its files."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import ezdxf
import freecad
import pytest
from journey_helpers import DOME, fabgeo

from fabgeo.review.manifest import sha256_of


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_every_file_is_in_the_manifest_with_its_hash(dome: Path) -> None:
    manifest = json.loads((dome / "manifest.json").read_text())
    files = {
        path.relative_to(dome).as_posix()
        for path in dome.rglob("*")
        if path.is_file() and ".fabgeo" not in path.parts
    }
    assert files == {*manifest["files"], "manifest.json"}
    assert all(sha256_of(dome / name) == found for name, found in manifest["files"].items())
    assert set(manifest["not_asked"]) == {"cells", "beams", "connectors"}


def test_marks_agree_between_schedule_parts_and_sheets(dome: Path) -> None:
    panels = {row["mark"] for row in rows(dome / "schedules/panels.csv")}
    assert len(panels) == 12
    assert panels == {path.stem for path in (dome / "cut/parts").glob("*.dxf")}
    placed = [
        entity.dxf.text
        for path in (dome / "cut/nests").rglob("*.dxf")
        for entity in ezdxf.readfile(path).modelspace().query("TEXT[layer=='INFO']")
    ]
    assert sorted(text for text in placed if text in panels) == sorted(panels)


def test_every_drawing_passes_the_audit(dome: Path) -> None:
    for path in (dome / "cut").rglob("*.dxf"):
        document = ezdxf.readfile(path)
        assert not document.audit().errors, path.name
        assert document.header["$INSUNITS"] == 4


def test_the_check_passes_on_the_untouched_package(dome: Path) -> None:
    done = fabgeo("check", dome)
    assert done.code == 0, done.out + done.err


@pytest.mark.parametrize("fault", ["moved vertex", "removed part", "swapped label"])
def test_the_check_names_an_altered_part(dome: Path, tmp_path: Path, fault: str) -> None:
    copy = tmp_path / "altered"
    shutil.copytree(dome, copy)
    part = copy / "cut/parts/P-01-01.dxf"
    if fault == "removed part":
        part.unlink()
    else:
        document = ezdxf.readfile(part)
        space = document.modelspace()
        if fault == "moved vertex":
            outline = space.query("LWPOLYLINE[layer=='CUT_OUTER']")[0]
            points = outline.get_points()
            points[1] = (points[1][0] + 0.5, *points[1][1:])
            outline.set_points(points)
        else:
            space.query("TEXT[layer=='INFO']")[0].dxf.text = "P-02-01"
        document.saveas(part)
    done = fabgeo("check", copy)
    assert done.code == 1
    assert "P-01-01" in done.out


@pytest.mark.freecad
def test_freecad_sees_every_part_valid_and_named(dome: Path, tmp_path: Path) -> None:
    view = freecad.open_step(dome / "model/facade.step", tmp_path)
    panels = {row["mark"] for row in rows(dome / "schedules/panels.csv")}
    assert panels == {part.label for part in view.parts}
    assert all(part.valid and part.closed and part.solids == 1 for part in view.parts)


STRUCTURE = (
    DOME.partition("[panels]")[0].replace('start = "iso"', 'kind = "conical"\nstart = "principal"')
    + """
[cells]
depth = -300.0
material = "steel"
[beams]
section = "I"
depth = 200.0
material = "steel"
[nesting]
steps = 1
"""
)


@pytest.mark.slow
def test_a_structure_without_panels_is_written_and_checked(tmp_path: Path) -> None:
    """Its webs bend most at knots, between two samples of the check."""
    (tmp_path / "project.toml").write_text(STRUCTURE)
    out = tmp_path / "frame"
    built = fabgeo("build", tmp_path / "project.toml", "--out", out)
    assert built.code == 0, built.err
    assert {row["mark"][:1] for row in rows(out / "schedules/plates.csv")} == {"B"}
    assert "nothing found" in fabgeo("check", out).out


def test_a_model_alone_is_measured(tmp_path: Path) -> None:
    text = STRUCTURE.partition("[cells]")[0].replace('kind = "conical"', "")
    (tmp_path / "project.toml").write_text(text)
    built = fabgeo("build", tmp_path / "project.toml", "--out", tmp_path / "model", "--json")
    assert built.code == 0, built.err
    found = json.loads(built.out)
    assert found["parts"] == {}
    assert found["summary"]["twist_max_deg"] <= 0.02
