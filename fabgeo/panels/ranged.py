"""Features of panels and joints over boxes of placements, in Taylor forms.

Those of `fabgeo.panels.firstorder`, fewer: gaps in four directions at three samples of a joint, of
a kink its part about the joint. See `fabgeo.panels.enclosure` for the boxes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, IntArray, dot, unit
from fabgeo.panels.boxed import Shape, ends_of, terms_of
from fabgeo.panels.forms import Form, Linear
from fabgeo.panels.joints import Joints
from fabgeo.panels.limits import Tolerances
from fabgeo.panels.samples import Samples

_AT = np.array([0, 4, 8])  # of the joints' nine samples
_DIRECTIONS = np.pi / 4.0 * np.arange(4)  # across a joint
FEATURES = len(_AT) * (len(_DIRECTIONS) + 1)  # of a joint


def _sum(a: list[Form], b: list[Form]) -> Form:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def own_features(shape: Shape, samples: Samples, tolerances: Tolerances) -> Linear:
    """Distances of both edges and shifts of the ends over boxes, in units of their limits."""
    points = samples.points(np.array([0.0, 1.0]))[:, ::2]
    near = terms_of(shape, points.reshape(len(samples), -1, 3)).distance
    near = near.scaled(1.0 / min(tolerances.deviation_mm, tolerances.flange))
    if not shape.bent:
        return near.linear
    shift = ends_of(shape, samples.edges[0][:, [0, -1]])[0]
    return Form.joined([near, shift.scaled(1.0 / tolerances.ends_mm).shaped(-1)]).linear


@dataclass(frozen=True)
class Meeting:
    """What joints are measured by: directions at three of their samples, and what kinks leave open.

    Attributes
    ----------
    points : (j, 3, 3) array
    around : (j, 3, 4, 3) array
        Directions across the joint in which gaps are measured.
    along : (j, 3, 3) array
        Unit vectors about which the kink is.
    tilt : (2, j, 3, 3) array
        Where normals of either panel tilt to about them.
    own : (j, 3) array
        Angle between the fitted normals about `along` less their rotation vector's part there.
    """

    points: Array
    around: Array
    along: Array
    tilt: Array
    own: Array

    @classmethod
    def of(cls, joints: Joints) -> Meeting:
        """Those of given joints."""
        along = joints.points
        if len(joints):
            along = unit(np.gradient(joints.points, axis=1, edge_order=2))
        along = along[:, _AT]
        first, second = joints.normals[:, :, _AT]
        across = np.cross(along, first)
        around = [np.cos(a) * first + np.sin(a) * across for a in _DIRECTIONS]
        tilt = np.cross(along, joints.normals[:, :, _AT])
        level = dot(second, first) - dot(along, first) * dot(along, second)
        angle = np.arctan2(dot(second, tilt[0]), level)  # of the projections across `along`
        own = angle - dot(joints.own[:, _AT], along)
        return cls(joints.points[:, _AT], np.stack(around, axis=2), along, unit(tilt), own)


def joint_features(
    shape: Shape, meeting: Meeting, side: int, joint: IntArray, ends: bool, limits: Tolerances
) -> tuple[Linear, Array]:
    """Features (j, 15) of made panels at joints over boxes, and how far normals lean along them.

    At each of three samples the gap's part in four directions, and the tilt, in their limits.
    """
    points, count = meeting.points[joint], len(joint)
    if ends and shape.bent:
        _, moves, normal = ends_of(shape, points[:, None, [0, 2]])
        moves = [m.shaped(2) for m in moves]
        middle = [(m[:, :1] + m[:, 1:]).scaled(0.5) for m in moves]
        off = [Form.joined([m[:, :1], c, m[:, 1:]]) for m, c in zip(moves, middle, strict=True)]
        normal = [Form.joined([n.shaped(1)] * 3) for n in normal]
    else:
        near = terms_of(shape, points)
        off, normal = [-(near.distance * n) for n in near.normal], near.normal
    gaps = []
    for a in range(len(_DIRECTIONS)):
        gaps.append(_sum(off, shape.turned(meeting.around[joint, :, a])))
    tilt = _sum(normal, shape.turned(meeting.tilt[side, joint]))
    lean = _sum(normal, shape.turned(meeting.along[joint])).most
    most = tilt.most  # the angle is the tilt's arc sine, the normal's length across taken as one
    tilt = tilt.wider(most**3 / 5.0 + most * lean**2)
    both = [gap.scaled(1.0 / limits.gap_mm) for gap in gaps] + [tilt.scaled(1.0 / limits.kink)]
    return Form.joined(both).linear, lean.reshape(count, -1).max(axis=1)
