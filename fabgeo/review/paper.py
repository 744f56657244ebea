"""A page of paper: lines, texts, dimensions, tables, in points from the lower left corner.

Glossary
--------
operator
    A line of a page's content as PDF has it: "x y m" moves, "x y l" draws a line, "S" strokes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from fabgeo.arrays import Array
from fabgeo.review.letters import Letters

MM = 72.0 / 25.4  # points in a millimetre
KAPPA = 4.0 / 3.0 * (2.0**0.5 - 1.0)  # of the radius: handles of a quarter circle's Bezier curve
SCALES = (1, 2, 2.5, 5, 10, 15, 20, 25, 40, 50, 75, 100, 125, 150, 200, 250, 500, 1000)
INK, GREY, BLUE, RED = (0.1, 0.12, 0.14), (0.45, 0.5, 0.55), (0.0, 0.33, 0.6), (0.75, 0.2, 0.05)


class Box(NamedTuple):
    """A rectangle on the page: lower left corner, width, height, in points."""

    x: float
    y: float
    width: float
    height: float


def fit(box: Box, length: float, width: float) -> float:
    """The smallest scale 1 : s of the usual ones at which length x width (mm) fits the box."""
    need = max(length * MM / max(box.width, 1.0), width * MM / max(box.height, 1.0))
    return next((s for s in SCALES if s >= need), float(np.ceil(need / 500.0) * 500.0))


class Paper:
    """One page's content, drawn with the habits of a drawing office.

    Parameters
    ----------
    letters : Letters
        The fonts of the file that the page goes into.
    size : (float, float)
    """

    def __init__(self, letters: Letters, size: tuple[float, float]) -> None:
        self.letters, self.size = letters, size
        self._content: list[str] = []
        self._pen = self._fill = ""

    def content(self) -> str:
        """What was drawn; the page is empty again."""
        made, self._content = "\n".join(self._content), []
        self._pen = self._fill = ""
        return made

    def frame(self) -> None:
        """The border of the page."""
        self.pen(INK, 1.0)
        self._content.append(f"28 28 {self.size[0] - 56:.2f} {self.size[1] - 56:.2f} re S")

    def pen(
        self, colour: tuple[float, float, float], width: float, dash: Sequence[float] = ()
    ) -> None:
        """Set the colour, width and dashes of lines."""
        dashes = " ".join(f"{length:g}" for length in dash)
        wanted = f"{_colour(colour)} RG {width:g} w [{dashes}] 0 d"
        if wanted != self._pen:
            self._pen = wanted
            self._content.append(wanted)

    def fill(self, colour: tuple[float, float, float]) -> None:
        """Set the colour of areas and letters."""
        wanted = f"{_colour(colour)} rg"
        if wanted != self._fill:
            self._fill = wanted
            self._content.append(wanted)

    def text(
        self,
        x: float,
        y: float,
        words: object,
        size: float = 8.0,
        at: str = "start",
        bold: bool = False,
        colour: tuple[float, float, float] = INK,
    ) -> None:
        """One line of text, its start, middle or end at (x, y)."""
        words = str(words)
        if at != "start":
            x -= self.letters.width(words, size, bold) * (0.5 if at == "middle" else 1.0)
        self.fill(colour)
        self._content.append(
            f"BT 1 0 0 1 {x:.2f} {y:.2f} Tm {self.letters.shown(words, size, bold)} ET"
        )

    def turned(self, x: float, y: float, words: str, angle: float, size: float = 7.0) -> None:
        """Text centred at a place, turned by an angle in degrees so that it reads upright."""
        upright = math.radians((angle + 90.0) % 180.0 - 90.0)
        c, s = math.cos(upright), math.sin(upright)
        back, down = -0.5 * self.letters.width(words, size), -0.35 * size
        x, y = x + c * back - s * down, y + s * back + c * down
        self.fill(INK)
        place = f"{c:.5f} {s:.5f} {-s:.5f} {c:.5f} {x:.2f} {y:.2f}"
        self._content.append(f"BT {place} Tm {self.letters.shown(words, size)} ET")

    def line(self, start: Sequence[float] | Array, end: Sequence[float] | Array) -> None:
        """A straight line between two points (2,)."""
        x, y = start
        self._content.append(f"{x:.2f} {y:.2f} m {end[0]:.2f} {end[1]:.2f} l S")

    def heading(self, x: float, y: float, words: str) -> None:
        """A small bold heading."""
        self.text(x, y, words, 8.5, bold=True, colour=BLUE)

    def polygon(
        self,
        points: Array,
        fill: tuple[float, float, float] | None = None,
        closed: bool = True,
        stroke: bool = True,
    ) -> None:
        """A polyline or polygon through points (n, 2) on the page."""
        if fill is not None:
            self.fill(fill)
        way = " ".join(f"{x:.2f} {y:.2f} l" for x, y in points[1:].tolist())
        begin = f"{points[0, 0]:.2f} {points[0, 1]:.2f} m"
        paint = "n" if fill is None else "f"
        if stroke:
            paint = "S" if fill is None else "B"
        self._content.append(f"{begin} {way}{' h' if closed else ''} {paint}")

    def slot(self, x: float, y: float, radius: float, way: Sequence[float] = (0.0, 0.0)) -> None:
        """A slot from its middle less `way` to its middle plus `way`; a circle where that is 0."""
        length = math.hypot(*way)
        e = np.array([way[0] / length, way[1] / length] if length > 0.0 else [1.0, 0.0]) * radius
        n, middle, far = np.array([-e[1], e[0]]), np.array([x, y]), np.array(way)
        round_end = _QUARTERS @ np.stack([e, n])
        points = np.concatenate([middle + far + round_end, middle - far - round_end])
        self._content.append(_SLOT % tuple(points.ravel().tolist()))

    def dimension(self, p: Array, q: Array, away: float, words: str, small: bool = False) -> None:
        """A dimension line parallel to p q, `away` points to its right, with ticks."""
        chord = q - p
        length = float(np.linalg.norm(chord))
        if length < 1e-6:
            return
        e = chord / length
        n = np.array([e[1], -e[0]])
        a, b = p + away * n, q + away * n
        self.pen(GREY, 0.4)
        sign = np.sign(away) or 1.0
        for start, end in (
            (p + 2 * sign * n, a + 3 * sign * n),
            (q + 2 * sign * n, b + 3 * sign * n),
        ):
            self.line(start, end)
        self.line(a, b)
        tick = 2.6 * (e + n) / np.sqrt(2.0)
        self.pen(INK, 0.8)
        for end in (a, b):
            self.line(end - tick, end + tick)
        middle = 0.5 * (a + b) + 7.0 * sign * n
        size = 6.0 if small else 7.0
        self.turned(
            float(middle[0]),
            float(middle[1]),
            words,
            float(np.degrees(np.arctan2(e[1], e[0]))),
            size,
        )

    def table(
        self,
        x: float,
        y: float,
        heads: Sequence[str],
        lines: Sequence[Sequence[str]],
        widths: Sequence[float],
    ) -> float:
        """A table with its top at y; returns the y below it."""
        step, right = 10.5, x + sum(widths)
        ends = np.append(x, x + np.cumsum(widths))
        for k, head in enumerate(heads):
            if k == 0:
                self.text(ends[0] + 2, y - 8, head, 6.3, bold=True)
            else:
                self.text(ends[k + 1] - 2, y - 8, head, 6.3, "end", bold=True)
        self.pen(INK, 0.6)
        self.line((x, y - step), (right, y - step))
        for row, line in enumerate(lines, start=1):
            base = y - row * step - 8
            for k, words in enumerate(line):
                if k == 0:
                    self.text(ends[0] + 2, base, words, 6.3)
                else:
                    self.text(ends[k + 1] - 2, base, words, 6.3, "end")
            self.pen((0.85, 0.87, 0.89), 0.3)
            self.line((x, base - 2.5), (right, base - 2.5))
        return y - step * (len(lines) + 1) - 3

    def title_block(self, fields: Sequence[tuple[str, object]], note: str) -> None:
        """The row of fields along the foot of the page."""
        left, bottom, high = 28.0, 28.0, 62.0
        whole = self.size[0] - 56.0
        weights = np.array([2.2, 1.5] + [1.0] * (len(fields) - 2))
        widths = whole * weights / weights.sum()
        self.pen(INK, 0.8)
        self.line((left, bottom + high), (left + whole, bottom + high))
        x = left
        for (name, value), width in zip(fields, widths, strict=True):
            self.text(x + 5, bottom + high - 13, name, 6.5, colour=GREY)
            size = 15.0 if name == "Mark" else 9.0
            words = str(value)
            wide = self.letters.width(words, size, bold=True)
            size *= min(1.0, (width - 9.0) / wide) if wide else 1.0
            self.text(x + 5, bottom + high - 34, words, size, bold=True)
            x += width
            if x < left + whole - 1.0:
                self.pen(GREY, 0.4)
                self.line((x, bottom + 16), (x, bottom + high))
        self.text(left + 5, bottom + 6, note, 6.5, colour=GREY)


# From the side of a slot's end over its tip to the other side, along e and n of length `radius`.
_QUARTERS = np.array(
    [[0, -1], [KAPPA, -1], [1, -KAPPA], [1, 0], [1, KAPPA], [KAPPA, 1], [0, 1]], dtype=np.float64
)
_HALF = "%.2f %.2f {} " + 2 * ("%.2f %.2f " * 3 + "c ")
_SLOT = _HALF.format("m") + _HALF.format("l") + "h S"


@lru_cache(maxsize=256)
def _colour(colour: tuple[float, float, float]) -> str:
    return " ".join(f"{share:.4g}" for share in colour)
