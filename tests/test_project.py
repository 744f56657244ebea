"""Project files: what is wrong is named with its key and its cure."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from fabgeo.build.template import TEMPLATE, write_template
from fabgeo.errors import InputError
from fabgeo.project import Project, parse_project, read_project

SURFACE = {"surface": {"file": "roof.step"}}
LAYER = {"distance": 50.0, "thickness": 2.0, "material": "steel"}
SHEET = {"material": "steel", "length": 2000.0, "width": 1000.0}


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({}, r"\[surface\] is missing"),
        ({**SURFACE, "panles": {}}, "did you mean 'panels'"),
        ({"surface": {"file": "a.step", "unti": "m"}}, "surface.unti, did you mean 'unit'"),
        ({**SURFACE, "panels": {"thickness": -1}}, "panels.thickness.*greater than 0, found -1"),
        ({**SURFACE, "panels": {"material": "steal"}}, "did you mean 'steel'"),
        ({**SURFACE, "panels": {"thickness": float("nan")}}, "panels.thickness"),
        ({"surface": {"file": "a", "x": "u"}}, "either file, or a formula"),
        ({"surface": {"x": "u", "y": "v", "z": "0", "u": [0, 1], "v": [0, 1]}}, "needs its unit"),
        ({**SURFACE, "name": "../evil"}, "letters, digits"),
        ({**SURFACE, "materials": {"../x": {"density": 1}}}, "materials"),
        ({**SURFACE, "panels": {"materials": {"P-00-00": "../x"}}}, "letters, digits"),
        ({**SURFACE, "panels": {"layers": [{**LAYER, "name": "../x"}]}}, "layers.*name.*pattern"),
        ({**SURFACE, "stock": [{**SHEET, "material": "a/b"}]}, "letters, digits"),
        ({**SURFACE, "stock": [{**SHEET, "name": "a\nb"}]}, "stock.*name.*pattern"),
        ({**SURFACE, "cutting": {"layers": {"MARK": "A\n0\nLINE"}}}, "layers.MARK.*pattern"),
        ({**SURFACE, "cutting": {"version": "R12", "curves": "splines"}}, "cutting.*no splines"),
        ({**SURFACE, "connectors": {}}, "both are needed"),
        ({**SURFACE, "strips": {"kind": "conic"}}, "strips.kind"),
        ({**SURFACE, "strips": {"part": [1, 5]}}, 'part needs start = "geodesic"'),
        ({**SURFACE, "strips": {"start": "geodesic", "part": [6, 5]}}, "no model 6 of 5"),
        ({**SURFACE, "strips": {"segments": 10**6}}, "strips.segments.*10000, found 1000000"),
        ({**SURFACE, "strips": {"start": "geodesic", "parts": 10**9}}, r"strips\.parts.*1000, f"),
        ({**SURFACE, "strips": {"start": "geodesic", "part": [1, 10**9]}}, r"strips\.part.*1000"),
        ({**SURFACE, "strips": {"start": "principal", "overhang": [0.1, 0.1]}}, 'start = "iso"'),
        ({**SURFACE, "panels": {"count": 10**30}}, "panels.count.*100000"),
        ({**SURFACE, "panels": {"count": 2, "length": 500.0}}, "takes one of length, count and c"),
        ({**SURFACE, "panels": {"cuts": [1, 1]}}, "panels: cuts: holds a parameter twice"),
        ({**SURFACE, "panels": {"radii": []}}, "panels.radii: .*at least 1 item"),
        ({**SURFACE, "panels": {"radii": 0}}, r"project: panels\.radii: .*, or .*found 0;"),
        ({**SURFACE, "str": {}}, "unknown key str, did you mean 'strips'"),
        ({**SURFACE, "self": 1}, "unknown key self"),
        ({**SURFACE, "materials": {"float": {"densty": 3}}}, r"materials\.float\.densty, did"),
        ({**SURFACE, "materials": {"steel": 5}}, "materials.steel: .*dictionary.*found 5"),
        ([], "expected tables"),
        ({1: 2}, "expected tables"),
    ],
)
def test_wrong_projects_are_refused_by_key(data: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        parse_project(data)


def test_all_errors_are_told_at_once() -> None:
    with pytest.raises(InputError) as caught:
        parse_project({**SURFACE, "panels": {"joint": -2}, "beams": {"web": "thick"}})
    assert "panels.joint" in str(caught.value)
    assert "beams.web" in str(caught.value)


def test_files_that_are_missing_or_no_toml_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_project(tmp_path / "none.toml")
    path = tmp_path / "p.toml"
    path.write_text("name = \n")
    with pytest.raises(InputError, match=r"p\.toml.*line 1"):
        read_project(path)
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="UTF-8"):
        read_project(path)


def test_the_template_reads_as_it_is_and_with_every_line_uncommented(tmp_path: Path) -> None:
    path = write_template(tmp_path / "project.toml")
    assert read_project(path).panels is not None
    with pytest.raises(InputError, match="is there already"):
        write_template(path)
    lines = []
    for line in TEMPLATE.splitlines():
        bare = line.removeprefix("# ")
        code = bare.split("#")[0].strip()
        option = line.startswith("# ") and (code.startswith("[") or " = " in code)
        either_or = code.split(" ")[0] in ("file", "unit", "faces")
        prose = line.startswith("#   ") or either_or
        lines.append(bare if option and not prose else line)
    text = "\n".join(lines).replace('kind = "general" ', 'kind = "conical" ')
    path.write_text(text)
    project = read_project(path)
    assert project.cells is not None
    assert project.connectors is not None
    assert project.cutting.version == "R2010"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"a = " + b"[" * 100_000, "nested without end"),
        (b"a = " + b"9" * 5000, "digits"),
        (b"a." * 50_000 + b"b = 1", "a key of more than 100 parts"),
        (b'"a" . ' * 200 + b"b = 1", "a key of more than 100 parts"),
        (b"#" * (1 << 21), "expected 1,048,576 at most"),
        ('name = "H\u00f6he"'.encode("utf-16"), "save it as UTF-8"),
        ('name = "H\u00f6he"'.encode("latin-1"), "save it as UTF-8"),
    ],
)
def test_files_that_no_one_writes_are_refused(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "p.toml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=words):
        read_project(path)


def test_only_files_are_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")  # one that is read is waited for
    for path in (tmp_path / "pipe.toml", tmp_path, "/dev/zero"):
        with pytest.raises(InputError, match="is no file"):
            read_project(path)
    for none in (None, 5, "a\0b"):
        with pytest.raises(InputError, match="expected a path"):
            read_project(none)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="no such file"):
        read_project("a" * 300)


def test_the_mark_of_a_byte_order_is_no_part_of_a_project(tmp_path: Path) -> None:
    path = tmp_path / "p.toml"
    path.write_text('[surface]\nfile = "roof.step"\n', encoding="utf-8-sig")
    assert read_project(path) == parse_project(SURFACE)


def test_a_project_says_what_is_wrong_with_it() -> None:
    with pytest.raises(InputError, match=r"\[surface\] is missing"):
        Project()
    with pytest.raises(InputError, match="did you mean 'panels'"):
        Project(**SURFACE, panles={})
    assert Project(**SURFACE, panels={"count": 100_000}) == parse_project(
        {**SURFACE, "panels": {"count": 100_000}}
    )


def test_own_materials_extend_the_known_ones() -> None:
    project = parse_project({**SURFACE, "materials": {"aluminium": {"yield_stress": 200.0}}})
    assert project.material("aluminium").yield_stress == 200.0
    assert project.material("aluminium").density == 2660.0
    assert project.material("steel").density == 7850.0
