"""Small views in space for the drawings: one part, and its place in the building."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, cross, unit
from fabgeo.review.paper import GREY, INK, Box, Paper
from fabgeo.review.picture import Polygon, picture_of, view_of
from fabgeo.review.record import Shown

HIGHLIGHT = (0.82, 0.0, 0.44)
STEPS = 3  # points of a rail where a part is small


def space_view(paper: Paper, box: Box, parts: Sequence[Shown]) -> None:
    """Parts seen from the outer side of the first; rulings on a part that is alone."""
    if not parts:
        paper.text(box.x, box.y + box.height / 2, "not shown", 7, colour=GREY)
        return
    normal = parts[0].normal
    side = unit(cross(normal, np.array([0.3, 0.2, 1.0])))
    view = view_of(unit(normal + 0.7 * side + np.array([0.0, 0.0, 0.35])))
    polygons = picture_of(parts, view, largest_only=False, steps=13)
    points = np.concatenate([p.points for p in polygons])
    move = _mapping(np.stack([points.min(axis=0), points.max(axis=0)]), box)
    paper.pen(INK, 0.5)
    for polygon in polygons:
        grey = 0.8 * polygon.shade
        paper.polygon(move(polygon.points), (grey, grey, 1.1 * grey))
    if len(parts) > 1:
        return
    rails = parts[0].rails[-2:] if len(parts[0].rails) > 2 else parts[0].rails
    paper.pen(GREY, 0.35)
    for k in np.linspace(0, rails.shape[1] - 1, 9).round().astype(int):
        paper.polygon(move((rails[:, k] @ view.T)[:, :2]), closed=False)


@dataclass(frozen=True)
class Building:
    """The whole building in grey: its polygons, lowest and highest place in the picture."""

    polygons: tuple[Polygon, ...]
    window: Array

    @classmethod
    def of(cls, parts: Sequence[Shown]) -> Building:
        """The picture of some parts."""
        polygons = tuple(picture_of(parts, view_of(), steps=STEPS))
        if not polygons:
            return cls((), np.array([[0.0, 0.0], [1.0, 1.0]]))
        points = np.concatenate([p.points for p in polygons])
        return cls(polygons, np.stack([points.min(axis=0), points.max(axis=0)]))


def draw_building(paper: Paper, box: Box, building: Building) -> None:
    """Draw the building into the file as the form "building", which pages refer to."""
    move = _mapping(building.window, box)
    paper.canvas.beginForm("building")
    paper.pen((0.55, 0.6, 0.65), 0.12)
    for polygon in building.polygons:
        grey = 0.93 * polygon.shade
        paper.polygon(move(polygon.points), (grey, grey, grey + 0.03))
    paper.canvas.endForm()


def draw_place(paper: Paper, box: Box, window: Array, parts: Sequence[Shown]) -> None:
    """Mark some parts on the building."""
    move = _mapping(window, box)
    paper.pen(HIGHLIGHT, 0.8)
    for polygon in picture_of(parts, view_of(), steps=STEPS):
        paper.polygon(move(polygon.points), HIGHLIGHT)


def _mapping(window: Array, box: Box):
    """Fit what lies between two corners into a box, keeping its proportions."""
    low, high = window
    size = np.maximum(high - low, 1e-9)
    scale = min(box.width / size[0], box.height / size[1])
    centre = np.array([box.x + box.width / 2, box.y + box.height / 2])
    return lambda p: (np.asarray(p) - 0.5 * (low + high)) * scale + centre
