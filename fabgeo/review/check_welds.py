"""Ends of beams' plates as they are welded to the next segment: bevels, grooves, gaps.

Glossary
--------
run
    How far one skin of a plate ends before the other, along the plate.
groove
    Angle between the bevelled ends of two plates: twice that of each, whose tangent is run over
    thickness.
facing
    Ends of plates of one kind in two segments of an edge's beam, or of a ring's one segment.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from itertools import combinations
from typing import NamedTuple

import numpy as np

from fabgeo.arrays import Array, unit
from fabgeo.review.findings import Findings
from fabgeo.review.manifest import NAME
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number
from fabgeo.review.solid_plate import SolidPlate

RUN = 0.05  # mm: two decimals are written; 484 panels' beams were 2e-5 off square at most
GROOVE = 0.5  # degrees
GAP = 0.1  # mm: 3e-3 off at most
SHARE = 0.02  # relative: of a wide section on a tight curve one corner moves farther than another
FACING = 60.0  # mm: ends farther apart are not welded to each other
BEAM = re.compile(r"B-(\d+)-\d+-(WE.|FL.)")  # its edge, and what of a section it is
NODES = ("start", "end")

type Row = dict[str, str]


class End(NamedTuple):
    """One end of a plate: its beam's segment, its two corners (2, 3), run and groove in degrees."""

    beam: str
    corners: Array
    run: float
    groove: float


def check_welds(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Compare bevels with the plates' solids; grooves and gaps with those and the project."""
    ends: dict[str, list[End]] = defaultdict(list)
    alike: dict[tuple[str, str], list[End]] = defaultdict(list)
    for row in package.tables["plates"]:
        plate = measured.plates.get(row.get("mark", ""))
        if plate is None or plate.rails() is None:
            continue
        own = _in_order(package, row, [_end(row, plate, at) for at in (0, -1)])
        for name, end in zip(NODES, own, strict=True):
            _bevel(row, name, end.run, findings)
        ends[row.get("parent", "")] += own
        beam = BEAM.match(row.get("mark", ""))
        if beam:
            alike[beam[1], beam[2]] += own
    faced = _gaps(alike)
    plated = {r.get("parent", "") for r in package.tables["plates"] if r.get("role") == "end_plate"}
    for row in package.tables["beams"]:
        mark = row.get("mark", "")
        _groove(row, ends[mark], findings)
        if ends[mark] and mark not in plated:
            _gap(row, faced.get(mark), findings)
    _project(package, findings)


def _end(row: Row, plate: SolidPlate, at: int) -> End:
    """The end of a plate at its first or last ruling."""
    rails, normals = plate.four_sided, plate.normals
    first = next(k for k in (0, 1) if np.array_equal(plate.edges[k], rails[0]))
    through = plate.through[first + 1 if at else (first + 3) % 4]
    normal = unit(normals[0][at] + normals[1][at])
    run = float(np.linalg.norm(through - (through @ normal) * normal))
    groove = float(np.degrees(2.0 * np.arctan2(run, plate.thickness)))
    return End(row.get("parent", ""), np.stack([rail[at] for rail in rails]), run, groove)


def _in_order(package: WrittenPackage, row: Row, ends: list[End]) -> list[End]:
    """Both ends, that at the beam's first setting-out point first."""
    parent = row.get("parent", "")
    nodes = {point.get("point"): point for point in package.setout.get(parent, [])}
    first, last = (nodes.get(f"{parent}/{k}") for k in (1, 2))
    if first is None or last is None:
        return ends
    places = [np.array([number(node, k) for k in "xyz"], dtype=float) for node in (first, last)]
    way = ends[1].corners.mean(axis=0) - ends[0].corners.mean(axis=0)
    return ends[::-1] if float(way @ (places[1] - places[0])) < 0.0 else ends


def _bevel(row: Row, name: str, run: float, findings: Findings) -> None:
    stated = number(row, f"bevel_{name}_mm")
    if stated is not None or run > RUN:
        what = f"bevel_{name}_mm of its solid"
        findings.near(row.get("mark", ""), what, run, stated or 0.0, RUN)


def _gaps(ends: dict[tuple[str, str], list[End]]) -> dict[str, float]:
    """The narrowest gap (mm) at any corner of the welded ends of a segment, by its mark."""
    found: dict[str, float] = {}
    for own in ends.values():
        alone = len({end.beam for end in own}) == 1  # a ring of one segment is welded to itself
        for one, other in combinations(own, 2):
            if one.beam == other.beam and not alone:
                continue
            away = np.linalg.norm(one.corners[:, None] - other.corners, axis=2).min(axis=1)
            if away.max() < FACING:
                gap = float(away.min()) - 0.5 * (one.run + other.run)
                for beam in (one.beam, other.beam):
                    found[beam] = min(found.get(beam, gap), gap)
    return found


def _groove(row: Row, ends: list[End], findings: Findings) -> None:
    """The widest of its plates' ends; none where these are square."""
    if ends:
        found = max((end.groove for end in ends if end.run > RUN), default=0.0)
        stated = number(row, "groove_deg") or 0.0
        findings.near(row.get("mark", ""), "groove_deg of its solids", found, stated, GROOVE)


def _gap(row: Row, found: float | None, findings: Findings) -> None:
    """What is stated of a segment without end plates is left to the next one."""
    mark, stated = row.get("mark", ""), number(row, "weld_gap_mm")
    if stated and found is None:
        findings.add(mark, "weld_gap_mm, where it is welded to no other", "none", stated)
    elif stated and found is not None:
        findings.near(mark, "weld_gap_mm of its solids", found, stated, GAP + SHARE * stated)


def _project(package: WrittenPackage, findings: Findings) -> None:
    """Grooves and gaps of rows that were not named are the project's, as rounded."""
    known = {finding.part for finding in findings.items}
    rows = [row for row in package.tables["beams"] if row.get("mark") not in known]
    for column, key, within in (("groove_deg", "bevel", 0.06), ("weld_gap_mm", "weld_gap", 0.006)):
        asked = package.setting("beams", key, None)
        stated = [value for row in rows if (value := number(row, column)) is not None]
        if not isinstance(asked, int | float) or not stated:
            continue
        usual = Counter(stated).most_common(1)[0][0]
        if not abs(usual - asked) <= within:
            findings.add(NAME, f"beams.{key} of the beams", usual, asked)
