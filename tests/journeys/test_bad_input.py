"""Bad input: exit code 2, one line that names file or part and cure, nothing written."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from journey_helpers import DOME, fabgeo

from fabgeo.build import build_package, design
from fabgeo.build.fitted import lane_counts, patches_of
from fabgeo.errors import GeometryError, InputError, MissingExtraError
from fabgeo.project import parse_project
from fabgeo.strips.model import StripModel

CUBE = "OFF\n8 6 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n"
GRID = [(x, y) for y in range(4) for x in range(4)]


def obj(faces: list[tuple[int, ...]] | None = None, nan: bool = False) -> str:
    lines = [f"v {2 * x} {2 * y} {0.1 * x * y}" for x, y in GRID]
    if nan:
        lines[5] = "v nan 0 0"
    quads = [
        (4 * j + i + 1, 4 * j + i + 2, 4 * j + i + 6, 4 * j + i + 5)
        for j in range(3)
        for i in range(3)
    ]
    for face in quads if faces is None else quads + faces:
        lines.append("f " + " ".join(map(str, face)))
    return "\n".join(lines) + "\n"


FILES = {
    "missing.obj": (None, "no such file"),
    "empty.obj": ("", "empty.obj"),
    "nan.obj": (obj(nan=True), "nan.obj"),
    "many.obj": (obj(faces=[(1, 2, 16)]), "many.obj"),
    "one.off": (
        CUBE + "4 1 2 3 4\n4 5 6 7 8\n4 1 2 6 5\n4 2 3 7 6\n4 3 4 8 7\n4 4 1 5 8\n",
        "index",
    ),
    "nothing.step": (
        "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n",
        "step",
    ),
    "crossing.csv": (
        "section,x,y,z\n"
        + "\n".join(
            f"{k},{x},{y},{3 * k}" for k in range(3) for x, y in [(0, 0), (9, 9), (9, 0), (0, 9)]
        ),
        "cross",
    ),
}


@pytest.mark.parametrize("name", FILES)
def test_bad_surface_files(tmp_path: Path, name: str) -> None:
    content, words = FILES[name]
    if content is not None:
        (tmp_path / name).write_text(content)
    project = tmp_path / "p.toml"
    project.write_text(f'[surface]\nfile = "{name}"\nunit = "m"\n[panels]\ncount = 2\n')
    done = fabgeo("build", project, "--out", tmp_path / "out")
    assert done.code == 2, done.out + done.err
    assert words in done.err.lower()
    assert name in done.err
    assert len(done.err.strip().splitlines()[-1]) > 20
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("count = 4", "kind = 'conical'\ncount = 4", "radius"),
        ("count = 4", "count = 100000", "strips"),
        ("length = 6000.0\nwidth = 2000.0", "length = 600.0\nwidth = 500.0", "larger than every"),
        ("count = 4", "cuont = 4", "did you mean 'count'"),
        ('unit = "m"', 'unit = "mm"', "unit"),
        ("0.05*u**2", "0.05*w**2", "w"),
        ("0.05*u**2", "__import__('os')", "formula"),
        ("length = 2700.0", "length = 2700.0\ncount = 3", "takes one of length, count and cuts"),
        ('count = 4\nstart = "iso"', "start = 'model'\nmodel = '/dev/zero'", "is no file"),
    ],
)
def test_bad_projects(tmp_path: Path, old: str, new: str, words: str) -> None:
    project = tmp_path / "p.toml"
    text = DOME.replace(old, new)
    if "conical" in new:  # an offset beyond the radius of curvature, 10 m
        text += "[cells]\ndepth = -30000.0\n"
    project.write_text(text)
    done = fabgeo("build", project, "--out", tmp_path / "out")
    assert done.code == 2, done.out + done.err
    assert words in done.err
    assert not (tmp_path / "out").exists()


def test_quads_with_a_hole_are_no_start(tmp_path: Path) -> None:
    quads = [line for line in obj().splitlines() if line != "f 6 7 11 10"]
    (tmp_path / "hole.obj").write_text("\n".join(quads) + "\n")
    project = tmp_path / "p.toml"
    project.write_text('[surface]\nfile = "hole.obj"\nunit = "m"\n[strips]\nstart = "mesh"\n')
    done = fabgeo("build", project, "--out", tmp_path / "out")
    assert done.code == 2
    assert "hole.obj" in done.err
    assert "2 boundary loops, the smallest around (3000, 3000," in done.err
    assert not (tmp_path / "out").exists()


def test_an_output_path_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "p.toml").write_text(DOME)
    (tmp_path / "out").write_text("keep me")
    done = fabgeo("build", tmp_path / "p.toml", "--out", tmp_path / "out")
    assert done.code == 2
    assert (tmp_path / "out").read_text() == "keep me"


def test_a_model_at_a_small_scale_is_told_from_a_building(tmp_path: Path) -> None:
    import build123d as b3d

    b3d.export_step(b3d.Sphere(30.0).faces()[0], tmp_path / "ball.step")
    project = tmp_path / "p.toml"
    project.write_text('[surface]\nfile = "ball.step"\n[panels]\ncount = 2\n')
    done = fabgeo("build", project, "--out", tmp_path / "out")
    assert done.code == 2
    assert "surface.scale" in done.err
    assert not (tmp_path / "out").exists()


def test_structure_on_a_fit_short_of_its_kind_tells_why_the_fit_ended():
    """From a dome to a saddle: no conical model crosses the line between."""
    project = {
        "surface": {
            **{"unit": "m", "u": [-3.0, 3.0], "v": [-3.0, 3.0]},
            **{"x": "u", "y": "v", "z": "0.6*cos(0.8*u)*cos(0.6*v)"},
        },
        "strips": {"kind": "conical", "start": "iso", "count": 5, "segments": 6},
        "panels": {"count": 2, "choice": "single"},
        "cells": {"depth": -200.0},
    }
    with pytest.raises(GeometryError, match="the fit ended short of its limits: strip") as refused:
        design(project)
    assert "kind =" not in str(refused.value)
    assert "divide the surface" in str(refused.value)


FORMULA = {"unit": "m", "u": [-3.0, 3.0], "v": [-4.0, 4.0], "x": "u", "y": "v", "z": "3-0.05*u*u"}


@pytest.mark.parametrize(
    ("project", "arguments", "words"),
    [
        (None, {}, "expected a Project, its tables or the path of its file, found None"),
        (5, {"surface": np.zeros((3, 3, 3))}, "expected a Project"),
        ([], {}, "expected a Project"),
        ({1: 2}, {}, "expected tables by their names"),
        ("a\0.toml", {}, "expected a path"),
        ({"surface": FORMULA}, {"jobs": 0}, "jobs: expected a whole number from 1 to 10,000"),
        ({"surface": {"file": "a" * 300}}, {}, "no such file; surface.file is relative"),
        ({"surface": {"file": "a\0.step"}}, {}, "no such file"),
        ({"surface": FORMULA, "strips": {"start": "model", "model": "a\0"}}, {}, "expected a path"),
        ({"surface": FORMULA, "strips": {"count": 10**30}}, {}, "strips: expected a whole number"),
    ],
)
def test_a_design_names_what_it_is_not_given(project, arguments: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        design(project, **arguments)


def test_an_output_folder_is_a_path() -> None:
    with pytest.raises(InputError, match="out: expected a path, found None"):
        build_package({"surface": FORMULA}, None)  # type: ignore[arg-type]


def test_panels_without_number_are_refused_by_key() -> None:
    """They would fill the memory."""
    u, v = np.meshgrid(np.arange(7.0), np.arange(4.0))
    model = StripModel(np.stack([1000.0 * u, 1000.0 * v, 0.0 * u], axis=-1))
    for key, value in [("width", 0.001), ("length", 1e-6)]:
        project = parse_project({"surface": FORMULA, "panels": {key: value}})
        with pytest.raises(InputError, match=rf"panels\.{key}: .*ask for (wid|long)er panels"):
            patches_of(project, model.divided(lane_counts(project, model)))
    project = parse_project({"surface": FORMULA, "panels": {"count": 100_000}})
    assert len(patches_of(project, model)) == 300_000


def test_an_extra_that_is_missing_is_told_before_any_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fabgeo.review.ifc.importlib.util.find_spec", lambda _: None)
    out = tmp_path / "out"
    with pytest.raises(MissingExtraError, match=re.escape('pip install "fabgeo[ifc]"')):
        build_package({"surface": FORMULA, "ifc": True}, out)
    assert not out.exists()
