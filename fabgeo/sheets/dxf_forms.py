"""Entities as text: ezdxf writes a sample of each, files repeat it with other numbers.

Glossary
--------
form
    The text of one entity of one DXF version, with places for its handle, layer and numbers.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

from fabgeo.arrays import Array

SHARED = {"5": "handle", "8": "layer"}  # places by group code
ENDS = {"10": "x", "20": "y", "11": "x2", "21": "y2"}
CENTRE = {"10": "x", "20": "y", "40": "size"}
WORDS = {**CENTRE, "1": "words", "50": "angle"}
COUNTS = {"90": "count", "70": "closed"}
KNOTS = {"72": "knots", "73": "poles"}


class Forms:
    """The forms of an empty document.

    Attributes
    ----------
    first : int
        The first handle that is free.
    encoding : str
        Of the file's text.
    """

    def __init__(self, document: Any) -> None:
        from ezdxf.lldxf.const import DXF12

        self._document = document
        self.first = int(str(document.entitydb.handles), 16)
        self.encoding: str = document.output_encoding
        self.old = document.dxfversion == DXF12
        self._handles = not self.old or bool(document.header.get("$HANDLING", 0))
        space = document.modelspace()
        self.line = self._form(space.add_line((1, 2), (3, 4)), ENDS)
        self.circle = self._form(space.add_circle((1, 2), 3), CENTRE)
        text = space.add_text("x", dxfattribs={"height": 2, "rotation": 3, "insert": (4, 5)})
        self.text = self._form(text, WORDS)
        self.spline = ""
        if self.old:
            chain = space.add_polyline2d([(1, 2, 3)], format="xyb", close=True)
            parts = self._text(chain).split("  0\n")[1:]
            head, self.vertex, self.end = ("  0\n" + part for part in parts)
            self.chain = _places(head, {"70": "closed"})
            self.vertex = _places(_without(self.vertex, "42"), {"10": "x", "20": "y"})
            self.end = _places(self.end, {})
        else:
            chain = space.add_lwpolyline([(1, 2)], close=True)
            head, _, _ = self._text(chain).partition(" 10\n")
            self.chain, self.vertex, self.end = _places(head, COUNTS), " 10\n{x}\n 20\n{y}\n", ""
            curve = space.add_open_spline([(0, 0, 0)] * 4, degree=3)
            self.spline = _places(self._text(curve).partition(" 40\n")[0], KNOTS)
        space.delete_all_entities()
        document.entitydb.purge()

    def _text(self, entity: Any) -> str:
        from ezdxf.lldxf.tagwriter import TagWriter

        out = io.StringIO()
        entity.export_dxf(TagWriter(out, self._document.dxfversion, self._handles))
        return out.getvalue()

    def _form(self, entity: Any, places: dict[str, str]) -> str:
        return _places(self._text(entity), places)


class Entities:
    """The entities of one file as text, in the order in which they are added."""

    def __init__(self, forms: Forms) -> None:
        self._forms, self._next = forms, forms.first
        self._parts: list[str] = []

    @property
    def text(self) -> str:
        """All of them."""
        return "".join(self._parts)

    def _handle(self) -> str:
        self._next += 1
        return f"{self._next - 1:X}"

    def _add(self, form: str, layer: str, **values: object) -> None:
        self._parts.append(form.format(handle=self._handle(), layer=layer, **values))

    def line(self, layer: str, start: Sequence[float], end: Sequence[float]) -> None:
        """A line between two points."""
        (x, y), (x2, y2) = map(float, start), map(float, end)
        self._add(self._forms.line, layer, x=x, y=y, x2=x2, y2=y2)

    def circle(self, layer: str, centre: Sequence[float], radius: float) -> None:
        """A circle."""
        x, y = map(float, centre)
        self._add(self._forms.circle, layer, x=x, y=y, size=float(radius))

    def write(
        self, layer: str, words: str, at: Sequence[float], height: float, degrees: float = 0.0
    ) -> None:
        """One line of text that begins at a point."""
        x, y = map(float, at)
        one = " ".join(words.splitlines())
        self._add(self._forms.text, layer, words=one, x=x, y=y, size=float(height),
                  angle=float(degrees))  # fmt: skip

    def polyline(self, layer: str, vertices: Array, closed: bool) -> None:
        """A polyline through vertices (k, 3): x, y and the bulge towards the next."""
        forms = self._forms
        self._add(forms.chain, layer, count=len(vertices), closed=int(closed))
        for x, y, bulge in vertices.tolist():
            handle = self._handle() if forms.old else ""
            self._parts.append(forms.vertex.format(handle=handle, layer=layer, x=x, y=y))
            if bulge:
                self._parts.append(f" 42\n{bulge}\n")
        if forms.end:
            self._add(forms.end, layer)

    def spline(self, layer: str, poles: Array, knots: Array) -> None:
        """A cubic B-spline with poles (k, 2) and knots (k + 4,)."""
        self._add(self._forms.spline, layer, knots=len(knots), poles=len(poles))
        self._parts += [f" 40\n{knot}\n" for knot in knots.tolist()]
        self._parts += [f" 10\n{x}\n 20\n{y}\n 30\n0.0\n" for x, y in poles.tolist()]


def _places(text: str, places: dict[str, str]) -> str:
    """A sample's text with names in braces in place of the values of some group codes."""
    own = {**SHARED, **places}
    lines = text.splitlines()
    for at in range(0, len(lines), 2):
        name = own.get(lines[at].strip())
        value = lines[at + 1].replace("{", "{{").replace("}", "}}")
        lines[at + 1] = value if name is None else f"{{{name}}}"
    return "\n".join(lines) + "\n"


def _without(text: str, code: str) -> str:
    """A sample's text without the tags of one group code."""
    lines = text.splitlines()
    pairs = zip(lines[::2], lines[1::2], strict=True)
    return "".join(f"{key}\n{value}\n" for key, value in pairs if key.strip() != code)
