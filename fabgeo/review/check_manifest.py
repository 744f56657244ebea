"""Settings of the project in manifest.json against what the files were made with."""

from __future__ import annotations

import re
from collections import Counter

import numpy as np

from fabgeo.review.findings import Findings
from fabgeo.review.manifest import NAME
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number

LARGEST_TOLERANCE = 0.5  # mm: outlines that are this much off are no cut parts
THICKNESS = 0.02  # mm
BOX = 0.1  # mm, boxes are written with one decimal
FEW = 0.5  # share of the rows that have to contradict a setting for it to be wrong
PAGE = "index.html"
SURFACE_FILES = ("strips.json", PAGE)
MARK = re.compile(r"\b[PCBWK]-\d{2,}-\d+(?:-[A-Za-z0-9]+)?\b")


def check_manifest(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Compare settings that schedules and solids show; parts alone are named by other steps."""
    manifest, project = package.manifest, package.project
    if manifest.get("units") != "mm":
        findings.add(NAME, "units", "mm", manifest.get("units"))
    if "name" in project and manifest.get("name") != project["name"]:
        findings.add(NAME, "name", project["name"], manifest.get("name"))
    tolerance = package.setting("cutting", "tolerance", 0.0)
    if not tolerance <= LARGEST_TOLERANCE:
        findings.add(NAME, "cutting.tolerance", f"at most {LARGEST_TOLERANCE:g}", tolerance)
    listed = manifest.get("files")
    written = isinstance(listed, dict) and "strips.json" in listed
    for table in ("strips", "limits"):
        if written and not project.get(table):
            findings.add(NAME, f"project's {table}", "present", "missing")
    if project.get("strips"):
        _files(package, findings)
        _page(package, findings)
    _panels(package, measured, findings)
    _transport(package, findings)


def _files(package: WrittenPackage, findings: Findings) -> None:
    """What every project gets, left out of the manifest's files as well."""
    due = [*SURFACE_FILES, *(["model/facade.glb"] if package.step.is_file() else [])]
    listed = package.manifest.get("files") or {}
    for name in due:
        if name not in listed and not (package.folder / name).is_file():
            findings.add(name, "file of every project", "present", "missing")


def _page(package: WrittenPackage, findings: Findings) -> None:
    """The page tells of every part: all marks of the schedules stand in it."""
    path = package.folder / PAGE
    if not path.is_file():
        return
    told = set(MARK.findall(path.read_text(encoding="utf-8", errors="replace")))
    names = ("panels", "plates", "beams", "cells", "connectors")
    marks = {row.get("mark", "") for name in names for row in package.tables[name]}
    lost = sorted(mark for mark in marks - told if MARK.fullmatch(mark))
    if lost:
        findings.add(PAGE, "marks of the schedules", "all", f"without {', '.join(lost[:3])}")


def _panels(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Thickness and material of most panels are those of the project."""
    rows = {row.get("mark", ""): row for row in package.tables["panels"]}
    known = [measured.plates[mark].thickness for mark in rows if mark in measured.plates]
    thickness = package.setting("panels", "thickness", float("nan"))
    if known and thickness == thickness:
        usual = float(np.median(known))
        if not abs(usual - thickness) <= THICKNESS:
            findings.add(NAME, "panels.thickness of the panels", usual, thickness)
    material = package.setting("panels", "material", None)
    own = package.setting("panels", "materials", {})
    found = Counter(row.get("material") for mark, row in rows.items() if mark not in own)
    if material is not None and found and not found[material]:
        findings.add(NAME, "panels.material of the panels", found.most_common(1)[0][0], material)


def _transport(package: WrittenPackage, findings: Findings) -> None:
    """Most verdicts on transport are those by the project's box."""
    room = package.setting("limits", "transport_mm", None)
    if not isinstance(room, list) or len(room) != 3:
        return
    says = []
    for name in ("panels", "beams", "cells"):
        for row in package.tables[name]:
            box = [number(row, f"box_{side}_mm") for side in ("length", "width", "height")]
            known = [size for size in box if size is not None]
            if len(known) == 3 and row.get("transport"):
                fits = bool(np.all(np.sort(known) <= np.sort(room) + BOX))
                says.append(fits == (row["transport"] == "fits"))
    if says and says.count(False) > FEW * len(says):
        words = f"a box by which {says.count(True)} of {len(says)} verdicts are right"
        findings.add(NAME, "limits.transport_mm", "the verdicts' box", words)
