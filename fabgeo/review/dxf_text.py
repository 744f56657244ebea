"""DXF read as plain text: what the check measures, sharing no code with who wrote the files.

Glossary
--------
group
    A pair of lines: an integer code and a value. An entity begins with code 0.
bulge
    Tangent of a quarter of the angle of an arc between two vertices.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import InputError

ARC_SAGITTA = 0.005  # mm: how far a polygon may be off the arcs it stands for


@dataclass(frozen=True)
class Entity:
    """One entity: its kind, its layer, its groups in order."""

    kind: str
    layer: str
    groups: tuple[tuple[int, str], ...]

    def number(self, code: int, default: float = 0.0) -> float:
        """The first value of a code."""
        return next((float(value) for c, value in self.groups if c == code), default)

    def numbers(self, code: int) -> list[float]:
        """All values of a code."""
        return [float(value) for c, value in self.groups if c == code]

    def text(self, code: int = 1) -> str:
        """The first value of a code as text."""
        return next((value for c, value in self.groups if c == code), "")


@dataclass
class Curve:
    """A polyline of lines and arcs: vertices (k, 3) of x, y and bulge; closed or not.

    `joined`: from splines and lines that meet end to end.
    """

    layer: str
    vertices: Array
    closed: bool
    joined: bool = False

    def points(self, sagitta: float = ARC_SAGITTA) -> Array:
        """Points (n, 2) of the curve, arcs by chords of at most this sagitta."""
        rows = self.vertices
        ends = np.roll(rows[:, :2], -1, axis=0)
        pieces = []
        last = len(rows) if self.closed else len(rows) - 1
        for k in range(last):
            pieces.append(_arc(rows[k, :2], ends[k], float(rows[k, 2]), sagitta))
        if not self.closed:
            pieces.append(rows[-1:, :2])
        return np.concatenate(pieces)

    @property
    def area(self) -> float:
        """Area in mm2 inside a closed curve, unsigned: a polygon and the segments of its arcs.

        Chords would not do: beside 1 m of an arc they leave out up to 3 mm2.
        """
        start, bulge = self.vertices[:, :2], self.vertices[:, 2]
        end = np.roll(start, -1, axis=0)
        polygon = np.sum(start[:, 0] * end[:, 1] - end[:, 0] * start[:, 1]) / 2.0
        chord, angle = np.linalg.norm(end - start, axis=1), 4.0 * np.arctan(bulge)
        return abs(float(polygon + np.sum(chord**2 * _segment(angle))))


@dataclass
class Drawing:
    """What a file holds, by meaning: curves (a circle is two arcs), lines, texts.

    `others` are kind and layer of what has none.
    """

    name: str
    unit: int | None = None
    curves: list[Curve] = field(default_factory=list)
    lines: list[tuple[str, float, float, float, float]] = field(default_factory=list)
    texts: list[tuple[str, str, float, float]] = field(default_factory=list)
    others: list[tuple[str, str]] = field(default_factory=list)


def read_drawing(path: Path) -> Drawing:
    """Read a DXF file's model space.

    Raises
    ------
    InputError
        If the file is no DXF text.
    """
    if not path.is_file():  # a pipe would never end
        raise InputError(str(path), "is no file")
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
        groups = list(_groups(lines))
        drawing = Drawing(path.name)
        if "$INSUNITS" in lines:
            drawing.unit = int(lines[lines.index("$INSUNITS") + 2])
        _collect(list(_entities(groups)), drawing)
    except (OSError, ValueError, LookupError, OverflowError) as error:
        raise InputError(str(path), f"is no sound DXF text: {error}", "write it again") from error
    return drawing


def _groups(lines: list[str]) -> Iterator[tuple[int, str]]:
    """Groups of the ENTITIES section; most of a small file is its other sections.

    Raises
    ------
    ValueError
        If there is no such section, or a code that is no number.
    """
    if "ENTITIES" not in lines:
        raise ValueError("it has no section ENTITIES")
    for k in range(lines.index("ENTITIES") + 1, len(lines) - 1, 2):
        word = lines[k + 1].strip()
        if word == "ENDSEC":
            return
        yield int(lines[k]), word


def _entities(groups: list[tuple[int, str]]) -> Iterator[Entity]:
    """Entities of groups: each begins with code 0."""
    begins = [k for k, (code, _) in enumerate(groups) if code == 0]
    for first, last in zip(begins, [*begins[1:], len(groups)], strict=True):
        own = tuple(groups[first + 1 : last])
        yield Entity(groups[first][1], next((v for c, v in own if c == 8), ""), own)


def _collect(entities: list[Entity], drawing: Drawing) -> None:
    pending: tuple[Entity, list[tuple[float, float, float]]] | None = None
    loose: dict[str, list[Array]] = {}
    for e in entities:
        if e.number(230, 1.0) != 1.0:  # an extrusion: seen from below, or out of the plane
            drawing.others.append((f"{e.kind} with an extrusion", e.layer))
        if e.kind == "LWPOLYLINE":
            drawing.curves.append(Curve(e.layer, _vertices(e), int(e.number(70)) % 2 == 1))
        elif e.kind == "POLYLINE":
            pending = (e, [])
        elif e.kind == "VERTEX" and pending is not None:
            pending[1].append((e.number(10), e.number(20), e.number(42)))
        elif e.kind == "SEQEND" and pending is not None:
            head, rows = pending
            closed = int(head.number(70)) % 2 == 1
            drawing.curves.append(Curve(head.layer, np.array(rows, dtype=float), closed))
            pending = None
        elif e.kind == "CIRCLE":
            x, y, radius = e.number(10), e.number(20), e.number(40)
            halves = np.array([[x - radius, y, 1.0], [x + radius, y, 1.0]])
            drawing.curves.append(Curve(e.layer, halves, closed=True))
        elif e.kind == "LINE":
            ends = (e.number(10), e.number(20), e.number(11), e.number(21))
            drawing.lines.append((e.layer, *ends))
            loose.setdefault(e.layer, []).append(np.array(ends).reshape(2, 2))
        elif e.kind == "SPLINE":
            loose.setdefault(e.layer, []).append(_spline(e))
        elif e.kind == "TEXT":
            drawing.texts.append((e.layer, e.text(), e.number(10), e.number(20)))
        else:
            drawing.others.append((e.kind, e.layer))
    if any(e.kind == "SPLINE" for e in entities):
        for layer in sorted({e.layer for e in entities if e.kind == "SPLINE"}):
            drawing.curves += _loops(layer, loose[layer])


def _vertices(entity: Entity) -> Array:
    """Rows x, y, bulge of an LWPOLYLINE; a bulge belongs to the vertex before it."""
    rows: list[list[float]] = []
    for code, value in entity.groups:
        if code == 10:
            rows.append([float(value), 0.0, 0.0])
        elif code == 20 and rows:
            rows[-1][1] = float(value)
        elif code == 42 and rows:
            rows[-1][2] = float(value)
    return np.array(rows, dtype=float).reshape(-1, 3)


def _spline(entity: Entity) -> Array:
    """Points of an open B-spline, 17 to a knot span."""
    from scipy.interpolate import BSpline

    degree = int(entity.number(71))
    knots = np.array(entity.numbers(40))
    poles = np.array([entity.numbers(10), entity.numbers(20)]).T
    spans = np.unique(knots[degree : len(knots) - degree])
    inner = spans[:-1, None] + np.diff(spans)[:, None] * np.linspace(0, 1, 17)[None, :-1]
    return np.asarray(BSpline(knots, poles, degree)(np.append(inner.ravel(), spans[-1])))


def _loops(layer: str, pieces: list[Array], reach: float = 1e-3) -> list[Curve]:
    """Join pieces end to end into curves."""
    waiting, found = list(pieces), []
    while waiting:
        chain = waiting.pop(0)
        grown = True
        while grown:
            grown = False
            for k, piece in enumerate(waiting):
                for own in (piece, piece[::-1]):
                    if np.linalg.norm(chain[-1] - own[0]) <= reach:
                        chain, grown = np.concatenate([chain, own[1:]]), True
                        break
                if grown:
                    waiting.pop(k)
                    break
        closed = bool(np.linalg.norm(chain[0] - chain[-1]) <= reach)
        rows = chain[:-1] if closed else chain
        found.append(Curve(layer, np.column_stack([rows, np.zeros(len(rows))]), closed, True))
    return found


def _segment(angle: Array) -> Array:
    """Area between an arc of a signed angle and its chord, by the chord's square."""
    sine = np.sin(angle / 2.0)
    small = np.abs(angle) < 1e-2  # by its series: of 1 - cos there is nothing left
    series = angle / 12.0 * (1.0 + angle**2 / 30.0)
    return np.where(
        small, series, (angle - np.sin(angle)) / (8.0 * np.where(small, 1.0, sine) ** 2)
    )


def _arc(p: Array, q: Array, bulge: float, sagitta: float) -> Array:
    """Points from p up to before q on the arc of a bulge."""
    if bulge == 0.0:
        return p[None]
    chord = q - p
    size = float(np.hypot(*chord))
    angle = 4.0 * math.atan(bulge)
    radius = size * (1.0 + bulge**2) / (4.0 * abs(bulge)) if size else 0.0
    step = 2.0 * math.acos(max(1.0 - sagitta / radius, -1.0)) if radius > sagitta else 1.0
    count = max(1, math.ceil(abs(angle) / max(step, 1e-5)))
    t = np.arange(count) / count
    # Rotating chords from p: |p x| = chord sin(angle t / 2) / sin(angle / 2), at the angle between.
    turn = -0.5 * angle * (1.0 - t)
    ratio = np.sin(0.5 * angle * t) / math.sin(0.5 * angle)
    c, s = np.cos(turn) * ratio, np.sin(turn) * ratio
    return p + np.stack([c * chord[0] - s * chord[1], s * chord[0] + c * chord[1]], axis=1)
