"""Carriers over boxes of their steps: coordinates, distances, normals and ends as Taylor forms.

The formulas are those of `fabgeo.panels.carrier` and `fabgeo.panels.made`, without branches, so
that they hold over a whole box. A made end's corner moves from its foot along the carrier's circle
by the angle between its turn and the mean turn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, IntArray
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.forms import Form, arc, sine, versine


@dataclass(frozen=True)
class Shape:
    """Carriers of a box: rotation (nine forms), shift, k and g, all (p, ...)."""

    base: Carriers
    rotation: list[list[Form]]
    shift: Form
    k: Form
    g: Form
    bent: bool
    steps: int

    def turned(self, vectors: Array) -> list[Form]:
        """World vectors (p, s, 3) in the moved frame."""
        local = vectors @ self.base.frame.transpose(0, 2, 1)
        return self._turned(local)

    def local(self, points: Array) -> list[Form]:
        """World points (p, s, 3) in the moved frame."""
        turned = self._turned(self.base.local(points))
        return [x - row[2] * self.shift for x, row in zip(turned, self.rotation, strict=True)]

    def _turned(self, local: Array) -> list[Form]:
        x, y, z = (local[..., i] for i in range(3))
        return [row[0].scaled(x) + row[1].scaled(y) + row[2].scaled(z) for row in self.rotation]


def shape_of(base: Carriers, free: IntArray, basis: Array, bent: bool) -> Shape:
    """The carriers of boxes: `basis` (p, 6 free, f) are the steps that sigma = 1 makes."""
    steps = basis.shape[-1]
    zero = np.zeros((len(base), 1))
    of = {int(i): basis[:, n, None] for n, i in enumerate(free)}

    def form(i: int, value: Array) -> Form:
        return Form.of(value, of.get(i, np.zeros((len(base), 1, steps))))

    w = [form(i, zero) for i in (1, 2, 3)]
    angle = np.sqrt(sum(one.most**2 for one in w))
    beyond = angle**3 / 6.0  # of the exponential's series after the second term
    square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    rows = []
    for i in range(3):
        row = []
        for j in range(3):
            second = (w[i] * w[j]).scaled(0.5)
            if i == j:
                one = second - square.scaled(0.5) + 1.0
            else:
                k, sign = 3 - i - j, 1.0 if (j - i) % 3 == 1 else -1.0
                one = second + w[k].scaled(sign)
            row.append(one.wider(beyond))
        rows.append(row)
    k, g = form(4, base.k[:, None]), form(5, base.g[:, None])
    return Shape(base, rows, form(0, zero), k, g, bent, steps)


@dataclass(frozen=True)
class Terms:
    """Local coordinates, Q, distance and unit normal of points (p, s) over boxes."""

    at: list[Form]
    e: Form
    q: Form
    distance: Form
    normal: list[Form]


def terms_of(shape: Shape, points: Array) -> Terms:
    """Terms of world points (p, s, 3)."""
    x, y, z = shape.local(points)
    none = Form.constant(np.zeros(y.value.shape), shape.steps)
    if not shape.bent:
        return Terms([x, y, z], none + 1.0, none + 1.0, z, [none, none, none + 1.0])
    k, g = shape.k, shape.g
    e = g * x + k * z + 1.0
    square = y * y
    q = (e * e + (k * k + g * g) * square).root()
    over = (q + e).inverse()
    distance = z + k * square * over
    circle = k * q.inverse()
    ratio = circle * square * over
    return Terms(
        [x, y, z], e, q, distance, [-(g * ratio), circle * y, (k * ratio).scaled(-1.0) + 1.0]
    )


def ends_of(shape: Shape, corners: Array) -> tuple[Form, list[Form], list[Form]]:
    """Made ends: shifts (p, e, 2) of their corners (p, e, 2, 3), moves of them, the ends' normal.

    Moves (p, e, 2) and normals (p, e, 1) have three components in the moved frame.
    """
    count, ends = corners.shape[:2]
    flat = terms_of(shape, corners.reshape(count, 2 * ends, 3))

    at = [one.shaped(ends, 2) for one in flat.at]
    e, q, d = (one.shaped(ends, 2) for one in (flat.e, flat.q, flat.distance))
    normal = [one.shaped(ends, 2) for one in flat.normal]
    k, g = shape.k[:, :, None], shape.g[:, :, None]
    both = k * k + g * g
    tangent = at[1] * e.inverse()
    turn = tangent * arc(both * (tangent * tangent))
    mean = (turn[:, :, :1] + turn[:, :, 1:]).scaled(0.5)
    away = mean - turn
    level = q - k * d
    shift = away * level
    square = both.most * away.most**2
    along = shift.wider(level.most * away.most * square / 6.0)  # e sin(n a) / n
    inward = (shift * away).scaled(0.5).wider(level.most * away.most**2 * square / 24.0)
    one = q.inverse()
    circle = [-(g * at[1] * one), e * one, -(k * at[1] * one)]
    radial = [g * e * one, both * at[1] * one, k * e * one]
    moves = [along * c - inward * r - d * n for c, r, n in zip(circle, radial, normal, strict=True)]
    square = both * (mean * mean)
    sag = mean * mean * versine(square)
    normals = [-(g * k * sag), k * mean * sine(square), -(k * k * sag) + 1.0]
    return shift, moves, normals
