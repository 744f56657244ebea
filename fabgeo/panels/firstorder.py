"""What panels can be made as, to first order about their best placements.

Glossary
--------
option
    One class for every panel, with the small steps that its placement may make about a base.
feature
    A number measured on a panel or at a joint in units of its limit: distances between fitted and
    made panel; at joints what the made boundary is off the fitted one in five directions, and what
    its normal tilts across the joint. A joint keeps its limits where the features of both panels
    differ by at most one (a polygon about the gap's circle; of the kink its part about the joint).

Placements move by millimetres on panels of metres, so that features are linear in the steps to
about a thousandth of their limits; `fabgeo.panels.programme` relies on it and measures it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, BoolArray, IntArray, dot, unit
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.joints import Joints, made_boundary
from fabgeo.panels.limits import Tolerances
from fabgeo.panels.made import end_shift
from fabgeo.panels.samples import Samples

_AT = np.array([0, 2, 4, 6, 8])  # of the joints' nine samples
_DIRECTIONS = np.pi / 8.0 * np.arange(8)  # in the plane across a joint: 16 sides about a circle
ENDS = 4  # features of a panel's own that are shifts of its ends: the last ones
_STEPS = 6  # a shift, three rotations, k and g: see Carriers.derivatives
_FAR = 1e4  # steps of about a millimetre that none goes beyond
FREE = {
    "flat": np.arange(3),
    "cylinder": np.arange(5),
    "cone": np.arange(6),
    "rolled": np.arange(4),  # a cylinder of given radius
}


class Boundaries:
    """Features of made panels at joints.

    Parameters
    ----------
    joints, tolerances
        The joints, and the limits that features are measured in.

    Attributes
    ----------
    few : (n,) int array
        Some of the features: enough for a bound, where fewer rows solve sooner.
    """

    def __init__(self, joints: Joints, tolerances: Tolerances) -> None:
        self.joints, self.tolerances = joints, tolerances
        number = np.arange(len(_AT) * (len(_DIRECTIONS) + 2)).reshape(len(_AT), -1)
        self.few: IntArray = number[::2, [0, 2, 4, 6, -1]].ravel()
        along = unit(np.gradient(joints.points, axis=1)) if len(joints) else joints.points
        normal = joints.normals[0]
        across = np.cross(along, normal)
        around = [np.cos(a) * normal + np.sin(a) * across for a in _DIRECTIONS]
        self._directions = np.stack([*around, along], axis=2)[:, _AT]
        self._tilt = np.cross(along, joints.normals)[:, :, _AT]

    def features(self, side: int, joint: IntArray, carriers: Carriers, made: BoolArray) -> Array:
        """Features (n, f) of carriers (one a joint) on one side of joints; zero if not `made`."""
        joints = self.joints
        fitted, normals = joints.points[joint][:, _AT], joints.normals[side, joint][:, _AT]
        points, normals = made_boundary(carriers, made, fitted, normals, joints.ends[joint])
        off = points - fitted
        gap = np.einsum("jsdk,jsk->jsd", self._directions[joint], off) / self.tolerances.gap_mm
        tilt = dot(normals, self._tilt[side, joint]) / self.tolerances.kink
        both = np.concatenate([gap, tilt[..., None]], axis=-1)
        return both.reshape(len(joint), both.shape[1] * both.shape[2])


@dataclass(frozen=True)
class Option:
    """One class of every panel, to first order.

    Attributes
    ----------
    kind : int
        Index into CLASSES.
    base : Carriers
        Placements, one a panel.
    able : (p,) bool array
        Whether the panel may take this option.
    unit : (p, 6) array
        Steps of a carrier that move it by about a millimetre.
    free : (f,) int array
        Which of the six steps the class may make.
    mixed : (p, f, f) array
        Those, in parts of `unit`, that steps of one make: combined so that the panel's own features
        change orthonormally. Programmes whose columns are alike solve without trouble.
    reach : (p, f) array
        Absolute column sums of those changes: a step is as large as the largest change of an own
        feature times this at most.
    value, slope : (p, s) and (p, s, f) arrays
        Features of the panels: distances to the fitted one, shifts of their ends; zero of those
        that are not able, as at their joints.
    edge, edge_slope : pairs of (j, m) and (j, m, f) arrays
        Features at every joint, for its first and its second panel.
    few : (n,) int array
        Those of them that an integer programme looks at.
    """

    kind: int
    base: Carriers
    able: BoolArray
    unit: Array
    free: IntArray
    mixed: Array
    reach: Array
    value: Array
    slope: Array
    edge: tuple[Array, Array]
    edge_slope: tuple[Array, Array]
    few: IntArray

    @property
    def count(self) -> int:
        """Number of steps."""
        return len(self.free)

    def placed(self, panel: IntArray, steps: Array) -> Carriers:
        """Carriers of some panels after steps (n, f)."""
        full = np.zeros((len(panel), _STEPS))
        full[:, self.free] = np.einsum("pij,pj->pi", self.mixed[panel], steps)
        return self.base[panel].moved(full * self.unit[panel])


def option_of(
    kind: int,
    name: str,
    base: Carriers,
    able: BoolArray,
    samples: Samples,
    boundaries: Boundaries,
) -> Option:
    """An option about given placements; `name` says which steps are free.

    Derivatives of distances are exact, those of features at ends and joints central differences
    over steps of about a millimetre.
    """
    tolerances, free, joints = boundaries.tolerances, FREE[name], boundaries.joints
    one, size = np.ones(len(samples)), samples.size
    unit_step = np.stack([one, 1 / size, 1 / size, 1 / size, 1 / size**2, 1 / size**2], axis=1)
    index = np.flatnonzero(able)
    # Distances change nearly linearly along a ruling: both edges will do, every other sample.
    points = samples[index].points(np.array([0.0, 1.0]))[:, ::2]
    points = points.reshape(len(index), 2 * points.shape[1], 3)
    distance, slope = base[index].derivatives(points)
    limit = min(tolerances.deviation_mm, tolerances.flange)

    moves = np.eye(_STEPS)[free] * unit_step[:, None]

    def shifts(carriers: Carriers, which: IntArray) -> Array:
        ends = end_shift(samples[index[which]], carriers).reshape(len(which), ENDS)
        return ends / tolerances.ends_mm

    ends, by_ends = _sloped(shifts, base[index], moves[index])
    near = (slope * unit_step[index][:, None])[..., free] / limit
    own = np.concatenate([near, by_ends], axis=1)
    mixed, reach = _orthonormal(own)
    count = len(samples)
    every = _spread(mixed, index, count)
    edges, by_edges = [], []
    for side in (0, 1):
        joint = np.flatnonzero(able[joints.panels[:, side]])
        panel = joints.panels[joint, side]

        def met(carriers: Carriers, which: IntArray, s: int = side, j: IntArray = joint) -> Array:
            return boundaries.features(s, j[which], carriers, np.ones(len(which), dtype=bool))

        edge, by_edge = _sloped(met, base[panel], moves[panel])
        edges.append(_spread(edge, joint, len(joints)))
        by_edges.append(_spread(by_edge @ every[panel], joint, len(joints)))
    return Option(
        kind,
        base,
        able,
        unit_step,
        free,
        every,
        _spread(reach, index, count),
        _spread(np.concatenate([distance / limit, ends], axis=1), index, count),
        _spread(own @ mixed, index, count),
        (edges[0], edges[1]),
        (by_edges[0], by_edges[1]),
        boundaries.few,
    )


def _sloped(
    features: Callable[[Carriers, IntArray], Array], base: Carriers, moves: Array
) -> tuple[Array, Array]:
    """Features (n, m) of carriers, and by central differences what moves (n, f, 6) make of them.

    `features` is asked once, for all carriers, moved or not: with which of the n each one is.
    """
    count, free = moves.shape[:2]
    moved = np.concatenate([np.zeros((count, 1, _STEPS)), moves, -moves], axis=1)
    which = np.repeat(np.arange(count), 1 + 2 * free)
    found = features(base[which].moved(moved.reshape(-1, _STEPS)), which)
    found = found.reshape(count, 1 + 2 * free, found.shape[-1])
    slopes = (found[:, 1 : 1 + free] - found[:, 1 + free :]) / 2.0
    return found[:, 0], slopes.transpose(0, 2, 1)


def _orthonormal(slope: Array) -> tuple[Array, Array]:
    """Combinations (p, f, f) of columns (p, m, f) that are orthonormal, and column sums (p, f).

    What hardly changes any feature counts by `_FAR` instead: of that no step makes more.
    """
    count, steps = slope.shape[0], slope.shape[2]
    border = np.broadcast_to(np.eye(steps) / _FAR, (count, steps, steps))
    columns, mixed = np.linalg.qr(np.concatenate([slope, border], axis=1))
    return np.linalg.inv(mixed), np.abs(columns).sum(axis=1)


def _spread(values: Array, index: IntArray, count: int) -> Array:
    """Rows put where they belong among `count`, zero elsewhere."""
    out = np.zeros((count, *values.shape[1:]))
    out[index] = values
    return out
