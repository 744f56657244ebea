"""A page of paper: lines, texts, dimensions, tables, in points from the lower left corner."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from fabgeo.arrays import Array

MM = 72.0 / 25.4  # points in a millimetre
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


@cache
def fonts() -> tuple[str, str]:
    """Names of the regular and the bold font; reportlab brings Vera, which knows Latin letters."""
    from reportlab.pdfbase import pdfmetrics
    from reportlab.pdfbase.ttfonts import TTFont

    for name in ("Vera", "VeraBd"):
        pdfmetrics.registerFont(TTFont(name, f"{name}.ttf"))
    return "Vera", "VeraBd"


class Paper:
    """A thin layer over a reportlab canvas with the habits of a drawing office."""

    def __init__(self, canvas: Any, size: tuple[float, float]) -> None:
        self.canvas, self.size = canvas, size
        self.regular, self.bold = fonts()

    def frame(self) -> None:
        """The border of the page."""
        self.pen(INK, 1.0)
        self.canvas.rect(28, 28, self.size[0] - 56, self.size[1] - 56)

    def pen(
        self, colour: tuple[float, float, float], width: float, dash: Sequence[float] = ()
    ) -> None:
        """Set the colour, width and dashes of lines."""
        self.canvas.setStrokeColorRGB(*colour)
        self.canvas.setLineWidth(width)
        self.canvas.setDash(list(dash))

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
        self.canvas.setFillColorRGB(*colour)
        self.canvas.setFont(self.bold if bold else self.regular, size)
        draw = {
            "start": self.canvas.drawString,
            "middle": self.canvas.drawCentredString,
            "end": self.canvas.drawRightString,
        }[at]
        draw(x, y, str(words))

    def turned(self, x: float, y: float, words: str, angle: float, size: float = 7.0) -> None:
        """Text centred at a place, turned by an angle in degrees so that it reads upright."""
        upright = (angle + 90.0) % 180.0 - 90.0
        self.canvas.saveState()
        self.canvas.translate(x, y)
        self.canvas.rotate(upright)
        self.text(0, -0.35 * size, words, size, "middle")
        self.canvas.restoreState()

    def line(self, start: Array, end: Array) -> None:
        """A straight line between two points (2,)."""
        self.canvas.line(float(start[0]), float(start[1]), float(end[0]), float(end[1]))

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
        path = self.canvas.beginPath()
        path.moveTo(*points[0])
        for point in points[1:]:
            path.lineTo(*point)
        if closed:
            path.close()
        if fill is not None:
            self.canvas.setFillColorRGB(*fill)
        self.canvas.drawPath(path, stroke=int(stroke), fill=int(fill is not None))

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
        self.canvas.line(x, y - step, right, y - step)
        for row, line in enumerate(lines, start=1):
            base = y - row * step - 8
            for k, words in enumerate(line):
                if k == 0:
                    self.text(ends[0] + 2, base, words, 6.3)
                else:
                    self.text(ends[k + 1] - 2, base, words, 6.3, "end")
            self.pen((0.85, 0.87, 0.89), 0.3)
            self.canvas.line(x, base - 2.5, right, base - 2.5)
        return y - step * (len(lines) + 1) - 3

    def title_block(self, fields: Sequence[tuple[str, object]], note: str) -> None:
        """The row of fields along the foot of the page."""
        left, bottom, high = 28.0, 28.0, 62.0
        whole = self.size[0] - 56.0
        weights = np.array([2.2, 1.5] + [1.0] * (len(fields) - 2))
        widths = whole * weights / weights.sum()
        self.pen(INK, 0.8)
        self.canvas.line(left, bottom + high, left + whole, bottom + high)
        x = left
        for (name, value), width in zip(fields, widths, strict=True):
            self.text(x + 5, bottom + high - 13, name, 6.5, colour=GREY)
            size = 15.0 if name == "Mark" else 9.0
            words = str(value)
            wide = self.canvas.stringWidth(words, self.bold, size)
            size *= min(1.0, (width - 9.0) / wide) if wide else 1.0
            self.text(x + 5, bottom + high - 34, words, size, bold=True)
            x += width
            if x < left + whole - 1.0:
                self.pen(GREY, 0.4)
                self.canvas.line(x, bottom + 16, x, bottom + high)
        self.text(left + 5, bottom + 6, note, 6.5, colour=GREY)
