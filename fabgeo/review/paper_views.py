"""Small views in space for the drawings: one part, and its place in the building."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from fabgeo.arrays import Array, cross, unit
from fabgeo.review.paper import GREY, INK, Box, Paper
from fabgeo.review.picture import Polygon, picture_of, view_of
from fabgeo.review.record import Shown

HIGHLIGHT = (0.82, 0.0, 0.44)


def space_view(paper: Paper, box: Box, part: Shown | None) -> None:
    """One part seen from its outer side."""
    if part is None:
        paper.text(box.x, box.y + box.height / 2, "not shown", 7, colour=GREY)
        return
    side = unit(cross(part.normal, np.array([0.3, 0.2, 1.0])))
    view = view_of(unit(part.normal + 0.7 * side + np.array([0.0, 0.0, 0.35])))
    polygons = picture_of([part], view, largest_only=False, steps=13)
    move = _mapping(np.concatenate([p.points for p in polygons]), box)
    paper.pen(INK, 0.5)
    for polygon in polygons:
        grey = 0.8 * polygon.shade
        paper.polygon(move(polygon.points), (grey, grey, 1.1 * grey))
    rails = part.rails[-2:] if len(part.rails) > 2 else part.rails
    paper.pen(GREY, 0.35)
    for k in np.linspace(0, rails.shape[1] - 1, 9).round().astype(int):
        paper.polygon(move((rails[:, k] @ view.T)[:, :2]), closed=False)


class PlaceView:
    """The whole building in grey, with some parts marked."""

    def __init__(self, parts: Sequence[Shown]) -> None:
        self.view = view_of()
        self.polygons: list[Polygon] = picture_of(parts, self.view, steps=3)
        self.points = (
            np.concatenate([p.points for p in self.polygons]) if parts else np.zeros((1, 2))
        )
        self.form: str | None = None
        self.of: dict[str, list[Polygon]] = defaultdict(list)
        for polygon in self.polygons:
            self.of[polygon.mark].append(polygon)

    def draw(
        self,
        paper: Paper,
        box: Box,
        marks: Collection[str],
        shown: Mapping[str, Shown] | None = None,
    ) -> None:
        """Draw the building once into the file, then only refer to it; marked parts on top."""
        move = _mapping(self.points, box)
        name = f"building-{box.x:g}-{box.y:g}-{box.width:g}"
        if not paper.canvas.hasForm(name):
            paper.canvas.beginForm(name)
            paper.pen((0.55, 0.6, 0.65), 0.12)
            for polygon in self.polygons:
                grey = 0.93 * polygon.shade
                paper.polygon(move(polygon.points), (grey, grey, grey + 0.03))
            paper.canvas.endForm()
        paper.canvas.doForm(name)
        own = [polygon for mark in sorted(marks) for polygon in self.of.get(mark, ())]
        if shown is not None:
            own = picture_of([shown[m] for m in sorted(marks) if m in shown], self.view)
        paper.pen(HIGHLIGHT, 0.8)
        for polygon in own:
            paper.polygon(move(polygon.points), HIGHLIGHT)


def _mapping(points: Array, box: Box):
    """Fit points into a box, keeping their proportions."""
    low, high = points.min(axis=0), points.max(axis=0)
    size = np.maximum(high - low, 1e-9)
    scale = min(box.width / size[0], box.height / size[1])
    centre = np.array([box.x + box.width / 2, box.y + box.height / 2])
    return lambda p: (np.asarray(p) - 0.5 * (low + high)) * scale + centre
