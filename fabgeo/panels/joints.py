"""Where two panels meet: gap and kink between them as they will be made.

Glossary
--------
joint
    The common piece of two panels' boundaries: an edge curve's interval, or an end ruling.
gap
    Distance between the two made panels at the same point of the fitted joint.
own kink
    Rotation that carries the first fitted panel's normal to the second's, as a rotation vector.
added kink
    Length of the difference between the made panels' rotation vector and the own one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, BoolArray, IntArray, dot, unit
from fabgeo.errors import InputError
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.samples import PanelInput, Side

_OPPOSITE: dict[str, Side] = {"first": "second", "second": "first", "start": "end", "end": "start"}
_SAMPLES = 9
APART = 5.0
"""mm: so far apart neighbours' boundaries may lie however short a piece of them is.

Above a general model edges of neighbouring panels do not quite meet.
"""


def _halfway(count: int) -> Array:
    """Values halfway between even samples, of the cubics through four (parabolas at both ends)."""
    out = np.zeros((count - 1, count))
    for k in range(1, count - 2):
        out[k, k - 1 : k + 3] = np.array([-1.0, 9.0, 9.0, -1.0]) / 16.0
    out[0, :3] = np.array([3.0, 6.0, -1.0]) / 8.0
    out[-1, -3:] = np.array([-1.0, 6.0, 3.0]) / 8.0
    return out


_BETWEEN = _halfway(_SAMPLES)


@dataclass(frozen=True)
class Joints:
    """All joints of a set of panels, each once.

    Attributes
    ----------
    panels : (j, 2) int array
        Indices of the two panels.
    sides : tuple of (Side, Side)
    points : (j, s, 3) array
        Samples of the fitted joint.
    normals : (2, j, s, 3) array
        The fitted panels' unit normals there.
    ends : (j,) bool array
        Whether the joint is an end ruling.
    """

    panels: IntArray
    sides: tuple[tuple[Side, Side], ...]
    points: Array
    normals: Array
    ends: BoolArray

    def __len__(self) -> int:
        return len(self.panels)

    @property
    def own(self) -> Array:
        """Own kink (j, s, 3) as rotation vectors."""
        return rotation(self.normals[0], self.normals[1])


def joints_of(panels: Sequence[PanelInput]) -> Joints:
    """The joints that the panels' neighbours name.

    Raises
    ------
    InputError
        If a neighbour is unknown, or its boundary is not where the panel's is.
    """
    index = {panel.mark: i for i, panel in enumerate(panels)}
    if len(index) != len(panels):
        raise InputError("panels", "two panels have the same mark")
    found: dict[tuple[int, int, str], tuple[_Boundary, _Boundary]] = {}
    samples: dict[tuple[int, float, float], tuple[Array, Array]] = {}
    for i, panel in enumerate(panels):
        for side in panel.neighbours:
            for mark in panel.beyond(side):
                if mark not in index:
                    raise InputError(
                        f"panel {panel.mark}", f"names a neighbour {mark} that is not given"
                    )
                j = index[mark]
                low = i < j or (i == j and side in ("second", "end"))
                key = (i, j, side) if low else (j, i, _OPPOSITE[side])
                if key not in found:
                    found[key] = _joint(panels, samples, *key)
    if not found:
        none = np.zeros((0, _SAMPLES, 3))
        no = np.zeros(0, dtype=bool)
        return Joints(np.zeros((0, 2), dtype=np.int64), (), none, np.stack([none, none]), no)
    (points, normals), (_, others) = (
        _evaluated([pair[side] for pair in found.values()]) for side in (0, 1)
    )
    sides: list[tuple[Side, Side]] = [(_OPPOSITE[_OPPOSITE[k[2]]], _OPPOSITE[k[2]]) for k in found]
    ends = np.array([k[2] in ("start", "end") for k in found])
    pairs = np.array([k[:2] for k in found], dtype=np.int64)
    return Joints(pairs, tuple(sides), points, np.stack([normals, others]), ends)


type _Boundary = tuple[Array, Array, Array]  # points, speeds, rulings


def _evaluated(boundaries: Sequence[_Boundary]) -> tuple[Array, Array]:
    """Points and unit normals (j, s, 3)."""
    points, speeds = (np.array([b[k] for b in boundaries]) for k in (0, 1))
    rulings = np.array([np.broadcast_to(b[2], b[0].shape) for b in boundaries])
    return points, unit(np.cross(speeds, rulings))


def _joint(
    panels: Sequence[PanelInput],
    samples: dict[tuple[int, float, float], tuple[Array, Array]],
    i: int,
    j: int,
    side: str,
) -> tuple[_Boundary, _Boundary]:
    """What the boundary of both panels is worked out from, evaluated once a panel."""
    one, other = panels[i].patch, panels[j].patch
    if side in ("start", "end"):
        spans = ((one.u0, one.u1), (other.u0, other.u1))
    else:
        spans = ((max(one.u0, other.u0), min(one.u1, other.u1)),) * 2
    out: list[_Boundary] = []
    for p, span, at in ((i, spans[0], side), (j, spans[1], _OPPOSITE[side])):
        key = (p, *span)
        if key not in samples:
            u = np.linspace(*span, _SAMPLES)
            samples[key] = (panels[p].patch.edges(u), panels[p].patch.edges(u, 1))
        edges, speeds = samples[key]
        if at in ("start", "end"):
            row = 0 if at == "start" else -1
            v = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
            (a, b), (da, db) = edges[:, row], speeds[:, row]
            out.append((a + v * (b - a), da + v * (db - da), (b - a)[None]))
        else:
            row = 0 if at == "first" else 1
            out.append((edges[row], speeds[row], edges[1] - edges[0]))
    here, there = out[0][0], out[1][0]
    off = float(np.abs(here - there).max())
    size = float(np.abs(here[-1] - here[0]).max())
    if off > max(1e-3 * size, APART):
        raise InputError(
            f"panel {panels[i].mark}",
            f"its side '{side}' lies {off:.3g} mm from side '{_OPPOSITE[side]}' of its "
            f"neighbour {panels[j].mark}",
            "name as neighbours only panels that share this boundary",
        )
    return out[0], out[1]


def rotation(first: Array, second: Array) -> Array:
    """Rotation vectors (..., 3) that carry unit vectors to unit vectors."""
    cross = np.cross(first, second)
    sine = np.linalg.norm(cross, axis=-1)
    angle = np.arctan2(sine, dot(first, second))
    return cross * (angle / np.where(sine > 0.0, sine, 1.0))[..., None]


def turned(vectors: Array, rotations: Array) -> Array:
    """Vectors turned by rotation vectors, both (..., 3) (Rodrigues)."""
    angle = np.linalg.norm(rotations, axis=-1, keepdims=True)
    axis = unit(rotations)
    along = dot(axis, vectors)[..., None]
    return (
        np.cos(angle) * vectors
        + np.sin(angle) * np.cross(axis, vectors)
        + (1.0 - np.cos(angle)) * along * axis
    )


def made_boundary(
    carriers: Carriers,
    replaced: BoolArray,
    points: Array,
    normals: Array,
    ends: BoolArray,
) -> tuple[Array, Array]:
    """Points and unit normals (c, s, 3) of made panels at fitted joints, one carrier a joint.

    On an edge: the projection. On an end: the line that `as_made` draws there. Panels that are
    not replaced stay as fitted.
    """
    feet, normal = carriers.project(points), carriers.normal(points)
    swung = np.flatnonzero(ends & replaced & (carriers.k != 0.0))
    if len(swung):
        bent = carriers[swung]
        turn, reach = bent.coordinates(points[swung][:, [0, -1]])
        corner = bent.at(np.broadcast_to(turn.mean(axis=1, keepdims=True), reach.shape), reach)
        v = np.linspace(0.0, 1.0, points.shape[1])[:, None]
        feet[swung] = corner[:, :1] + v * (corner[:, 1:] - corner[:, :1])
        normal[swung] = bent.normal(feet[swung])
    keep = replaced[:, None, None]
    return np.where(keep, feet, points), np.where(keep, normal, normals)


def compare(
    first: tuple[Array, Array], second: tuple[Array, Array], own: Array
) -> tuple[Array, Array]:
    """Largest gap and largest added kink in radians, (c,) each."""
    off = first[0] - second[0]
    gap = np.linalg.norm(np.concatenate([off, _BETWEEN @ off], axis=-2), axis=-1).max(axis=-1)
    added = rotation(first[1], second[1]) - own
    return gap, np.linalg.norm(added, axis=-1).max(axis=-1)
