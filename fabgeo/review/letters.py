"""The letters of a PDF file: its fonts, how wide words are, and words as PDF operators."""

from __future__ import annotations

import io
import os
from functools import cache, lru_cache
from typing import Any

FONTS = ("Vera", "VeraBd")  # reportlab brings them; they know Latin letters
ESCAPED = str.maketrans({sign: f"\\{sign}" for sign in "\\()"})  # in strings of PDF


class Letters:
    """The regular and the bold font of one file.

    Parameters
    ----------
    canvas : reportlab.pdfgen.canvas.Canvas
        The file's, or one that numbers its fonts and letters alike.
    """

    def __init__(self, canvas: Any) -> None:
        self._file = canvas._doc
        self._names = [font.getSubsetInternalName(0, self._file)[:-1] for font in fonts()]

    def width(self, words: str, size: float, bold: bool = False) -> float:
        """How wide words are, in points."""
        return size * sum(map(_widths(bold).__getitem__, words))

    def shown(self, words: str, size: float, bold: bool = False) -> str:
        """Operators that set the font and show words."""
        name = self._names[bold]
        if words.isascii() and words.isprintable():  # in its place in the first 256 letters
            return f"{name}0 {size:g} Tf ({words.translate(ESCAPED)}) Tj"
        return " ".join(
            f"{name}{number} {size:g} Tf <{codes.hex()}> Tj"
            for number, codes in fonts()[bold].splitString(words, self._file)
        )


def canvas_of(target: Any, size: tuple[float, float], letters: str) -> Any:
    """A file that numbers its fonts, and these letters beyond ASCII, as all others do.

    A form that is never shown uses them first, in one order.
    """
    from reportlab import rl_config
    from reportlab.pdfgen.canvas import Canvas

    rl_config.useA85 = 0  # streams as bytes: a fifth smaller and quicker than as letters
    invariant = 0 if os.environ.get("SOURCE_DATE_EPOCH") else 1
    canvas = Canvas(target, pagesize=size, invariant=invariant, pageCompression=1)
    fonts()
    canvas.beginForm("letters")
    for name in FONTS:
        canvas.setFont(name, 8.0)
        canvas.drawString(0, 0, letters)
    canvas.endForm()
    return canvas


@lru_cache(maxsize=1)
def letters_alike(letters: str) -> Letters:
    """The letters of any such file, for pages that are drawn by themselves."""
    return Letters(canvas_of(io.BytesIO(), (1.0, 1.0), letters))


@cache
def fonts() -> tuple[Any, Any]:
    """Both fonts as reportlab knows them."""
    from reportlab.pdfbase import pdfmetrics
    from reportlab.pdfbase.ttfonts import TTFont

    made = [TTFont(name, f"{name}.ttf") for name in FONTS]
    for font in made:
        pdfmetrics.registerFont(font)
    return made[0], made[1]


class _Widths(dict[str, float]):
    """Widths of letters in a font's size, looked up once."""

    def __init__(self, bold: bool) -> None:
        super().__init__()
        self._font = fonts()[bold]

    def __missing__(self, letter: str) -> float:
        self[letter] = width = self._font.stringWidth(letter, 1.0)
        return width


@cache
def _widths(bold: bool) -> _Widths:
    return _Widths(bold)
