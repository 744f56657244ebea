"""Reading the written DXF files back, by themselves: contours with exact arcs, holes, marks.

Glossary
--------
file part
    One outer contour with all that lies in it: holes, bend lines, strokes and its mark.

Nothing here knows what wrote the files; the contract of the layers is all that is shared.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.sheets.contour import Contour
from fabgeo.sheets.dxf_document import LAYERS

JOIN = 1e-6  # mm, between the ends of lines and splines of one outline
FLATTEN = 0.002  # mm, of splines


@dataclass(frozen=True)
class FilePart:
    """A part as read from a file.

    Attributes
    ----------
    mark : str
    outer : Contour
    inner : tuple of Contour
        Contours on CUT_INNER and HOLES.
    bends : (n, 2, 2) array
    strokes : tuple of (k, 2) arrays
    """

    mark: str
    outer: Contour
    inner: tuple[Contour, ...]
    bends: Array
    strokes: tuple[Array, ...]

    @property
    def area(self) -> float:
        """Net area in mm2, on exact arcs."""
        return abs(self.outer.area) - sum(abs(contour.area) for contour in self.inner)


@dataclass(frozen=True)
class FileSheet:
    """A nested sheet as read: the stock's size, parts in place, the title line."""

    length: float
    width: float
    parts: tuple[FilePart, ...]
    title: str


def read_part(path: Path, layers: Mapping[str, str] | None = None) -> FilePart:
    """Read the file of one part.

    Raises
    ------
    InputError
        If it can't be read, is not in millimetres, has an unknown layer, an open or self-crossing
        contour, or not exactly one part.
    """
    content = _content(path, layers)
    parts = _parts(path, content)
    if len(parts) != 1:
        raise InputError(path.name, f"expected one outer contour, found {len(parts)}")
    return parts[0]


def read_sheet(path: Path, layers: Mapping[str, str] | None = None) -> FileSheet:
    """Read the file of one nested sheet; errors as `read_part`, and a missing SHEET rectangle."""
    content = _content(path, layers)
    if len(content.stock) != 1:
        raise InputError(path.name, f"expected one SHEET rectangle, found {len(content.stock)}")
    x0, y0, x1, y1 = content.stock[0].bounds()
    if max(abs(x0), abs(y0)) > JOIN:
        raise InputError(
            path.name, f"the SHEET rectangle starts at ({x0:g}, {y0:g}), expected 0, 0"
        )
    title = " ".join(text for text, at in content.texts if at[1] < y0)
    return FileSheet(x1, y1, tuple(_parts(path, content)), title)


@dataclass
class _Content:
    outer: list[Contour]
    inner: list[Contour]
    stock: list[Contour]
    bends: list[Array]
    strokes: list[Array]
    texts: list[tuple[str, Array]]


def _content(path: Path, layers: Mapping[str, str] | None) -> _Content:
    from ezdxf.filemanagement import readfile

    try:
        document = readfile(path)
        entities = list(document.modelspace())
    except OSError as error:
        raise InputError(path.name, f"can't be read: {error}") from error
    except Exception as error:  # whatever a foreign reader raises over foreign bytes
        raise InputError(path.name, f"is no sound DXF file: {error}") from error
    unit = document.header.get("$INSUNITS", None)
    if document.dxfversion > "AC1009" and unit != 4:
        raise InputError(path.name, f"expected millimetres ($INSUNITS 4), found {unit}")
    names = {(layers or {}).get(key, name): key for key, name in LAYERS.items()}
    content = _Content([], [], [], [], [], [])
    loose: list[Any] = []
    for entity in entities:
        if not entity.dxf.is_supported("layer"):
            raise InputError(path.name, f"holds {entity.dxftype()}, which is no kind of entity")
        layer = names.get(entity.dxf.layer)
        if layer is None:
            raise InputError(
                path.name, f"{entity.dxftype()} on the unknown layer {entity.dxf.layer!r}"
            )
        _sort(path, entity, layer, content, loose)
    if loose:
        content.outer += _chained(path, loose)
    return content


def _sort(path: Path, entity: Any, layer: str, content: _Content, loose: list[Any]) -> None:
    kind = entity.dxftype()
    if kind == "TEXT":
        if layer != "INFO":
            raise InputError(path.name, f"live text {entity.dxf.text!r} on layer {layer}")
        content.texts.append((entity.dxf.text, np.array(entity.dxf.insert)[:2]))
    elif layer == "RULINGS" and kind == "LINE":
        ends = [np.array(entity.dxf.start)[:2], np.array(entity.dxf.end)[:2]]
        content.bends.append(np.stack(ends))
    elif layer == "MARK" and kind in ("LWPOLYLINE", "POLYLINE"):
        content.strokes.append(_vertices(entity)[:, :2])
        if len(content.strokes[-1]) < 2:
            raise InputError(path.name, f"a stroke on layer {layer} has no length")
    elif layer in ("CUT_OUTER", "CUT_INNER", "HOLES", "SHEET"):
        target = {"CUT_OUTER": content.outer, "SHEET": content.stock}.get(layer, content.inner)
        if kind in ("LWPOLYLINE", "POLYLINE"):
            target.append(_closed(path, entity, layer))
        elif kind == "CIRCLE":
            x, y, r = entity.dxf.center.x, entity.dxf.center.y, entity.dxf.radius
            target.append(Contour(np.array([[x - r, y, 1.0], [x + r, y, 1.0]])))
        elif kind in ("LINE", "SPLINE") and layer == "CUT_OUTER":
            loose.append(entity)
        else:
            raise InputError(path.name, f"unexpected {kind} on layer {layer}")
    else:
        raise InputError(path.name, f"unexpected {kind} on layer {layer}")


