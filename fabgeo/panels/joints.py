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
from fabgeo.strips.ruled import RuledPatch

_OPPOSITE: dict[str, Side] = {"first": "second", "second": "first", "start": "end", "end": "start"}
_SAMPLES = 9


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
    found: dict[tuple[int, int, str], tuple[Side, Side, Array, Array, Array]] = {}
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
                    found[key] = _joint(panels[key[0]], panels[key[1]], key[2])
    values = list(found.values())
    none = np.zeros((0, _SAMPLES, 3))
    return Joints(
        np.array([k[:2] for k in found], dtype=np.int64).reshape(-1, 2),
        tuple((v[0], v[1]) for v in values),
        np.array([v[2] for v in values]) if values else none,
        np.stack([[v[3] for v in values], [v[4] for v in values]])
        if values
        else np.stack([none, none]),
        np.array([v[0] in ("start", "end") for v in values], dtype=bool),
    )


def _joint(one: PanelInput, other: PanelInput, side: str) -> tuple[Side, Side, Array, Array, Array]:
    across = _OPPOSITE[side]
    if side in ("start", "end"):
        points, normal = _end(one.patch, side)
        there, normal_there = _end(other.patch, across)
    else:
        u0, u1 = max(one.patch.u0, other.patch.u0), min(one.patch.u1, other.patch.u1)
        u = np.linspace(u0, u1, _SAMPLES)
        points, normal = _edge(one.patch, side, u)
        there, normal_there = _edge(other.patch, across, u)
    off = float(np.linalg.norm(points - there, axis=-1).max())
    size = float(np.linalg.norm(points[-1] - points[0]))
    if off > 1e-3 * max(size, 1.0):
        raise InputError(
            f"panel {one.mark}",
            f"its side '{side}' lies {off:.3g} mm from side '{across}' of its neighbour "
            f"{other.mark}",
            "name as neighbours only panels that share this boundary",
        )
    return _OPPOSITE[across], across, points, normal, normal_there


def _end(patch: RuledPatch, side: str) -> tuple[Array, Array]:
    u = np.full(_SAMPLES, patch.u0 if side == "start" else patch.u1)
    v = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    (a, b), (da, db) = patch.edges(u), patch.edges(u, 1)
    return a + v * (b - a), unit(np.cross(da + v * (db - da), b - a))


def _edge(patch: RuledPatch, side: str, u: Array) -> tuple[Array, Array]:
    row = 0 if side == "first" else 1
    points, speed = patch.edges(u), patch.edges(u, 1)
    return points[row], unit(np.cross(speed[row], points[1] - points[0]))


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
    skew: Array,
) -> tuple[Array, Array]:
    """Points and unit normals (c, s, 3) of made panels at fitted joints, one carrier a joint.

    On an edge: the projection. On an end: the line that `as_made` draws there. Panels that are
    not replaced stay as fitted.
    """
    feet, normal = carriers.project(points), carriers.normal(points)
    turn, reach = carriers.coordinates(points[:, [0, -1]])
    mean = turn.mean(axis=1, keepdims=True)
    turn = mean + skew[:, None] * (turn - mean)
    corner = carriers.at(turn, reach)
    v = np.linspace(0.0, 1.0, points.shape[1])[:, None]
    line = corner[:, :1] + v * (corner[:, 1:] - corner[:, :1])
    swung = (ends & replaced & (carriers.k != 0.0))[:, None, None]
    feet = np.where(swung, line, feet)
    normal = np.where(swung, carriers.normal(np.where(swung, line, points)), normal)
    keep = replaced[:, None, None]
    return np.where(keep, feet, points), np.where(keep, normal, normals)


def compare(
    first: tuple[Array, Array], second: tuple[Array, Array], own: Array
) -> tuple[Array, Array]:
    """Largest gap and largest added kink in radians, (c,) each."""
    gap = np.linalg.norm(first[0] - second[0], axis=-1).max(axis=-1)
    added = rotation(first[1], second[1]) - own
    return gap, np.linalg.norm(added, axis=-1).max(axis=-1)
