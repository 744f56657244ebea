"""A flat part on paper: outline, dimensions, bend lines, holes, and their tables."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.panels.flat import BendLine, FlatPart
from fabgeo.review.page_flats import contour
from fabgeo.review.paper import BLUE, GREY, INK, MM, RED, Box, Paper, fit
from fabgeo.review.paper_tables import Table
from fabgeo.review.record import Row

BENDS_SHOWN = 12
LABEL = np.array([12.0, 6.0])  # points around a hole's number in which no other is put
LATELY = 12  # numbers that one is kept apart from: holes are numbered along their rows


def draw_flat(
    paper: Paper, box: Box, part: FlatPart, scale: float | None = None, small: bool = False
) -> float:
    """Draw a part into a box at a usual scale 1 : s and return s."""
    points = contour(part)
    low, high = points.min(axis=0), points.max(axis=0)
    room = 26.0 if small else 62.0
    inner = Box(box.x + room, box.y + room, box.width - 2 * room, box.height - 2 * room)
    scale = scale or fit(inner, *(high - low))
    middle = np.array([inner.x + inner.width / 2, inner.y + inner.height / 2])

    def move(p: Array) -> Array:
        return (np.asarray(p) - 0.5 * (low + high)) * MM / scale + middle

    paper.pen(INK, 1.1)
    paper.polygon(move(points), (0.96, 0.97, 0.98))
    _bends(paper, part, move, small)
    _holes(paper, part, move, scale)
    _origin(paper, move(np.zeros(2)))
    _mark(paper, part, move(0.5 * (low + high)), small)
    _dimensions(paper, part, move, low, high, small)
    return scale


def tables_of_part(part: FlatPart, holes_only: bool = False) -> Iterator[Table]:
    """Edges, bend lines and holes; without the first two, holes under the part's own mark."""
    if not holes_only:
        lines = tuple((e.name, f"{e.length:.2f}", e.shared or "–") for e in part.outline)
        yield Table("Edges", ("edge", "length", "shared with"), lines, (70, 60, 100))
        yield bends_table(part)
    lines = []
    for k, hole in enumerate(part.holes, start=1):
        slot = f"{hole.slot:g}" if hole.slot > 0.0 else "–"
        angle = f"{math.degrees(hole.angle):.2f}" if hole.slot > 0.0 else "–"
        x, y = hole.centre.tolist()
        lines.append((str(k), f"{x:.2f}", f"{y:.2f}", f"{hole.diameter:g}", slot, angle))
    whose = f"Holes of {part.mark}" if holes_only else "Holes"
    heads = ("no.", "x", "y", "Ø", "slot", "angle")
    title = f"{whose} ({len(lines)}; from the origin 0)"
    yield Table(title, heads, tuple(lines), (28, 54, 54, 34, 34, 44))


def bends_table(part: FlatPart) -> Table:
    """Some of the bend lines; all stand in the file beside the part's DXF."""
    rows = tuple(
        (str(k + 1), *(f"{v:.1f}" for v in (*b.start, *b.end)), f"{b.radius:+.0f}")
        for k, b in shown_bends(part)
    )
    count = sum(math.isfinite(bend.radius) for bend in part.bends)
    title = f"Bend lines ({len(rows)} of {count}; radius + towards the up-side)"
    return Table(title, ("no.", "x1", "y1", "x2", "y2", "radius"), rows, (26, 44, 44, 44, 44, 48))


def plates_table(plates: Sequence[Row]) -> Table:
    """Sizes of a beam's plates."""
    columns = (("length", "length_mm", 1), ("width", "width_mm", 1), ("camber", "camber_mm", 2),
               ("radius min", "radius_min_mm", 0), ("mass kg", "mass_kg", 2))  # fmt: skip
    lines = tuple(
        (str(plate["mark"]), *(figure(plate.get(key), decimals) for _, key, decimals in columns))
        for plate in plates
    )
    heads = ("plate", *(head for head, _, _ in columns))
    return Table("Plates", heads, lines, (76, 42, 42, 42, 48, 40))


def camber_table(part: FlatPart, stations: int = 9) -> Table:
    """Rise of a plate's first long edge over its chord at even stations; none if it is straight."""
    edge = next((e for e in part.outline if e.name == "first"), part.outline[0])
    chord = edge.points[-1] - edge.points[0]
    length = float(np.linalg.norm(chord))
    along = (edge.points - edge.points[0]) @ chord / length
    rise = (edge.points - edge.points[0]) @ np.array([-chord[1], chord[0]]) / length
    sites = np.linspace(0.0, length, stations)
    heights = np.round(np.interp(sites, along, rise), 1) + 0.0
    lines = (tuple(f"{h:.1f}" for h in heights),) if len(edge.points) > 2 else ()
    title = f"Camber of {part.mark}: rise of its first edge over the chord"
    return Table(title, tuple(f"{s:.0f}" for s in sites), lines, (27.5,) * stations)


def figure(value: Any, decimals: int) -> str:
    """A number with its decimals, or a dash."""
    if value is None or not np.isfinite(float(value)):
        return "–"
    return f"{float(value):.{decimals}f}"


def shown_bends(part: FlatPart) -> list[tuple[int, BendLine]]:
    """A few of the bend lines with their numbers, evenly picked."""
    bent = [(k, bend) for k, bend in enumerate(part.bends) if math.isfinite(bend.radius)]
    if len(bent) <= BENDS_SHOWN:
        return bent
    keep = np.unique(np.linspace(0, len(bent) - 1, BENDS_SHOWN).round().astype(int))
    return [bent[k] for k in keep]


