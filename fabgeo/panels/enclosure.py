"""What panels can be made as, with a proven bound of what their features are off linear ones.

Glossary
--------
box
    The placements of one class of one panel about its closest one that are looked at: steps in
    coordinates in which distances are orthogonal, each up to its half width.

The features of `fabgeo.panels.firstorder` are evaluated in Taylor forms (`fabgeo.panels.forms`)
over a box: a slope, and a rest that no placement of the box exceeds. A panel's own limits, wider
by that rest, contract the box, and the smaller box has smaller rests. Where it settles inside the
box that it began with (up to `BEYOND` times what the limits allow to first order), no placement of
the larger box keeps the panel's limits outside the smaller one. Programmes whose limits are wider
by the rests then bound the costs of all placements of the box: a proof.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, BoolArray, IntArray, dot
from fabgeo.panels.boxed import shape_of
from fabgeo.panels.firstorder import FREE, Option
from fabgeo.panels.forms import Linear
from fabgeo.panels.joints import Joints
from fabgeo.panels.limits import Tolerances
from fabgeo.panels.ranged import FEATURES, Meeting, joint_features, own_features
from fabgeo.panels.samples import Samples

BEYOND = (3.0, 2.0, 1.5, 1.2)  # of the box to first order: where contraction may begin
_SETTLED = 0.95  # of that, at most, is what a box settles at
_CONTRACTIONS = 4
_TOGETHER = 32  # panels in one batch: few stay in the processor's cache


@dataclass(frozen=True)
class Enclosed:
    """An option whose features are enclosed; attributes as those of an `Option`, and rests.

    Steps of one reach the borders of a panel's box.

    Attributes
    ----------
    sure : (p,) bool array
        Whether a panel's box settled; where not, nothing is known but that it may be possible.
    rest, edge_rest : arrays like `value` and `edge`
        What features are off linear ones at most.
    lean : pair of (j,) arrays
        Largest sine between normals and what is square to a joint.
    beyond : (p,) array
        How many times wider than to first order the box was that contraction began with.
    placement : (p, 6, f) array
        Steps of the carrier that steps of one make.
    """

    kind: int
    able: BoolArray
    sure: BoolArray
    value: Array
    slope: Array
    rest: Array
    edge: tuple[Array, Array]
    edge_slope: tuple[Array, Array]
    edge_rest: tuple[Array, Array]
    lean: tuple[Array, Array]
    beyond: Array
    placement: Array

    @property
    def count(self) -> int:
        """Number of steps."""
        return self.slope.shape[-1]


_UNKNOWN = 1e3  # a rest, in limits, that excludes nothing
_FAR = 300.0  # steps of about a millimetre that no box goes beyond


def left_inverse(slope: Array, rounds: int = 6) -> Array:
    """Left inverses (p, f, m) of slopes (p, m, f) with rows of small absolute sums."""
    weight = np.ones((len(slope), slope.shape[2], slope.shape[1]))
    inverse = weight
    for _ in range(rounds):
        normal = np.einsum("pmi,pjm,pmk->pjik", slope, weight, slope)
        rows = np.linalg.solve(normal, np.eye(slope.shape[2])[None, :, :, None])[..., 0]
        inverse = weight * np.einsum("pmi,pji->pjm", slope, rows)
        weight = np.abs(inverse)
        weight = weight + 1e-3 * weight.max(axis=2, keepdims=True)
    return inverse


def _allowed(features: Linear) -> Array:
    """Half widths (p, f) that rows ``|value + slope s| <= 1 + rest`` leave to steps."""
    inverse = left_inverse(features.slope)
    centre = np.abs(np.einsum("pjm,pm->pj", inverse, features.value))
    return centre + np.einsum("pjm,pm->pj", np.abs(inverse), 1.0 + features.rest)


@dataclass(frozen=True)
class _Boxes:
    """Boxes of some panels while they contract."""

    option: Option
    index: IntArray
    samples: Samples
    limits: Tolerances
    to_unit: Array

    def some(self, at: IntArray) -> _Boxes:
        """Those of some of the panels."""
        part = self.index[at], self.samples[at], self.limits, self.to_unit[at]
        return _Boxes(self.option, *part)

    def steps(self, half: Array) -> Array:
        """Steps (p, free, f) of the carriers that steps of one make."""
        units = self.option.unit[self.index][:, self.option.free, None]
        return units * (self.option.mixed[self.index] @ self.to_unit) * half[:, None]

    def features(self, half: Array) -> Linear:
        """The panels' own features over boxes, and how near steps are to what none goes beyond."""
        option = self.option
        bent = option.count > len(FREE["flat"])
        shape = shape_of(option.base[self.index], option.free, self.steps(half), bent)
        with np.errstate(invalid="ignore"):
            found = own_features(shape, self.samples, self.limits)
        zero = np.zeros(half.shape)
        border = (option.mixed[self.index] @ self.to_unit) * half[:, None] / _FAR
        return Linear(
            np.concatenate([found.value, zero], axis=1),
            np.concatenate([found.slope, border], axis=1),
            np.concatenate([found.rest, zero], axis=1),
        )

    def contracted(self, start: Array) -> tuple[Array, Linear]:
        """Half widths within which all allowed placements of larger boxes are, and features."""
        half, features = start, self.features(start)
        for _ in range(_CONTRACTIONS):
            known = np.flatnonzero(_known(features).all(axis=1))
            inner = np.ones(half.shape)
            inner[known] = np.minimum(1.0, _allowed(features.some(known)))
            half = half * inner
            features = self.features(half)
        return half, features


