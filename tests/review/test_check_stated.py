"""What a package states of itself: review.json, strips.json, the manifest, families' STEP files."""

from __future__ import annotations

import copy
import json
import re
import shutil
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest
from test_check_real import PROJECT

from fabgeo.build import build_package
from fabgeo.build.figures import limits_of
from fabgeo.project import parse_project
from fabgeo.project.tables import Limits
from fabgeo.review.check import STEPS
from fabgeo.review.check_flats import check_flats
from fabgeo.review.check_limits import DEFAULTS
from fabgeo.review.check_limits import limits_of as expected_limits
from fabgeo.review.check_sheets import check_sheets
from fabgeo.review.check_solids import check_solids
from fabgeo.review.findings import Findings
from fabgeo.review.manifest import package_files, sha256_of
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage

P, C, W = "P-01-01", "C-01-01", "W-01-01"
REVIEW, STRIPS, MANIFEST = "checks/review.json", "strips.json", "manifest.json"
OWN = ("files", "families", "manifest", "model", "parts", "summary", "strips")

type Fault = Callable[[Path], None]


def edited(name: str, change: Callable[[Any], object]) -> Fault:
    """A JSON file changed in place."""

    def fault(folder: Path) -> None:
        found = json.loads((folder / name).read_text())
        change(found)
        (folder / name).write_text(json.dumps(found))

    return fault


def put(name: str, value: Any, *keys: str | int) -> Fault:
    """One entry of a JSON file, reached by keys."""

    def change(found: Any) -> None:
        for key in keys[:-1]:
            found = found[key]
        found[keys[-1]] = value

    return edited(name, change)


def taken(name: str, *keys: str) -> Fault:
    """The same taken out."""

    def change(found: Any) -> None:
        for key in keys[:-1]:
            found = found[key]
        del found[keys[-1]]

    return edited(name, change)


def control(change: Callable[[float, int], float]) -> Fault:
    """Control points changed, coordinate by coordinate."""

    def all_of(found: Any) -> None:
        found["control"] = [
            [[change(x, k) for k, x in enumerate(point)] for point in edge]
            for edge in found["control"]
        ]

    return edited(STRIPS, all_of)


def text(name: str, change: Callable[[str], str]) -> Fault:
    """The STEP file of a family changed."""

    def fault(folder: Path) -> None:
        path = folder / "model" / f"{name}.step"
        before = path.read_text()
        after = change(before)
        assert after != before
        path.write_text(after, newline="")

    return fault


def moved(found: str) -> str:
    """The first point of a panel's solid."""
    at = found.index(f"PRODUCT('{P}'")
    shifted = re.sub(
        r"(CARTESIAN_POINT\('',\()([^,]*\d{2}[^,]*)",
        lambda m: m[1] + repr(float(m[2]) + 0.5),
        found[at:],
        count=1,
    )
    return found[:at] + shifted


def exchanged(found: str) -> str:
    return found.replace(f"'{W}'", "'~'").replace("'W-00-01'", f"'{W}'").replace("'~'", "'W-00-01'")


def gone(name: str) -> Fault:
    return lambda folder: (folder / name).unlink()


def lenient(folder: Path) -> None:
    """A gap beyond its limit, and a limit beyond the gap."""
    put(REVIEW, 3.0, "parts", P, "gap_max_mm")(folder)
    put(REVIEW, 5.0, "limits", "gap_max_mm", "good")(folder)


def warned(folder: Path) -> None:
    put(REVIEW, "warn", "parts", P, "verdict")(folder)
    path = folder / "schedules" / "panels.csv"
    path.write_text(re.sub(rf"(?m)^({P},.*),good,", r"\1,warn,", path.read_text()))


