"""A flat part on paper: outline, dimensions, bend lines, holes, and their tables."""

from __future__ import annotations

import math

import numpy as np

from fabgeo.arrays import Array
from fabgeo.panels.flat import BendLine, FlatPart
from fabgeo.review.page_flats import contour
from fabgeo.review.paper import BLUE, GREY, INK, MM, RED, Box, Paper, fit

BENDS_SHOWN = 12
HOLES_SHOWN = 18


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
    _mark(paper, part, move(0.5 * (low + high)), small)
    _dimensions(paper, part, move, low, high, small)
    return scale


def tables_of_part(paper: Paper, x: float, y: float, part: FlatPart) -> None:
    """Edges, bends and holes as tables under each other."""
    lines = [(edge.name, f"{edge.length:.2f}", edge.shared or "–") for edge in part.outline]
    paper.heading(x, y, "Edges")
    y = paper.table(x, y - 4, ("edge", "length", "shared with"), lines, (70, 60, 100)) - 12
    bends = shown_bends(part)
    if bends:
        paper.heading(
            x, y, f"Bend lines ({len(part.bends)}; radius at mid-surface, + towards the up-side)"
        )
        rows = [
            (str(k + 1), *(f"{v:.1f}" for v in (*b.start, *b.end)), f"{b.radius:+.0f}")
            for k, b in bends
        ]
        heads = ("no.", "x1", "y1", "x2", "y2", "radius")
        y = paper.table(x, y - 4, heads, rows, (30, 48, 48, 48, 48, 56)) - 12
    if part.holes and y > 130:
        paper.heading(x, y, f"Holes ({len(part.holes)}; from the drawing's origin)")
        keep = max(1, min(HOLES_SHOWN, int((y - 118) / 10.5)))
        rows = []
        for k, hole in enumerate(part.holes[:keep]):
            slot = f"slot {hole.slot:g}" if hole.slot > 0.0 else "round"
            angle = f"{math.degrees(hole.angle):.2f}" if hole.slot > 0.0 else ""
            place = (f"{hole.centre[0]:.2f}", f"{hole.centre[1]:.2f}", f"{hole.diameter:g}")
            rows.append((str(k + 1), *place, slot, angle))
        paper.table(
            x, y - 4, ("no.", "x", "y", "Ø", "kind", "angle"), rows, (30, 54, 54, 40, 56, 44)
        )


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
        paper.text(x + radius + 2, y + radius + 1, number, 5.5, colour=RED)


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
        for k, edge in enumerate(part.outline):
            p, q = move(edge.points[0]), move(edge.points[-1])
            words = f"{edge.length:.2f}" + ("" if len(edge.points) == 2 else " arc")
            sag = move(edge.points)
            chord = (q - p) / max(float(np.linalg.norm(q - p)), 1e-9)
            out = (sag - p) @ np.array([chord[1], -chord[0]])
            paper.dimension(p, q, 14.0 + max(float(out.max()), 0.0), words)
            del k
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
