"""Setting-out points: corners of panels, nodes of beams, fixings, where their solids are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

import numpy as np

from fabgeo.arrays import Array, cross, unit
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number
from fabgeo.review.solid_plate import SolidPlate

FILE = "setout/points.csv"
PLACE = 0.05  # mm: setting-out points carry four decimals
NORMAL = 0.1  # degrees
ROUND = 0.9  # of a panel's area: corners that do not follow each other enclose less

type Row = dict[str, str]


def check_setout(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Every panel corner, beam node and connector once, where its solid or its row is."""
    own, tables = package.setout, package.tables
    for mark in _marks(tables["panels"]):
        plate = measured.plates.get(mark)
        if plate is not None:
            _at_corners(mark, own.get(mark, []), plate.corners, len(plate.corners), findings)
            _normals(mark, own.get(mark, []), plate, findings)
            _round(mark, own.get(mark, []), plate, findings)
    for mark in _marks(tables["beams"]):
        webs = [plate for key, plate in measured.plates.items() if key.startswith(f"{mark}-WEB")]
        if webs:  # one, or pieces from seam to seam
            corners = np.concatenate([web.corners for web in webs])
            _at_corners(mark, own.get(mark, []), corners, 2, findings)
            _nodes(mark, own.get(mark, []), webs, findings)
    frames = {path[-1]: frame for path, frame in measured.fixings.items()}
    for row in tables["connectors"]:
        mark, centre = row.get("mark", ""), _vector(row, "x_mm", "y_mm", "z_mm")
        if np.isfinite(centre).all():
            _at_corners(mark, own.get(mark, []), centre[None], 1, findings)
            for point in own.get(mark, []):
                _along(mark, point, _vector(row, "axis_x", "axis_y", "axis_z"), findings)
        if mark in frames:
            _fixing(mark, row, centre, frames[mark], findings)
    _names(package, findings)


def _names(package: WrittenPackage, findings: Findings) -> None:
    """A point's name is its own and begins with its part's mark; one family has one role."""
    own, tables = package.setout, package.tables
    known = {m for name in ("panels", "beams", "connectors") for m in _marks(tables[name])}
    counts = Counter(row.get("point", "") for rows in own.values() for row in rows)
    roles: dict[str, Counter[str]] = {}
    for mark, rows in own.items():
        if known and mark not in known:
            findings.add(mark, "part of a setting-out point", "in the schedules", "missing", FILE)
        roles.setdefault(mark[:2], Counter()).update(row.get("role", "") for row in rows)
    for mark, rows in own.items():
        role = roles[mark[:2]].most_common(1)[0][0]
        for row in rows:
            point = row.get("point", "")
            if counts[point] != 1:
                findings.add(mark, f"setting-out points named {point}", 1, counts[point], FILE)
            if point not in (mark, *(f"{mark}/{k}" for k in range(1, len(rows) + 1))):
                findings.add(mark, "name of a setting-out point", f"{mark}/1 and on", point, FILE)
            if row.get("role", "") != role:
                findings.add(
                    mark, f"role of setting-out point {point}", role, row.get("role"), FILE
                )


def _fixing(mark: str, row: Row, centre: Array, frame: Array, findings: Findings) -> None:
    """A connector's place and axis in the model against its row."""
    away = float(np.linalg.norm(frame[:3, 3] - centre))
    if away > PLACE:
        findings.add(mark, "place in the model", "as in connectors.csv", f"{away:.2f} mm off")
    off = _between(frame[:3, 2], _vector(row, "axis_x", "axis_y", "axis_z"))
    if off > NORMAL:
        findings.add(mark, "axis in the model", "as in connectors.csv", f"{off:.2f} deg off")


def _between(one: Array, other: Array) -> float:
    """Angle between two directions in degrees."""
    return float(np.degrees(np.arctan2(np.linalg.norm(cross(one, other)), float(one @ other))))


