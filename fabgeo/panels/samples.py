"""Panels as they come from the strip model, and their samples as one batch of arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from scipy.interpolate import BSpline

from fabgeo.arrays import Array, BoolArray, IntArray, cross, dot, unit
from fabgeo.errors import InputError
from fabgeo.strips.ruled import RuledPatch

type Side = Literal["first", "second", "start", "end"]
SIDES: tuple[str, ...] = get_args(Side.__value__)


@dataclass(frozen=True)
class PanelInput:
    """A fitted panel and who lies next to it.

    Attributes
    ----------
    mark : str
        ``P-03-07``.
    patch : RuledPatch
        The developable patch of the strip model, as trimmed, in mm.
    neighbours : mapping
        Side ("first", "second": edge curves a and b; "start", "end": end rulings) to the mark of
        the panel beyond it, or to several marks where cells are staggered. A missing side: none.
    """

    mark: str
    patch: RuledPatch
    neighbours: Mapping[Side, str | tuple[str, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        unknown = set(self.neighbours) - set(SIDES)
        if unknown:
            raise InputError(
                f"panel {self.mark}", f"has neighbours at unknown sides {sorted(unknown)}"
            )

    def beyond(self, side: Side) -> tuple[str, ...]:
        """Marks of the neighbours at a side."""
        found = self.neighbours.get(side, ())
        return (found,) if isinstance(found, str) else tuple(found)


@dataclass(frozen=True)
class Samples:
    """Samples of many patches at the same fractions of their parameter intervals.

    Attributes
    ----------
    t : (s,) array
        Fractions of [u0, u1], both ends included, evenly spaced.
    edges : (3, p, s, 2, 3) array
        Edge curves (first, second) and their derivatives by t to the second order.
    third : (p,) array
        The largest third derivative by t over all knot spans of both edge curves.
    """

    t: Array
    edges: Array
    third: Array

    def __len__(self) -> int:
        return self.edges.shape[1]

    def __getitem__(self, index: IntArray | BoolArray | slice) -> Samples:
        return Samples(self.t, self.edges[:, index], self.third[index])

    def thinned(self) -> Samples:
        """Every other sample."""
        return Samples(self.t[::2], self.edges[:, :, ::2], self.third)

    def points(self, v: Array, order: int = 0) -> Array:
        """Surface points, or t-derivatives, (p, s, len(v), 3) at ruling fractions v."""
        a, b = self.edges[order, :, :, 0], self.edges[order, :, :, 1]
        return a[:, :, None] + np.asarray(v)[:, None] * (b - a)[:, :, None]

    @property
    def rulings(self) -> Array:
        """Unit rulings (p, s, 3) from the first edge to the second."""
        return unit(self.edges[0, :, :, 1] - self.edges[0, :, :, 0])

    def normals(self, v: float = 0.5) -> Array:
        """Unit normals x_u x x_v (p, s, 3) at one ruling fraction."""
        speed = (1.0 - v) * self.edges[1, :, :, 0] + v * self.edges[1, :, :, 1]
        return unit(cross(speed, self.rulings))

    @property
    def size(self) -> Array:
        """Half the mean of the extents along and across the rulings, (p,)."""
        middle = self.points(np.array([0.5]))[:, :, 0]
        arc = np.linalg.norm(np.diff(middle, axis=1), axis=-1).sum(axis=1)
        length = np.linalg.norm(self.edges[0, :, :, 1] - self.edges[0, :, :, 0], axis=-1)
        return 0.25 * (arc + length.mean(axis=1))


def sample(patches: Sequence[RuledPatch], count: int = 17) -> Samples:
    """Sample patches at `count` evenly spaced fractions of their parameter intervals."""
    t = np.linspace(0.0, 1.0, count)
    edges = np.empty((3, len(patches), count, 2, 3))
    third = np.empty(len(patches))
    for p, patch in enumerate(patches):
        span = patch.u1 - patch.u0
        poles = np.moveaxis(patch.poles, 1, 0).reshape(-1, 6)
        curve = BSpline(patch.knots, poles, 3)
        for order in range(3):
            edges[order, p] = curve(patch.u0 + span * t, order).reshape(-1, 2, 3) * span**order
        spans = np.unique(patch.knots)
        middle = np.asarray(curve((spans[1:] + spans[:-1]) / 2.0, 3)).reshape(-1, 2, 3)
        third[p] = np.linalg.norm(middle, axis=-1).max() * span**3
    return Samples(t, edges, third)


def turning(samples: Samples) -> tuple[Array, Array, Array]:
    """What the Gauss image says: arcs across the rulings and both turnings along them.

    Returns
    -------
    arc : (p, s) array
        Distance across the rulings, along the middle of the patch, from its middle ruling.
    bend : (p, s) array
        Angle the normal has turned about the rulings: the length of the Gauss image's arc. A
        point: a plane.
    swing : (p, s) array
        Angle the rulings have turned within the surface: none where the image is an arc of a
        great circle (cylinder), proportional to `bend` on a small circle (cone).
    """
    rulings, normals = samples.rulings, samples.normals()
    across = cross(normals, rulings)  # along m = n x a
    middle = samples.points(np.array([0.5]))[:, :, 0]

    def between(values: Array) -> Array:
        return unit(values[:, 1:] + values[:, :-1])

    step = dot(np.diff(middle, axis=1), between(across))
    bend = np.arcsin(np.clip(dot(np.diff(normals, axis=1), between(across)) / 2.0, -1, 1)) * 2.0
    swing = np.arcsin(np.clip(dot(np.diff(rulings, axis=1), between(across)) / 2.0, -1, 1)) * 2.0
    sums = []
    for values in (step, bend, swing):
        total = np.concatenate([np.zeros((len(samples), 1)), np.cumsum(values, axis=1)], axis=1)
        sums.append(total - total[:, total.shape[1] // 2, None])
    return sums[0], sums[1], sums[2]


def boundary_tilt(samples: Samples) -> tuple[Array, Array]:
    """Boundary points (p, b, 3) and unit directions within the patch, out of it across the joint.

    A carrier's normal has no component along these directions where it does not tilt about the
    joint: along the edges every other sample, on both end rulings their two ends.
    """
    rulings = samples.rulings
    points, along = [], []
    for side, sign in ((0, -1.0), (1, 1.0)):
        speed = unit(samples.edges[1, :, ::2, side])
        normal = unit(cross(speed, rulings[:, ::2]))
        points.append(samples.edges[0, :, ::2, side])
        along.append(sign * cross(normal, speed))
    for row, sign in ((0, -1.0), (-1, 1.0)):
        normal = samples.normals()[:, row]
        across = sign * cross(normal, rulings[:, row])
        points.append(samples.edges[0, :, row])
        along.append(np.repeat(across[:, None], 2, axis=1))
    return np.concatenate(points, axis=1), np.concatenate(along, axis=1)


def end_swing(samples: Samples) -> tuple[Array, Array, Array]:
    """Middles of both end rulings and unit directions across them (p, 2, 3), half lengths (p, 2).

    A carrier's rulings have no component along these directions where a made panel's ends run
    with the fitted ones: else neighbours of one strip leave a wedge.
    """
    ends = samples.edges[0][:, [0, -1]]
    across = cross(samples.normals()[:, [0, -1]], samples.rulings[:, [0, -1]])
    half = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=-1) / 2.0
    return ends.mean(axis=2), across, half