def _vertices(entity: Any) -> Array:
    """Points and bulges (n, 3) of a polyline."""
    if entity.dxftype() == "LWPOLYLINE":
        points = list(entity.get_points("xyb"))
    else:
        points = [(v.dxf.location.x, v.dxf.location.y, v.dxf.bulge) for v in entity.vertices]
    return np.array(points).reshape(-1, 3)


def _closed(path: Path, entity: Any, layer: str) -> Contour:
    closed = entity.closed if entity.dxftype() == "LWPOLYLINE" else entity.is_closed
    vertices = _vertices(entity)
    if not closed and len(vertices) > 1:
        gap = float(np.linalg.norm(vertices[0, :2] - vertices[-1, :2]))
        raise InputError(
            path.name, f"open contour on layer {layer}: its ends are {gap:.3g} mm apart"
        )
    points = Contour(vertices).points(0.01) if len(vertices) > 1 else vertices
    if len(points) < 3:
        raise InputError(path.name, f"a contour on layer {layer} encloses nothing")
    contour, polygon = Contour(vertices), shapely.Polygon(points)
    if not polygon.is_valid:
        why = shapely.is_valid_reason(polygon)
        raise InputError(path.name, f"a contour on layer {layer} crosses itself: {why}")
    return contour


def _chained(path: Path, loose: list[Any]) -> list[Contour]:
    """Closed polygons from lines and splines, end to end in the order of the file."""
    contours, chain = [], np.empty((0, 2))
    for entity in loose:
        if entity.dxftype() == "LINE":
            points = np.array([entity.dxf.start, entity.dxf.end])[:, :2]
        else:
            points = np.array([(p.x, p.y) for p in entity.flattening(FLATTEN)])
        if len(chain) and np.linalg.norm(chain[-1] - points[0]) > JOIN:
            raise InputError(path.name, "open outline: a line or spline does not join the next")
        chain = np.concatenate([chain[:-1], points])
        if np.linalg.norm(chain[-1] - chain[0]) <= JOIN:
            contours.append(Contour(np.column_stack([chain[:-1], np.zeros(len(chain) - 1)])))
            chain = np.empty((0, 2))
    if len(chain):
        raise InputError(path.name, "open outline: the last line or spline does not close it")
    return contours


def _parts(path: Path, content: _Content) -> list[FilePart]:
    """Everything sorted by the outer contour that it lies in."""
    polygons = [shapely.Polygon(contour.points(0.01)) for contour in content.outer]
    tree = shapely.STRtree(polygons)

    def home(point: Array, what: str) -> int | None:
        found = [int(k) for k in tree.query(shapely.Point(point), predicate="intersects")]
        if len(found) > 1:
            raise InputError(path.name, f"{what} lies in {len(found)} outer contours")
        return found[0] if found else None

    marks: dict[int, list[str]] = {k: [] for k in range(len(polygons))}
    for text, at in content.texts:
        k = home(at, f"the text {text!r}")
        if k is not None:
            marks[k].append(text)
    inner: dict[int, list[Contour]] = {k: [] for k in marks}
    bends: dict[int, list[Array]] = {k: [] for k in marks}
    strokes: dict[int, list[Array]] = {k: [] for k in marks}
    for contour in content.inner:
        inner[_inside(path, home(contour.points(0.1).mean(axis=0), "a hole"), "a hole")] += [
            contour
        ]
    for bend in content.bends:
        bends[_inside(path, home(bend.mean(axis=0), "a bend line"), "a bend line")] += [bend]
    for stroke in content.strokes:
        strokes[_inside(path, home(stroke.mean(axis=0), "a stroke"), "a stroke")] += [stroke]
    for k, found in marks.items():
        if len(found) != 1:
            at = polygons[k].centroid
            raise InputError(
                path.name,
                f"the contour at ({at.x:.0f}, {at.y:.0f}) holds {len(found)} marks, expected one",
            )
    return [
        FilePart(
            marks[k][0],
            outer,
            tuple(inner[k]),
            np.array(bends[k]).reshape(-1, 2, 2),
            tuple(strokes[k]),
        )
        for k, outer in enumerate(content.outer)
    ]


def _inside(path: Path, index: int | None, what: str) -> int:
    if index is None:
        raise InputError(path.name, f"{what} lies outside of every outer contour")
    return index