FAULTS: dict[str, tuple[Fault, Iterable[str]]] = {
    "limit widened": (put(REVIEW, 5.0, "limits", "gap_max_mm", "good"), {REVIEW}),
    "limit narrowed": (put(REVIEW, 0.01, "limits", "twist_max_deg", "good"), {REVIEW}),
    "limit taken out": (taken(REVIEW, "limits", "gap_max_mm"), {REVIEW}),
    "limit turned": (put(REVIEW, "min", "limits", "gap_max_mm", "sense"), {REVIEW}),
    "limit of the project": (put(MANIFEST, 5.0, "project", "limits", "gap_max_mm"), {MANIFEST}),
    "gap and its limit": (lenient, {REVIEW, P}),
    "gap null": (put(REVIEW, None, "summary", "gap_max_mm"), {REVIEW}),
    "kink null": (put(REVIEW, None, "summary", "kink_max_deg"), {REVIEW}),
    "deviation null": (put(REVIEW, None, "summary", "deviation_max_mm"), {REVIEW}),
    "offset null": (put(REVIEW, None, "summary", "offset_distance_error_mm"), {REVIEW}),
    "volume halved": (put(REVIEW, 0.0, "summary", "volume_error_rel"), {REVIEW}),
    "part lost": (taken(REVIEW, "parts", P), {P}),
    "part too many": (put(REVIEW, {"verdict": "good"}, "parts", "P-99-99"), {"P-99-99"}),
    "word for a number": (put(REVIEW, "small", "parts", P, "twist_max_deg"), {P}),
    "verdict worse": (warned, {P}),
    "reason": (put(REVIEW, "because", "parts", P, "reason"), {P}),
    "worst": (put(REVIEW, "P-00-00", "worst", "volume_error_rel", "mark"), {REVIEW}),
    "strips moved along x": (control(lambda x, k: x + (k == 0)), {STRIPS}),
    "strips moved along y": (control(lambda x, k: x + (k == 1)), {STRIPS}),
    "strips raised": (control(lambda x, k: x + 0.3 * (k == 2)), {STRIPS}),
    "strips far away": (control(lambda x, k: x + 100.0 * (k == 0)), {STRIPS}),
    "strips enlarged": (control(lambda x, _: 1.01 * x), {STRIPS}),
    "strip lost": (edited(STRIPS, lambda found: found["control"].pop()), {STRIPS}),
    "control point": (
        edited(STRIPS, lambda found: found["control"][1][4].__setitem__(2, 0.0)),
        {STRIPS},
    ),
    "kind": (put(STRIPS, "general", "kind"), {STRIPS}),
    "strips deleted": (gone(STRIPS), {STRIPS}),
    "page deleted": (gone("index.html"), {"index.html"}),
    "joint": (put(MANIFEST, 16.0, "project", "panels", "joint"), {MANIFEST}),
    "thickness": (put(MANIFEST, 5.0, "project", "panels", "thickness"), {MANIFEST}),
    "material": (put(MANIFEST, "steel", "project", "panels", "material"), {MANIFEST}),
    "tolerance": (put(MANIFEST, 5.0, "project", "cutting", "tolerance"), {MANIFEST}),
    "depth": (put(MANIFEST, -245.0, "project", "cells", "depth"), {MANIFEST}),
    "transport": (
        put(MANIFEST, [900.0, 500.0, 500.0], "project", "limits", "transport_mm"),
        {MANIFEST},
    ),
    "units": (put(MANIFEST, "inch", "units"), {MANIFEST}),
    "name": (put(MANIFEST, "Other", "name"), {MANIFEST}),
    "project without limits": (taken(MANIFEST, "project", "limits"), {MANIFEST}),
    "panel moved": (text("panels", moved), {"model/panels.step"}),
    "cut off": (text("beams", lambda found: found[:-2000]), {"model/beams.step"}),
    "cell left out": (
        text("cells", lambda found: re.sub(rf"#\d+ = NEXT_\w+\('\d+','{C}'[^;]*;\n", "", found)),
        {"model/cells.step"},
    ),
    "names exchanged": (text("walls", exchanged), {"model/walls.step"}),
    "family deleted": (gone("model/connectors.step"), {"model/connectors.step"}),
}


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Measured]:
    """A built package, and what its unaltered solids and cut parts measure."""
    folder = tmp_path_factory.mktemp("stated") / "out"
    build_package(parse_project(PROJECT), folder)
    measured, findings = Measured(), Findings()
    for step in (check_solids, check_flats, check_sheets):
        step(WrittenPackage.open(folder), measured, findings)
    assert not findings.items
    return folder, measured


def named(folder: Path, measured: Measured) -> set[str]:
    """What the steps of statements name, hashes renewed."""
    path = folder / MANIFEST
    manifest = json.loads(path.read_text())
    manifest["files"] = {k: sha256_of(p) for k, p in package_files(folder).items()}
    path.write_text(json.dumps(manifest))
    findings, own = Findings(), copy.deepcopy(measured)
    for step in STEPS:
        if step.__name__.removeprefix("check_") in OWN:
            step(WrittenPackage.open(folder), own, findings)
    return {found.part for found in findings.items}


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS)
def test_a_false_statement_is_named_by_its_part_alone(
    package: tuple[Path, Measured], tmp_path: Path, fault: str
) -> None:
    folder = tmp_path / "out"
    shutil.copytree(package[0], folder)
    assert not named(folder, package[1])
    alter, expected = FAULTS[fault]
    alter(folder)
    found = named(folder, package[1])
    assert set(expected) <= found
    assert {part for part in found if "/" not in part and "." not in part} <= set(expected)


@pytest.mark.slow
def test_a_model_that_another_program_has_written_is_none_of_its_families_faults(
    package: tuple[Path, Measured], tmp_path: Path
) -> None:
    """Other numbers of statements, another layout; a part that its family lacks is still told."""
    folder = tmp_path / "out"
    shutil.copytree(package[0], folder)
    path = folder / "model" / "facade.step"
    found = path.read_text().replace("'fabgeo'", "'Another CAD'", 1).replace(" = ", "=")
    path.write_text(re.sub(r"#(\d+)", lambda m: f"#{int(m[1]) + 7}", found), newline="")
    assert not named(folder, package[1])
    text("cells", lambda own: own.replace(f"'{C}'", "'C-77-77'"))(folder)
    assert named(folder, package[1]) == {"model/cells.step"}


def test_the_check_knows_the_limits_of_projects_and_their_defaults() -> None:
    usual = Limits().model_dump(exclude={"transport_mm"})
    assert usual == DEFAULTS
    asked = {limit.key: limit for limit in limits_of(parse_project(PROJECT))}
    manifest = {"project": {"limits": {k: v for k, v in usual.items() if v is not None}}}
    known = {own.key: own for own in expected_limits(WrittenPackage(Path(), manifest))}
    assert known.keys() == asked.keys()
    for key, own in known.items():
        limit = asked[key]
        assert (own.good, own.warn, own.sense) == (limit.good, limit.warn, limit.sense)


def test_limits_of_the_contract_are_those_of_a_project_that_names_none() -> None:
    """The check has its own: it trusts neither the writer nor what reads projects."""
    own = Limits().model_dump()
    assert {key: own[key] for key in DEFAULTS} == DEFAULTS
    assert own.keys() - DEFAULTS.keys() == {"transport_mm"}