def _along(mark: str, row: Row, expected: Array, findings: Findings) -> None:
    """A point's direction is that of its part there."""
    off = _between(expected, _vector(row, "nx", "ny", "nz"))
    if not off <= NORMAL:
        what = f"normal of setting-out point {row.get('point')}"
        findings.add(mark, what, "that of its part", f"{off:.2f} deg off", FILE)


def _at_corners(mark: str, rows: list[Row], corners: Array, count: int, findings: Findings) -> None:
    """As many points as asked, each at another one of the corners."""
    if len(rows) != count:
        findings.add(mark, "setting-out points", count, len(rows), FILE)
    taken: set[int] = set()
    for row in rows:
        away = np.linalg.norm(corners - _vector(row, "x", "y", "z"), axis=1)
        nearest = int(np.nanargmin(away)) if np.isfinite(away).any() else -1
        what = f"setting-out point {row.get('point')}"
        if nearest < 0 or away[nearest] > PLACE:
            found = f"{away[nearest]:.2f} mm off" if nearest >= 0 else "no numbers"
            findings.add(mark, what, "at its part", found, FILE)
        elif nearest in taken:
            findings.add(mark, what, "at a corner of its own", "a second one", FILE)
        taken.add(nearest)


def _normals(mark: str, rows: list[Row], plate: SolidPlate, findings: Findings) -> None:
    """Normals are square to the panel, all on that side of it on which most are."""
    rails = plate.rails()
    if rails is None:
        return
    ends = np.concatenate([rail[[0, -1]] for rail in rails])
    normals = np.concatenate([normal[[0, -1]] for normal in plate.normals])
    places = [np.linalg.norm(ends - _vector(row, "x", "y", "z"), axis=1).argmin() for row in rows]
    own = normals[np.array(places, dtype=int)]
    stated = np.array([_vector(row, "nx", "ny", "nz") for row in rows]).reshape(-1, 3)
    side = 1.0 if float(np.nansum(np.sign(np.sum(own * stated, axis=1)))) >= 0.0 else -1.0
    for row, normal in zip(rows, side * own, strict=True):
        _along(mark, row, normal, findings)


def _round(mark: str, rows: list[Row], plate: SolidPlate, findings: Findings) -> None:
    """Numbered corners follow each other anticlockwise, seen against their normals."""
    rows = sorted(rows, key=lambda row: row.get("point", ""))
    if len(rows) != len(plate.corners) or len(rows) < 3:
        return
    points = np.array([_vector(row, "x", "y", "z") for row in rows])
    up = np.sum([_vector(row, "nx", "ny", "nz") for row in rows], axis=0)
    enclosed, whole = float(_area(points) @ unit(up)), float(np.linalg.norm(_area(plate.corners)))
    if enclosed < ROUND * whole:
        words = "corners do not follow each other" if enclosed > -ROUND * whole else "clockwise"
        findings.add(mark, "order of its setting-out points", "anticlockwise", words, FILE)


def _area(corners: Array) -> Array:
    """Half the sum of cross products (3,): area and direction of a polygon (n, 3)."""
    about = corners - corners.mean(axis=0)
    return 0.5 * cross(about, np.roll(about, -1, axis=0)).sum(axis=0)


def _nodes(mark: str, rows: list[Row], webs: list[SolidPlate], findings: Findings) -> None:
    """A node's direction leads there along the ruling of the web that ends at it."""
    rails = [web.rails() for web in webs]
    ends = [(one[k], other[k]) for pair in rails if pair is not None
            for one, other in (pair, pair[::-1]) for k in (0, -1)]  # fmt: skip
    if not ends:
        return
    tips = np.array([tip for _, tip in ends])
    for row in rows:
        away = np.linalg.norm(tips - _vector(row, "x", "y", "z"), axis=1)
        if float(away.min()) <= PLACE:
            foot, tip = ends[int(away.argmin())]
            _along(mark, row, tip - foot, findings)


def _marks(rows: Iterable[Row]) -> list[str]:
    return [row.get("mark", "") for row in rows]


def _vector(row: Row, *columns: str) -> Array:
    values = [number(row, column) for column in columns]
    return np.array([np.nan if value is None else value for value in values])
