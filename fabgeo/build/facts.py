"""What is measured of each part by itself: side by side, and kept for the next build.

Glossary
--------
facts
    Numbers of one part that depend on its shape alone, neither on its neighbours nor on what it
    is made of.
batch
    Parts that are measured, and kept, together.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from fabgeo.arrays import Array, cross, dot
from fabgeo.build.cache import Cache
from fabgeo.build.geometry import Design
from fabgeo.build.identity import shape_of
from fabgeo.build.parallel import Work, results
from fabgeo.errors import PartError
from fabgeo.panels.flat import FlatPart
from fabgeo.panels.unfold_certificate import hermite_length
from fabgeo.review.display import shown_prism
from fabgeo.sheets.biarc import dense
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.beams import plate_radii
from fabgeo.structures.boxes import Box, oriented_box
from fabgeo.structures.parts import Beam, Cell, Plate
from fabgeo.structures.prisms import ruled_normals

BATCH = 32
HALVINGS, EXACT = 10, 1e-6  # of knot spans at most, mm that an edge's length may still change by
SIDES = ("first", "second", "start", "end")

_UP = np.array([0.0, 0.0, 1.0])
_NODES, _WEIGHTS = (np.asarray(x) for x in np.polynomial.legendre.leggauss(8))


@dataclass(frozen=True)
class Facts:
    """Facts of a part; of cells and beams there is the box alone.

    Attributes
    ----------
    box : Box
        The smallest oriented box around it as a solid.
    twist_deg : float
        Largest angle between a plate's normals at both ends of a ruling.
    developability_mm : float
        Largest distance of the diagonals of the quads of paper eq. (2).
    radii : tuple of float
        Least and largest bending radius, mm.
    lengths : mapping
        Of the edges by name, in space, mm.
    size : tuple of float
        Flat length and width, mm; empty where it is not unrolled.
    camber : float or None
        Largest rise of the flat part's first edge over its chord, mm.
    flat_lengths : tuple of (name, neighbour, length)
        Of the edges of the flat part.
    """

    box: Box
    twist_deg: float = 0.0
    developability_mm: float = 0.0
    radii: tuple[float, float] = (np.inf, np.inf)
    lengths: Mapping[str, float] = field(default_factory=dict)
    size: tuple[float, ...] = ()
    camber: float | None = None
    flat_lengths: tuple[tuple[str, str, float], ...] = ()


type _Part = tuple[Plate | Cell | Beam, FlatPart | None]


def facts_of(
    design: Design,
    flats: Mapping[str, FlatPart],
    jobs: int | None = None,
    cache: Cache | None = None,
) -> Iterator[tuple[str, Facts]]:
    """Marks and facts of all plates, cells and beams; other processes begin at once."""
    parts = [(p, flats.get(p.mark)) for p in (*design.plates, *design.cells, *design.beams)]
    batches = [parts[k : k + BATCH] for k in range(0, len(parts), BATCH)]
    found = results(_FACTS, batches, jobs, cache)
    return (
        (part.mark, Facts(**{**own, "box": Box(*own["box"])}))
        for batch, facts in zip(batches, found, strict=True)
        for (part, _), own in zip(batch, facts, strict=True)
    )


def _all_measured(batch: Sequence[_Part]) -> list[dict[str, Any]]:
    return [_plain(_measured(part, flat)) for part, flat in batch]


def _plain(facts: Facts) -> dict[str, Any]:
    own = {f.name: getattr(facts, f.name) for f in fields(facts)}
    return {**own, "box": (facts.box.size, facts.box.axes, facts.box.centre)}


def _measured(part: Plate | Cell | Beam, flat: FlatPart | None) -> Facts:
    if isinstance(part, Cell):
        rails = shown_prism(part.prism, "cells", _UP, count=33).rails
        return Facts(oriented_box(rails.reshape(-1, 3)))
    if isinstance(part, Beam):
        return Facts(oriented_box(np.concatenate([corners_of(plate) for plate in part.plates])))
    return Facts(
        oriented_box(corners_of(part)),
        twist_of(part),
        developability(part),
        plate_radii(part.mid),
        dict(zip(SIDES, edge_lengths(part.mid), strict=True)),
        *(() if flat is None else _of_flat(flat)),
    )


def _of_flat(flat: FlatPart) -> tuple[Any, ...]:
    lines = [dense(edge)[0] for edge in flat.outline]
    length, width = np.ptp(np.concatenate(lines), axis=0).tolist()
    first = next((k for k, edge in enumerate(flat.outline) if edge.name == "first"), 0)
    edges = tuple((e.name, e.shared, float(hermite_length(e))) for e in flat.outline)
    return (length, width), _rise(lines[first]), edges


def _depends(batch: Sequence[_Part]) -> Any:
    return [(_shape(part), flat and shape_of(flat)) for part, flat in batch]


def _shape(part: Plate | Cell | Beam) -> Any:
    return list(map(shape_of, part.plates)) if isinstance(part, Beam) else shape_of(part)


def _crashed(batch: Sequence[_Part], reason: str) -> list[dict[str, Any]]:
    raise PartError(batch[0][0].mark, f"or one of the next could not be measured: {reason}")


_FACTS = Work("facts", _all_measured, _depends, _crashed)


def twist_of(plate: Plate) -> float:
    """Largest angle in degrees between a plate's normals at both ends of a ruling."""
    u = plate.mid.parameters(4)
    a, b = plate.mid.edges(u)
    da, db = plate.mid.edges(u, 1)
    m0, m1 = (cross(d, b - a) for d in (da, db))
    sine = np.linalg.norm(cross(m0, m1), axis=-1)
    return float(np.degrees(np.arctan2(sine, dot(m0, m1)).max()))


