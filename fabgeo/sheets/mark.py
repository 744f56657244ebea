"""Marks as single strokes, sized and placed inside a part and off its cuts.

Glossary
--------
stroke
    An open polyline that is engraved or plotted with one pass: no live text, no double outlines.
clearance
    Distance kept from the outline and from every hole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from fabgeo.arrays import Array
from fabgeo.panels.flat import FlatHole
from fabgeo.sheets.contour import Contour

CAPITALS = 21.0  # units of a capital letter's height in the Hershey fonts
HEIGHTS = (1.0, 0.7, 0.5, 0.35, 0.25, 0.17, 0.12)


@dataclass(frozen=True)
class Mark:
    """Strokes of a mark with its up-side arrow, and where it sits.

    Attributes
    ----------
    strokes : tuple of (k, 2) arrays
    centre : (2,) array
    height : float
        Of the capital letters in mm; 0 where even the smallest does not fit: no strokes then.
    angle : float
        Radians.
    """

    strokes: tuple[Array, ...]
    centre: Array
    height: float
    angle: float


@cache
def _font():
    from HersheyFonts import HersheyFonts

    font = HersheyFonts()
    font.load_default_font("futural")
    return font


@cache
def letters(text: str) -> tuple[tuple[tuple[tuple[float, float], ...], ...], float]:
    """Strokes of a text with capitals of height 1 on the base line y = 0, and the text's width."""
    strokes = [
        tuple(((x / CAPITALS), (9.0 - y) / CAPITALS) for x, y in stroke)
        for stroke in _font().strokes_for_text(text)
    ]
    width = max((x for stroke in strokes for x, _ in stroke), default=0.0)
    return tuple(strokes), width


def up_arrow(left: float) -> list[list[tuple[float, float]]]:
    """An arrow along x beside the text: on the up-side, towards growing u of the strip."""
    end = left + 1.4
    return [[(left, 0.5), (end, 0.5)], [(end - 0.4, 0.8), (end, 0.5), (end - 0.4, 0.2)]]


def place_mark(
    text: str,
    outer: Contour,
    holes: Sequence[FlatHole],
    height: float = 20.0,
    clearance: float = 3.0,
) -> Mark:
    """Find the largest of a few heights at which the mark and its arrow fit inside the part.

    The mark runs along x, or along y where only that fits; among the places that fit, the one
    nearest to the middle of the part is taken.
    """
    material = shapely.Polygon(outer.points(0.5)).buffer(0)
    if holes:
        material = material.difference(shapely.union_all(_regions(holes)))
    room = material.buffer(-clearance - 0.5, quad_segs=2)
    middle = shapely.point_on_surface(material) if room.is_empty else room.representative_point()
    centre = np.array([middle.x, middle.y])
    strokes, width = letters(text)
    arrow = up_arrow(width + 0.6)
    total = width + 2.0
    for share in HEIGHTS if not room.is_empty else ():
        size = height * share
        found = _place(room, total * size, 1.3 * size)
        if found is None:
            continue
        at, angle = found
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c, s], [-s, c]])
        lines = tuple(
            (np.array(stroke) * size - np.array([total / 2.0, 0.5]) * size) @ turn + at
            for stroke in (*strokes, *arrow)
        )
        return Mark(lines, at, size, angle)
    return Mark((), centre, 0.0, 0.0)


def _regions(holes: Sequence[FlatHole]) -> NDArray[np.object_]:
    """What the holes take away: all points within half a width of a point or a slot's line."""
    angles = np.array([hole.angle for hole in holes])
    way = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    half = 0.5 * np.array([[hole.slot] for hole in holes]) * way
    centres = np.array([hole.centre for hole in holes])
    radii = np.array([0.5 * hole.diameter for hole in holes])
    lines = shapely.linestrings(np.stack([centres - half, centres + half], axis=1))
    return shapely.buffer(lines, radii, quad_segs=4)


def _place(room: BaseGeometry, width: float, height: float) -> tuple[Array, float] | None:
    """Centre and angle of a rectangle inside the room, nearest to the room's centroid."""
    shapely.prepare(room)
    for angle in (0.0, np.pi / 2.0):
        w, h = (width, height) if angle == 0.0 else (height, width)
        x0, y0, x1, y1 = room.bounds
        if x1 - x0 < w or y1 - y0 < h:
            continue
        x, y = np.meshgrid(
            np.linspace(x0 + w / 2, x1 - w / 2, 15), np.linspace(y0 + h / 2, y1 - h / 2, 15)
        )
        x, y = x.ravel(), y.ravel()
        boxes = shapely.box(x - w / 2, y - h / 2, x + w / 2, y + h / 2)
        inside = shapely.contains_properly(room, boxes)
        if inside.any():
            away = np.where(
                inside, np.hypot(x - room.centroid.x, (y - room.centroid.y) * 2.0), np.inf
            )
            best = int(np.argmin(away))
            return np.array([x[best], y[best]]), angle
    return None