def _known(features: Linear) -> BoolArray:
    return np.isfinite(features.rest) & np.isfinite(features.slope).all(axis=-1)


def _settled(boxes: _Boxes, first: Array) -> tuple[_Boxes, Array, Array, Linear]:
    """Boxes with half widths, how much wider they began (zero: not settled), and features."""
    half, beyond = np.array(first), np.zeros(len(first))
    for factor in BEYOND:
        left = np.flatnonzero(beyond == 0.0)
        if not len(left):
            break
        found, seen = boxes.some(left).contracted(factor * first[left])
        good = (found < _SETTLED * factor * first[left]).all(axis=1) & _known(seen).all(axis=1)
        half[left[good]], beyond[left[good]] = found[good], factor
    return boxes, half, beyond, boxes.features(half)


def enclose(
    option: Option, samples: Samples, joints: Joints, meeting: Meeting, limits: Tolerances
) -> Enclosed:
    """Features of an option over the boxes that the panels' own limits allow."""
    index = np.flatnonzero(option.able)
    count, steps = len(index), option.count
    slope = np.concatenate([option.slope[index], option.mixed[index] / _FAR], axis=1)
    value = np.concatenate([option.value[index], np.zeros((count, steps))], axis=1)
    to_unit = np.linalg.inv(np.linalg.qr(slope)[1])  # distances are orthogonal in its columns
    first = _allowed(Linear(value, slope @ to_unit, np.zeros(value.shape)))
    parts = np.array_split(np.arange(count), max(1, count // _TOGETHER))

    def settled(part: IntArray) -> tuple[_Boxes, Array, Array, Linear]:
        return _settled(
            _Boxes(option, index[part], samples[index[part]], limits, to_unit[part]), first[part]
        )

    with ThreadPoolExecutor(min(len(parts), os.cpu_count() or 1)) as threads:
        found = list(threads.map(settled, parts))
    steps_made = np.concatenate([boxes.steps(half) for boxes, half, _, _ in found])
    beyond = np.concatenate([share for _, _, share, _ in found])
    sure = beyond > 0.0
    features = Linear(
        *(np.concatenate([getattr(f[3], n) for f in found]) for n in ("value", "slope", "rest"))
    )
    able, certain = option.able.copy(), np.zeros(len(samples), dtype=bool)
    certain[index] = sure
    able[index] = ~(sure & _excluded(features))
    placement = np.zeros((len(samples), 6, steps))
    placement[np.ix_(index, option.free)] = steps_made
    sides = [
        _edges(option, joints, meeting, limits, side, placement[:, option.free], certain, able)
        for side in (0, 1)
    ]

    def spread(array: Array, unknown: float) -> Array:
        out = np.zeros((len(samples), *array.shape[1:]))
        out[index] = np.where(sure.reshape(-1, *[1] * (array.ndim - 1)), array, unknown)
        return out

    return Enclosed(
        option.kind,
        able,
        certain,
        spread(features.value, 0.0),
        spread(features.slope, 0.0),
        spread(features.rest, _UNKNOWN),
        (sides[0][0], sides[1][0]),
        (sides[0][1], sides[1][1]),
        (sides[0][2], sides[1][2]),
        (sides[0][3], sides[1][3]),
        spread(beyond, 0.0),
        placement,
    )


def _excluded(features: Linear) -> BoolArray:
    """Whether no step keeps ``|value + slope s| <= 1 + rest``, by weights of the closest shape."""
    weight = np.sign(features.value) * np.abs(features.value) ** 15.0
    least = np.abs(dot(weight, features.value))
    least = least - np.abs(np.einsum("pm,pmf->pf", weight, features.slope)).sum(axis=1)
    return least > dot(np.abs(weight), 1.0 + features.rest)


def _edges(
    option: Option,
    joints: Joints,
    meeting: Meeting,
    limits: Tolerances,
    side: int,
    placement: Array,
    sure: BoolArray,
    able: BoolArray,
) -> tuple[Array, Array, Array, Array]:
    """Value, slope, rest and lean of features at all joints of one side."""
    panel = joints.panels[:, side]
    value, lean = np.zeros((len(joints), FEATURES)), np.zeros(len(joints))
    slope = np.zeros((len(joints), FEATURES, option.count))
    rest = np.zeros((len(joints), FEATURES))
    rest[able[panel] & ~sure[panel]] = _UNKNOWN
    sure = sure & able

    def enclosed(ends: bool, at: IntArray) -> None:
        own = panel[at]
        bent = option.count > len(FREE["flat"])
        shape = shape_of(option.base[own], option.free, placement[own], bent)
        with np.errstate(invalid="ignore"):
            found, leaning = joint_features(shape, meeting, side, at, ends, limits)
        good = _known(found)
        value[at], rest[at] = np.where(good, found.value, 0.0), np.where(good, found.rest, _UNKNOWN)
        slope[at], lean[at] = np.where(good[..., None], found.slope, 0.0), leaning

    with ThreadPoolExecutor(os.cpu_count() or 1) as threads:
        for ends in (False, True):
            every = np.flatnonzero(sure[panel] & (joints.ends == ends))
            parts = np.array_split(every, max(1, len(every) // _TOGETHER))
            some = [part for part in parts if len(part)]
            list(threads.map(enclosed, [ends] * len(some), some))
    return value, slope, rest, lean