def edge_lengths(mid: RuledPatch) -> tuple[float, float, float, float]:
    """Lengths in mm of the edges first, second, start and end.

    By Gauss quadrature over knot spans, halved until nothing changes: a cut edge that comes close
    to the rulings' direction is steep in the parameter.
    """
    spans, lengths = np.unique(mid.knots), np.zeros(2)
    for _ in range(HALVINGS):
        half = np.diff(spans)[:, None] / 2.0
        u = (spans[:-1, None] + half * (_NODES + 1.0)).ravel()
        speed = np.linalg.norm(mid.edges(u, 1), axis=-1)
        before, lengths = lengths, speed @ (half * _WEIGHTS).ravel()
        if np.abs(lengths - before).max() < EXACT:
            break
        spans = np.union1d(spans, (spans[1:] + spans[:-1]) / 2.0)
    first, second = lengths
    a, b = mid.edges(np.array([mid.u0, mid.u1]))
    start, end = np.linalg.norm(b - a, axis=-1)
    return float(first), float(second), float(start), float(end)


def corners_of(plate: Plate) -> Array:
    """Points on both skins, (k, 3)."""
    u = np.linspace(plate.mid.u0, plate.mid.u1, 9)
    half = plate.thickness / 2.0 * ruled_normals(plate.mid, u)
    edges = plate.mid.edges(u)
    return np.concatenate([edges - half, edges + half]).reshape(-1, 3)


def developability(plate: Plate) -> float:
    """Largest distance in mm of the diagonals of the quads of paper eq. (2)."""
    u = plate.mid.parameters(4)
    a, b = plate.mid.edges(u)
    ta, tb = (d / np.linalg.norm(d, axis=-1, keepdims=True) for d in plate.mid.edges(u, 1))
    length = np.linalg.norm(b - a, axis=-1)
    e = (b - a) / length[:, None]
    volume = np.abs(np.einsum("ki,ki->k", cross(ta, tb), e))
    base = np.linalg.norm(cross(e + tb, e - ta), axis=-1)
    return float((length * volume / np.maximum(base, 1e-300)).max())


def _rise(points: Array) -> float:
    """Largest distance of a line's points (k, 2) from its chord."""
    chord, away = points[-1] - points[0], points - points[0]
    rise = away[:, 1] * chord[0] - away[:, 0] * chord[1]
    return float(np.abs(rise).max() / np.linalg.norm(chord))
