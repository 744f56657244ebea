"""Beams by the solids of their plates: mass, centre of gravity, length and depth."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from fabgeo.arrays import Array, dot, unit
from fabgeo.review.check_rows import check_centre
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number
from fabgeo.review.solid_plate import SolidPlate, between_samples, polyline_length

ASKEW = 1.03  # of a flange's thickness: what a web reaches through it, up to 14 degrees off square
DEPTH = 0.02  # mm: two decimals are written; 503 beams were off by 3e-4 at most besides
LENGTH = 3e-5  # relative; rounding besides
ROUNDED = 0.006  # mm
FINE = 8  # points between two samples of a flange: 6 mm apart at 9 m

type Row = dict[str, str]


def check_beams(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """A beam's mass is its plates' mass; its centre theirs; its section that of its solids."""
    children: dict[str, list[Row]] = defaultdict(list)
    for row in package.tables["plates"]:
        children[row.get("parent", "")].append(row)
    for row in package.tables["beams"]:
        mark, mass = row.get("mark", ""), number(row, "mass_kg")
        own = children.get(mark, [])
        masses = [number(plate, "mass_kg") or 0.0 for plate in own]
        count = number(row, "plates")
        if count is not None:
            findings.near(mark, "plates in plates.csv", len(own), count, 0.0)
        if mass is not None and own:
            findings.near(mark, "mass_kg of its plates", sum(masses), mass, 1e-3 * sum(masses))
        _section(mark, row, own, measured, findings)
        marks = [plate.get("mark", "") for plate in own]
        if own and sum(masses) > 0.0 and all(m in measured.centres for m in marks):
            centres = np.array([measured.centres[m] for m in marks])
            check_centre(mark, row, np.array(masses) @ centres / sum(masses), findings)


def _section(mark: str, row: Row, own: list[Row], measured: Measured, findings: Findings) -> None:
    """Length and depth of a beam with one web."""
    webs = [plate for plate in own if plate.get("role") == "web"]
    web = measured.plates.get(webs[0].get("mark", "")) if len(webs) == 1 else None
    if web is None or web.rails() is None:
        return
    marks = [p.get("mark", "") for p in own if p.get("role", "").startswith("flange")]
    flanges = [measured.plates[m] for m in marks if m in measured.plates]
    flanges = [flange for flange in flanges if flange.rails() is not None]
    if len(flanges) < len(marks):
        return
    # A straight beam of a node mesh is as long as its edge of the mesh and as deep as its section.
    straight = all(web.straight)
    _depth(mark, row, web, flanges, straight, findings)
    length = number(row, "length_mm")
    if length is None:
        return
    rails = [polyline_length(rail) for rail in web.four_sided]
    low, high = _length(web, flanges)
    bevels = sum(number(webs[0], f"bevel_{end}_mm") or 0.0 for end in ("start", "end"))
    low, high = (0.95 * min(rails), 1.05 * max(rails)) if straight else (low, high + bevels)
    if not low <= length <= high:
        findings.add(mark, "length_mm of its web", f"{low:.2f} to {high:.2f}", length)


def _length(web: SolidPlate, flanges: list[SolidPlate]) -> tuple[float, float]:
    """Bounds of the length midway between the beam's outer faces, stated by chords.

    Chords are as fine as every second sample at least. Flanges of two thicknesses, or one alone,
    shift the middle of the beam off that of its web by half their difference.
    """
    a, b = web.four_sided
    middle = 0.5 * (a + b)
    length = polyline_length(middle)
    coarse = float(np.linalg.norm(np.diff(middle[::2], axis=0), axis=1).sum())
    thick = [flange.thickness for flange in flanges] + [0.0] * (2 - len(flanges))
    least = max(float(np.linalg.norm(b - a, axis=1).min()), 1e-9)
    shift = abs(polyline_length(a) - polyline_length(b)) * 0.5 * (max(thick) - min(thick)) / least
    slack = LENGTH * length + ROUNDED + shift
    return coarse - slack, length + slack


def _depth(
    mark: str,
    row: Row,
    web: SolidPlate,
    flanges: list[SolidPlate],
    straight: bool,
    findings: Findings,
) -> None:
    """The web's rulings, and what the flanges add to them."""
    first, second = web.four_sided
    rulings = second - first
    depth = np.linalg.norm(rulings, axis=1)
    bounds = [(float(d), float(d)) for d in (depth.min(), depth.max())]
    if straight:
        most = ASKEW * sum(flange.thickness for flange in flanges)
        bounds = [(low, high + most) for low, high in bounds]
    else:
        depth = depth + sum(_beyond(flange, first, second) for flange in flanges)
        bounds = [(float(d), float(d)) for d in (depth.min(), depth.max())]
    for key, (low, high) in zip(("depth_min_mm", "depth_max_mm"), bounds, strict=True):
        stated = number(row, key)
        if stated is not None and not low - DEPTH <= stated <= high + DEPTH:
            words = f"{low:.2f}" if low == high else f"{low:.2f} to {high:.2f}"
            findings.add(mark, f"{key} of its web and flanges", words, stated)


def _beyond(flange: SolidPlate, first: Array, second: Array) -> Array:
    """How far (n,) a flange's outer face is beyond a web's rulings between two rails (n, 3)."""
    from scipy.spatial import KDTree

    a, b = flange.four_sided
    lines = np.concatenate([0.5 * (a + b), unit(np.add(*flange.normals))], axis=1)
    middle, normals = np.split(between_samples(lines, FINE), 2, axis=1)
    tree = KDTree(middle)
    (one, at), (two, there) = tree.query(first), tree.query(second)
    if two.sum() < one.sum():
        first, second, at = second, first, there
    out, normal = unit(first - second), normals[at]
    # A developable plate's tangent plane is the same all along its ruling.
    height, lean = dot(middle[at] - first, normal), dot(out, normal)
    return height / lean + 0.5 * flange.thickness / np.abs(lean)
