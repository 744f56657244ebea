"""What a mark says of its part, against the columns that say it once more.

`P-03-07` is the panel of strip 3, cell 7; `C-03-07` its cell; `B-03-1` a beam of edge 3 and
`B-03-1-WEB` a plate of it; `K-03-07-2` a fixing of that panel.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable

import numpy as np

from fabgeo.arrays import Array
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number

PANEL = re.compile(r"[PC]-(\d+)-(\d+)")
BEAM = re.compile(r"B-(\d+)-\d+")
FLANGE = re.compile(r"(B-\d+-\d+)-FLO")
ROLES = {"WE": "web", "FLI": "flange_inner", "FLO": "flange_outer", "EP": "end_plate"}
NEARER = 1.0  # mm: how much nearer than its own another beam's flange may come to a fixing

type Row = dict[str, str]


def check_marks(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Compare strip, cell, edge, parent and role with the mark; fixings with what they join."""
    tables = package.tables
    for row in (*tables["panels"], *tables["cells"]):
        own = PANEL.match(row.get("mark", ""))
        for key, words in zip(("strip", "cell"), own.groups() if own else (), strict=False):
            _number(row, key, float(words), findings)
    for row in tables["beams"]:
        own = BEAM.match(row.get("mark", ""))
        if own:
            _number(row, "edge", float(own[1]), findings)
    for row in tables["plates"]:
        _plate(row, findings)
    for row in tables["panels"]:
        _slits(row, findings)
    for row in tables["connectors"]:
        mark = row.get("mark", "")
        panel = f"P-{mark.rpartition('-')[0].removeprefix('K-')}"
        if row.get("panel") and mark.startswith("K-"):
            _same(mark, "panel", panel, row["panel"], findings)
    _counts(package, findings)
    _weights(tables["connectors"], findings)
    _beams(package, measured, findings)


def _number(row: Row, key: str, expected: float, findings: Findings) -> None:
    stated = number(row, key)
    if stated is not None:
        findings.near(row.get("mark", ""), f"{key} of its mark", expected, stated, 0.0)


def _same(mark: str, key: str, expected: str, stated: str, findings: Findings) -> None:
    if stated != expected:
        findings.add(mark, f"{key} of its mark", expected, stated)


def _plate(row: Row, findings: Findings) -> None:
    """A wall is its own parent; a beam's plate ends in what it is."""
    mark, parent, role = (row.get(key, "") for key in ("mark", "parent", "role"))
    own = BEAM.match(mark)
    if own and mark.startswith(f"{own[0]}-"):
        _same(mark, "parent", own[0], parent, findings)
        tail = mark.removeprefix(f"{own[0]}-")
        for start, expected in ROLES.items():
            if tail.startswith(start):
                _same(mark, "role", expected, role, findings)
    elif mark.startswith("W-"):
        _same(mark, "parent", mark, parent, findings)
        _same(mark, "role", "wall", role, findings)


def _slits(row: Row, findings: Findings) -> None:
    """A slit has a width and panels of the same strip across it."""
    mark, across = row.get("mark", ""), (row.get("slit_edges") or "").split()
    width = number(row, "slit_max_mm")
    if (width is None) != (not across):
        words = "stated" if across else "none without slit_edges"
        findings.add(mark, "slit_max_mm", words, row.get("slit_max_mm") or "none")
    own = PANEL.match(mark)
    for other in across:
        if own and not other.startswith(f"P-{own[1]}-"):
            findings.add(mark, "slit_edges", f"panels of strip {own[1]}", other)


def _counts(package: WrittenPackage, findings: Findings) -> None:
    """A panel states how many rows of connectors.csv are its own."""
    rows = package.tables["connectors"]
    marks = {row.get("mark", "") for row in rows}
    counts = Counter(f"P-{mark[2:].rpartition('-')[0]}" for mark in marks)
    for row in package.tables["panels"]:
        mark, stated = row.get("mark", ""), number(row, "connectors")
        if stated is not None:
            findings.near(mark, "connectors in connectors.csv", counts[mark], stated, 0.0)


def _weights(rows: Iterable[Row], findings: Findings) -> None:
    """Equal fixings weigh the same."""
    masses: dict[str, Counter[str]] = defaultdict(Counter)
    for row in rows:
        masses[row.get("product", "")][row.get("mass_kg", "")] += 1
    for row in rows:
        product, stated = row.get("product", ""), row.get("mass_kg", "")
        most, count = masses[product].most_common(1)[0]
        if masses[product][stated] < count or (count == 1 and len(masses[product]) > 1):
            findings.add(row.get("mark", ""), f"mass_kg of product {product}", most, stated)


def _beams(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """A fixing stands on the beam whose outer flange's middle is nearest."""
    from scipy.spatial import KDTree

    lines: dict[str, list[Array]] = defaultdict(list)
    for mark, plate in measured.plates.items():
        own, rails = FLANGE.match(mark), plate.rails()
        if own and rails is not None:
            lines[own[1]].append(0.5 * (rails[0] + rails[1]))
    owners = [beam for beam, own in lines.items() for line in own for _ in line]
    rows = [row for row in package.tables["connectors"] if row.get("beam")]
    places = np.array([[number(row, f"{k}_mm") for k in "xyz"] for row in rows], dtype=float)
    known = np.isfinite(places).all(axis=1) if rows else np.zeros(0, dtype=bool)
    if not owners or not known.any():
        return
    tree = KDTree(np.concatenate([line for own in lines.values() for line in own]))
    nearest = np.asarray(tree.query(places[known])[1])
    for k, at in zip(np.flatnonzero(known), nearest, strict=True):
        stated, found = rows[k]["beam"], owners[at]
        if stated != found and _away(places[k], lines.get(stated, ())) > (
            _away(places[k], lines[found]) + NEARER
        ):
            findings.add(rows[k].get("mark", ""), "beam that it stands on", found, stated)


def _away(place: Array, lines: Iterable[Array]) -> float:
    """Distance of a place (3,) from the nearest of some lines (n, 3)."""
    found = [np.inf]
    for line in lines:
        step, back = np.diff(line, axis=0), place - line[:-1]
        t = np.clip(np.sum(back * step, axis=1) / np.sum(step * step, axis=1), 0.0, 1.0)
        found.append(float(np.linalg.norm(back - t[:, None] * step, axis=1).min()))
    return min(found)
