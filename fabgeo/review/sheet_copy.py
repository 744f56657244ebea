"""A part on its sheet is the part of its own file: moved and turned, not mirrored."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from fabgeo.arrays import Array
from fabgeo.review.findings import Findings
from fabgeo.review.measured import FlatFile
from fabgeo.review.package import number
from fabgeo.review.solid_plate import shape_area

HOLE = 0.05  # mm: a hole or bend line on a sheet against the part's own file
TURN = 0.02  # deg: a part of 2 m turned by it is 0.7 mm off
COPY = 0.06  # mm: an outline on a sheet against the part's own file


def check_copy(
    mark: str, points: Array, flat: FlatFile, findings: Findings, name: str
) -> list[Motion]:
    """The outline on the sheet is the part's own, moved and turned but not mirrored.

    Returns all motions that it may have gone: a rectangle may have been turned by 180 degrees.
    """
    if len(points) == len(flat.outline):
        motions = moves(flat.outline, points)
        away = min(motion.away for motion in motions)
        if away > COPY:
            words = f"the part's own within {COPY} mm"
            findings.add(mark, "outline on its sheet", words, f"{away:.3f} mm off", name)
        return [motion for motion in motions if motion.away <= COPY]
    own = flat.outline
    area, there = shape_area(own), shape_area(points)
    findings.near(mark, "area on its sheet in mm2", area, there, 1e-5 * area, name)
    length, there = shapely.LinearRing(own).length, shapely.LinearRing(points).length
    findings.near(mark, "length of its outline on the sheet", length, there, 1e-5 * length, name)
    return []


@dataclass(frozen=True)
class Motion:
    """A turn and a move in the plane, as complex numbers, and what it leaves between outlines."""

    turn: complex
    move: complex
    away: float

    def __call__(self, points: Array) -> Array:
        """Points (k, 2) moved."""
        z = (points[:, 0] + 1j * points[:, 1]) * self.turn + self.move
        return np.stack([z.real, z.imag], axis=1)


def moves(source: Array, target: Array) -> list[Motion]:
    """The best turns and moves, over all starting points of the outline."""
    z, w = source[:, 0] + 1j * source[:, 1], target[:, 0] + 1j * target[:, 1]
    middle, there = z.mean(), w.mean()
    z, w = z - middle, w - there
    # One transform gives all cyclic shifts: |sum conj(z) w| is largest for the best of them.
    scores = np.abs(np.fft.ifft(np.conj(np.fft.fft(z)) * np.fft.fft(w)))
    found = []
    for shift in np.argsort(-scores)[:4]:  # of a square all are alike
        moved = np.roll(w, -int(shift))
        turn = np.vdot(z, moved)
        turn = complex(turn / abs(turn)) if abs(turn) > 0.0 else 1.0 + 0.0j
        away = float(np.abs(z * turn - moved).max())
        found.append(Motion(turn, complex(there - middle * turn), away))
    return found


def check_holes(
    rows: Array,
    mark: str,
    polygon: shapely.Polygon,
    flat: FlatFile,
    motions: list[Motion],
    findings: Findings,
    name: str,
) -> None:
    """As many holes as in the part's own file, as large, and moved with its outline."""
    inside = rows[shapely.contains_xy(polygon, rows[:, 0], rows[:, 1])]
    if len(inside) != len(flat.holes):
        findings.add(mark, "holes on its sheet", len(flat.holes), len(inside), name)
        return
    if not len(inside):
        return
    own, there = np.sort(flat.holes[:, 2:], axis=0), np.sort(inside[:, 2:], axis=0)
    if np.abs(own - there).max() > HOLE:
        findings.add(mark, "hole sizes on its sheet", own.max(), there.max(), name)
    off = []
    for motion in motions:
        moved = motion(flat.holes[:, :2])
        away = np.linalg.norm(moved[:, None] - inside[None, :, :2], axis=-1)
        off.append(max(float(away.min(axis=1).max()), float(away.min(axis=0).max())))
    if off and min(off) > HOLE:
        words = "where the part's own are"
        findings.add(mark, "holes on its sheet", words, f"{min(off):.3f} mm off", name)


def check_bends(
    lines: Array,
    mark: str,
    polygon: shapely.Polygon,
    flat: FlatFile,
    motions: list[Motion],
    findings: Findings,
    name: str,
) -> None:
    """As many bend lines (b, 2, 2) as in the part's own file, moved with its outline."""
    middles = lines.mean(axis=1)
    inside = lines[shapely.contains_xy(polygon, middles[:, 0], middles[:, 1])]
    if len(inside) != len(flat.bends):
        findings.add(mark, "bend lines on its sheet", len(flat.bends), len(inside), name)
        return
    off = []
    for motion in motions if len(inside) else ():
        moved = motion(flat.bends.reshape(-1, 2)).reshape(-1, 2, 2)
        ways = [inside[None], inside[None, :, ::-1]]  # a line has no sense
        away = np.min([np.linalg.norm(moved[:, None] - w, axis=-1).max(-1) for w in ways], axis=0)
        off.append(max(float(away.min(axis=1).max()), float(away.min(axis=0).max())))
    if off and min(off) > HOLE:
        words = "where the part's own are"
        findings.add(mark, "bend lines on its sheet", words, f"{min(off):.3f} mm off", name)


def check_turn(
    row: dict[str, str],
    mark: str,
    label: Array,
    flat: FlatFile,
    motions: list[Motion],
    findings: Findings,
    name: str,
) -> None:
    """Its engraved mark goes with it, and its row tells by how much it was turned."""
    if np.isfinite([label, flat.label]).all() and motions:
        off = [float(np.linalg.norm(motion(flat.label[None])[0] - label)) for motion in motions]
        motions = [motion for motion, away in zip(motions, off, strict=True) if away <= HOLE]
        if not motions:
            words = "where the part's own is"
            findings.add(mark, "engraved mark on its sheet", words, f"{min(off):.2f} mm off", name)
    stated = number(row, "sheet_rotation_deg")
    turns = [float(np.degrees(np.angle(motion.turn))) for motion in motions]
    if stated is None or not turns:
        return
    off = [abs((turn - stated + 180.0) % 360.0 - 180.0) for turn in turns]
    if min(off) > TURN:
        nearest = turns[int(np.argmin(off))] % 360.0
        findings.add(mark, "sheet_rotation_deg in its schedule row", nearest, stated, name)