def _bends(paper: Paper, part: FlatPart, move, small: bool) -> None:
    labelled = {k for k, _ in shown_bends(part)}
    for k, bend in enumerate(part.bends):
        if not math.isfinite(bend.radius):
            continue
        paper.pen((0.75, 0.5, 0.1), 0.35, (5, 2, 1, 2))
        p, q = move(bend.start), move(bend.end)
        paper.canvas.line(*p, *q)
        if k in labelled and not small:
            e = (q - p) / max(float(np.linalg.norm(q - p)), 1e-9)
            at = p + 0.16 * (q - p) + 3.2 * np.array([e[1], -e[0]])
            angle = float(np.degrees(np.arctan2(e[1], e[0])))
            paper.turned(float(at[0]), float(at[1]), f"R {abs(bend.radius):.0f}", angle, 5.2)
    paper.canvas.setDash()


def _holes(paper: Paper, part: FlatPart, move, scale: float) -> None:
    paper.pen(RED, 0.6)
    told: list[Array] = []
    for number, hole in enumerate(part.holes, start=1):
        x, y = move(hole.centre)
        radius = max(hole.diameter / 2.0 * MM / scale, 0.8)
        way = np.array([math.cos(hole.angle), math.sin(hole.angle)]) * hole.slot / 2 * MM / scale
        if hole.slot > 0.0:
            across = np.array([-way[1], way[0]]) / max(float(np.linalg.norm(way)), 1e-9) * radius
            for sign in (1.0, -1.0):
                a, b = (
                    np.array([x, y]) - way + sign * across,
                    np.array([x, y]) + way + sign * across,
                )
                paper.canvas.line(*a, *b)
            turn = math.degrees(hole.angle)
            for end, start in (
                (np.array([x, y]) + way, turn - 90),
                (np.array([x, y]) - way, turn + 90),
            ):
                box = (end[0] - radius, end[1] - radius, end[0] + radius, end[1] + radius)
                paper.canvas.arc(*box, startAng=start, extent=180)
        else:
            paper.canvas.circle(x, y, radius)
        at = np.array([x + radius + 2, y + radius + 1])
        if all(np.any(np.abs(at - other) > LABEL) for other in told[-LATELY:]):
            paper.text(at[0], at[1], number, 5.5, colour=RED)
            told.append(at)


def _origin(paper: Paper, at: Array) -> None:
    """Where x and y of the tables begin."""
    x, y = at.tolist()
    paper.pen(RED, 0.6)
    paper.canvas.circle(x, y, 2.2)
    paper.canvas.line(x - 4, y, x + 4, y)
    paper.canvas.line(x, y - 4, x, y + 4)
    paper.text(x - 4, y + 3, "0", 5.5, "end", colour=RED)


def _mark(paper: Paper, part: FlatPart, at: Array, small: bool) -> None:
    """The mark in the middle and the arrow that lies on the up-side along x."""
    size = 8.0 if small else 13.0
    wide = paper.canvas.stringWidth(part.mark, paper.bold, size)
    paper.canvas.setFillColorRGB(1, 1, 1)
    paper.canvas.rect(at[0] - wide / 2 - 3, at[1] - 3, wide + 6, size + 2, stroke=0, fill=1)
    paper.text(at[0], at[1], part.mark, size, "middle", bold=True, colour=BLUE)
    if small:
        return
    paper.pen(BLUE, 1.0)
    y = at[1] - 12
    paper.canvas.line(at[0] - 26, y, at[0] + 26, y)
    paper.canvas.line(at[0] + 26, y, at[0] + 20, y + 3)
    paper.canvas.line(at[0] + 26, y, at[0] + 20, y - 3)
    paper.text(at[0], y - 9, "up-side", 6.0, "middle", colour=BLUE)


def _dimensions(paper: Paper, part: FlatPart, move, low: Array, high: Array, small: bool) -> None:
    """Overall size outside, edge lengths along the edges, diagonals between opposite corners."""
    corners = [edge.points[0] for edge in part.outline]
    if not small:
        for edge in part.outline:
            p, q = move(edge.points[0]), move(edge.points[-1])
            words = f"{edge.length:.2f}" + ("" if len(edge.points) == 2 else " arc")
            sag = move(edge.points)
            chord = (q - p) / max(float(np.linalg.norm(q - p)), 1e-9)
            out = (sag - p) @ np.array([chord[1], -chord[0]])
            paper.dimension(p, q, 14.0 + max(float(out.max()), 0.0), words)
    if len(corners) == 4 and not small:
        for a, b in ((0, 2), (1, 3)):
            p, q = move(corners[a]), move(corners[b])
            paper.pen(GREY, 0.25, (2, 3))
            paper.canvas.line(*p, *q)
            paper.canvas.setDash()
            length = float(np.linalg.norm(corners[b] - corners[a]))
            at = p + 0.27 * (q - p)
            angle = float(np.degrees(np.arctan2(*(q - p)[::-1])))
            paper.turned(at[0], at[1] + 4, f"diag. {length:.2f}", angle, 6.0)
    away = 12.0 if small else 42.0
    left, right = move(low), move(high)
    bottom = np.array([right[0], left[1]])
    size = high - low
    paper.dimension(left, bottom, away, f"{size[0]:.2f}", small)
    paper.dimension(bottom, right, away, f"{size[1]:.2f}", small)
