"""Planks and boards for geodesic strips (paper Fig. 4): the grain runs along the strip.

Glossary
--------
plank
    The smallest rectangle that a part can be cut from.
board
    Stock of a given width and length; the grain along its length.
congruence
    How far two developed edges are from oppositely congruent: the same curve turned over, so that
    neighbouring planks of a geodesic model lie edge to edge.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import GeometryError
from fabgeo.panels.flat import FlatEdge, FlatPart
from fabgeo.panels.unfold import smallest_rectangle
from fabgeo.sheets.biarc import dense
from fabgeo.sheets.nest import Listener, nest
from fabgeo.sheets.stock import Nest, Stock

Common = tuple[tuple[float, float], tuple[float, float]]
WHOLE: Common = ((0.0, 1.0), (0.0, 1.0))


@dataclass(frozen=True)
class Plank:
    """What a strip is cut from.

    Attributes
    ----------
    mark : str
    length, width : float
        mm, of the smallest rectangle.
    sag : float
        mm: how far the strip's middle line bends off its chord; 0 for a straight strip.
    yield_ : float
        Area of the part over the rectangle's.
    """

    mark: str
    length: float
    width: float
    sag: float
    yield_: float


def plank(part: FlatPart) -> Plank:
    """Return the smallest rectangle of a part, and how straight the part is."""
    points = np.concatenate([dense(edge)[0] for edge in part.outline])
    _, length, width = smallest_rectangle(points)
    first, second = (resampled(_edge(part, name)) for name in ("first", "second"))
    middle = (first + second[::-1]) / 2.0
    chord = middle[-1] - middle[0]
    offset = middle - middle[0]
    sag = np.abs(offset[:, 0] * chord[1] - offset[:, 1] * chord[0]).max() / np.linalg.norm(chord)
    return Plank(part.mark, length, width, float(sag), part.area / (length * width))


def _edge(part: FlatPart, name: str) -> FlatEdge:
    for edge in part.outline:
        if edge.name == name:
            return edge
    raise GeometryError(
        f"part {part.mark}", f"has no edge named {name!r}", "unfold it from a strip"
    )


def resampled(edge: FlatEdge, count: int = 65, part: tuple[float, float] = (0.0, 1.0)) -> Array:
    """Points (count, 2) at equal arc lengths along the edge, or along a part of its length."""
    points, _ = dense(edge, 16)
    way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=-1)))
    at = way[-1] * np.linspace(*part, count)
    return np.column_stack([np.interp(at, way, points[:, k]) for k in range(2)])


def congruence(edge: FlatEdge, neighbour: FlatEdge, common: Common = WHOLE) -> float:
    """Largest distance, in mm, of two developed edges after the best motion without mirroring.

    Both outlines run counter-clockwise, so a common edge is run in opposite senses; the developed
    edges of a geodesic model then coincide when the parts are laid side by side. Where one part is
    cut shorter, `common` is what both have of the edge, as parts of each one's length.
    """
    p, q = resampled(edge, part=common[0]), resampled(neighbour, part=common[1])[::-1]
    pc, qc = p - p.mean(axis=0), q - q.mean(axis=0)
    sine = float(np.sum(pc[:, 0] * qc[:, 1] - pc[:, 1] * qc[:, 0]))
    angle = np.arctan2(sine, float(np.sum(pc * qc)))
    c, s = np.cos(angle), np.sin(angle)
    return float(np.linalg.norm(pc @ np.array([[c, s], [-s, c]]) - qc, axis=-1).max())


def opposite_congruence(edge: FlatEdge, neighbour: FlatEdge, common: Common = WHOLE) -> float:
    """Largest distance, in mm, of two developed edges from being congruent when one is mirrored.

    In a geodesic model the osculating planes of an edge bisect its strips: developed, the edge
    bends as much to the one side as to the other (paper Fig. 4).
    """
    turned = np.array([1.0, -1.0])
    mirrored = replace(
        neighbour, points=neighbour.points * turned, tangents=neighbour.tangents * turned
    )
    return congruence(edge, mirrored, common)


def cut_boards(
    parts: Sequence[FlatPart],
    boards: Sequence[Stock],
    spacing: float = 4.0,
    margin: float = 0.0,
    seconds: float = 10.0,
    seed: int = 0,
    steps: int | None = None,
    listener: Listener | None = None,
    quantities: Mapping[str, int] | None = None,
) -> list[Nest]:
    """Nest parts on boards with the grain along every part: turned by 0 or 180 degrees only."""
    along = [replace(part, grain="along") for part in parts]
    return nest(
        along,
        boards,
        spacing,
        margin,
        seconds=seconds,
        seed=seed,
        steps=steps,
        listener=listener,
        quantities=quantities,
    )
