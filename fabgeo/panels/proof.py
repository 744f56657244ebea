"""What the panels cost at least: integer programmes whose limits are wider by what is not linear.

As `fabgeo.panels.programme` chooses, with the features of `fabgeo.panels.enclosure`: for every
panel and option one binary y and steps s in its box, ``|s| <= y``::

    minimise  sum cost y
    where     sum over a panel's options of y = 1
              |f y + F s| <= (1 + rest) y                                     the panel's own
              |own + sum of f y + F s| <= 1 + eta + sum of rest y             at every joint

Every choice of placements in the boxes that keeps the limits is a solution: what these programmes
cost at least no such choice undercuts. Strips are bounded without regard to each other.

Of a kink only its part about the joint is looked at, a, as the angle between the normals'
projections across a. The rotation vector r from normal to normal has ``a . r`` there but for
``eta = 3 T l^2``, T < 1/2 the kink's limit with the fitted kink, l the sine of the normals' largest
lean along a. With c, s the cosines and sines of both leans, t the angle between the normals and d
that between their projections, ``a . r = (t / sin t) c c' sin d``, ``cos t = c c' cos d + s s'``:
so ``|t^2 - d^2| <= 4.4 l^2``, ``|t / sin t - d / sin d| <= 1.6 l^2`` and ``1 - c c' <= l^2``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fabgeo.arrays import Array, dot
from fabgeo.panels.enclosure import Enclosed
from fabgeo.panels.highs import Programme
from fabgeo.panels.joints import Joints
from fabgeo.panels.limits import Tolerances
from fabgeo.panels.programme import Binaries, Group, Rows
from fabgeo.panels.ranged import Meeting

_ROUNDING = 1e-6  # of a limit
_UNKNOWN = 1e3  # limits: what excludes nothing


def kinks_open(
    joints: Joints, meeting: Meeting, options: Sequence[Enclosed], limits: Tolerances
) -> Array:
    """What the joints' kinks leave open, eta (j, 3), in units of their limit."""
    lean = [np.abs(dot(n[:, [0, 4, 8]], meeting.along)).max(axis=1) for n in joints.normals]
    for option in options:
        lean += list(option.lean)
    most = np.max(lean, axis=0)[:, None]
    angle = np.linalg.norm(joints.own[:, [0, 4, 8]], axis=-1) + limits.kink
    return np.where(angle < 0.5, 3.0 * angle * most**2 / limits.kink, _UNKNOWN)


def bounding_all(
    groups: Sequence[Group],
    options: Sequence[Enclosed],
    joints: Joints,
    meeting: Meeting,
    limits: Tolerances,
    prices: Array,
) -> list[Programme]:
    """The programmes of groups; see `bounding`."""
    own, eta = meeting.own / limits.kink, kinks_open(joints, meeting, options, limits)
    return [bounding(group, options, joints, own, eta, prices) for group in groups]


def bounding(
    group: Group, options: Sequence[Enclosed], joints: Joints, own: Array, eta: Array, prices: Array
) -> Programme:
    """The programme whose bound no choice of classes and placements of a group undercuts.

    Parameters
    ----------
    own, eta : (j, 3) arrays
        In units of the kink's limit: see `Meeting.own` and `kinks_open`.
    prices : (4,) array
        Cost by class; the last one is that of staying as fitted.
    """
    rows = Rows()
    binaries = Binaries(options, prices, rows)
    column = binaries.column
    for p in group.panels.tolist():
        for k in binaries.of_panel(p):
            option = options[k]
            f, slope, steps = option.value[p], option.slope[p], np.eye(option.count)
            most = 1.0 + option.rest[p] + _ROUNDING
            for sign in (1.0, -1.0):
                if option.sure[p]:
                    rows.begin(np.full(len(f), -np.inf), np.zeros(len(f)))
                    rows.put(column[p, k], np.hstack([(sign * f - most)[:, None], sign * slope]))
                rows.begin(np.full(len(steps), -np.inf), np.zeros(len(steps)))
                rows.put(column[p, k], np.hstack([-np.ones((len(steps), 1)), sign * steps]))
    for j in group.inside.tolist():
        gaps = options[0].edge[0].shape[1] - own.shape[1]
        fitted = np.concatenate([np.zeros(gaps), own[j]])
        most = 1.0 + _ROUNDING + np.concatenate([np.zeros(gaps), eta[j]])
        for sign in (1.0, -1.0):
            rows.begin(np.full(len(most), -np.inf), most - sign * fitted)
            for side in (0, 1):
                p, way = int(joints.panels[j, side]), sign * (2.0 * side - 1.0)
                for k, option in enumerate(options):
                    if option.able[p]:
                        f = way * option.edge[side][j] - option.edge_rest[side][j]
                        rows.put(
                            column[p, k],
                            np.hstack([f[:, None], way * option.edge_slope[side][j]]),
                        )
    whole = np.array(binaries.whole)
    return Programme(
        np.array(binaries.cost),
        rows.matrix(len(binaries.cost)),
        *rows.limits,
        np.where(whole, 0.0, -1.0),
        np.ones(len(whole)),
        whole,
        np.array(binaries.behind),
    )
