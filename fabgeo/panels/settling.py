"""With the classes of a group decided: the placements that use every limit the least.

A linear programme over steps about the options' bases, as in `fabgeo.panels.programme`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array
from fabgeo.panels.firstorder import ENDS, Option
from fabgeo.panels.highs import Programme, Solution
from fabgeo.panels.joints import Joints
from fabgeo.panels.programme import Group, Rows, joint_rows


@dataclass(frozen=True)
class Missed:
    """By how much limits are used more than features tell, in limits.

    Attributes
    ----------
    own, joint : (p,) and (j,) arrays
        Distances of whole panels; gaps and kinks of joints.
    """

    own: Array
    joint: Array


@dataclass(frozen=True)
class Settling:
    """The linear programme that makes the largest use of any limit small in a group.

    Attributes
    ----------
    programme : Programme
    column : dict
        Where the steps of a panel begin, and how many there are.
    """

    programme: Programme
    column: dict[int, tuple[int, int]]

    def steps(self, group: Group, solution: Solution) -> list[Array] | None:
        """Steps of the group's panels; None if there is no solution."""
        x = solution.x
        if x is None:
            return None
        spans = [self.column.get(p, (0, 0)) for p in group.panels.tolist()]
        return [x[at : at + count] for at, count in spans]


def settling(
    group: Group, option: Sequence[Option | None], joints: Joints, missed: Missed
) -> Settling:
    """The programme that settles a group's panels, each in its class.

    Parameters
    ----------
    option : sequence of Option or None
        That of every panel of the group, of one at least; None: it stays as fitted.
    missed : Missed
        What features do not see about the options' placements.
    """
    column: dict[int, int] = {}
    of: dict[int, Option] = {}
    count = 1  # the first column is the largest use
    for p, own in zip(group.panels.tolist(), option, strict=True):
        if own is not None:
            column[p], of[p] = count, own
            count += own.count
    rows = Rows()
    for p, own in of.items():
        f = own.value[p]
        more = np.where(np.arange(len(f)) < len(f) - ENDS, missed.own[p], 0.0)
        for sign in (1.0, -1.0):
            rows.begin(np.full(len(f), -np.inf), -sign * f - more)
            rows.put(0, np.full((len(f), 1), -1.0))
            rows.put(column[p], sign * own.slope[p])
    width = next(iter(of.values())).edge[0].shape[1]
    at = np.array([*group.inside, *(rim.joint for rim in group.rims)], dtype=np.int64)
    for (offset, terms), more in zip(joint_rows(group, width), missed.joint[at], strict=True):
        sides = [(int(joints.panels[j, side]), j, side, sign) for j, side, sign in terms]
        sides = [one for one in sides if one[0] in of]
        known = sum((t * of[p].edge[side][j] for p, j, side, t in sides), np.zeros(width))
        for sign in (1.0, -1.0):
            rows.begin(np.full(width, -np.inf), sign * (offset - known) - more)
            rows.put(0, np.full((width, 1), -1.0))
            for p, j, side, t in sides:
                rows.put(column[p], sign * t * of[p].edge_slope[side][j])
    cost = np.zeros(count)
    cost[0] = 1.0
    free = np.full(count, np.inf)
    whole = np.zeros(count, dtype=bool)
    programme = Programme(cost, rows.matrix(count), *rows.limits, -free, free, whole)
    return Settling(programme, {p: (at, of[p].count) for p, at in column.items()})
