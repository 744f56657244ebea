"""Candidates: what each panel could be made as, with the consequences at its joints.

Glossary
--------
candidate
    One class and one placement for one panel. Every panel has the candidate of staying as fitted.
pair
    One joint with one candidate on either side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, BoolArray, IntArray
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.joints import Joints, compare, made_boundary

CLASSES = ("flat", "cylinder", "cone", "developable")
_DEVELOPABLE = CLASSES.index("developable")


@dataclass(frozen=True)
class Pool:
    """Candidates of all panels.

    Attributes
    ----------
    panel : (c,) int array
        Whose candidate it is.
    kind : (c,) int array
        Index into CLASSES.
    carriers : Carriers
        Placements (meaningless for a developable one).
    deviation, bound, flange : (c,) arrays
        Largest distance found between fitted and made panel, its bound, and the largest change of
        the distance between panel and beam flange (at the edges), mm.
    """

    panel: IntArray
    kind: IntArray
    carriers: Carriers
    deviation: Array
    bound: Array
    flange: Array

    def __len__(self) -> int:
        return len(self.panel)

    def __getitem__(self, index: IntArray | BoolArray) -> Pool:
        return Pool(
            self.panel[index],
            self.kind[index],
            self.carriers[index],
            self.deviation[index],
            self.bound[index],
            self.flange[index],
        )

    @property
    def replaced(self) -> BoolArray:
        """Whether a candidate is another shape than the fitted one."""
        return self.kind != _DEVELOPABLE

    def with_more(self, other: Pool) -> Pool:
        """Both pools in one."""
        return Pool(
            np.concatenate([self.panel, other.panel]),
            np.concatenate([self.kind, other.kind]),
            Carriers.joined([self.carriers, other.carriers]),
            np.concatenate([self.deviation, other.deviation]),
            np.concatenate([self.bound, other.bound]),
            np.concatenate([self.flange, other.flange]),
        )


def as_fitted(guess: Carriers) -> Pool:
    """The pool in which every panel stays as fitted (`guess`: any carriers, one a panel)."""
    count = len(guess)
    zero = np.zeros(count)
    kind = np.full(count, _DEVELOPABLE, dtype=np.int64)
    return Pool(np.arange(count), kind, guess, zero, zero, zero)


def pair_limits(
    pool: Pool, joints: Joints, joint: IntArray, first: IntArray, second: IntArray
) -> tuple[Array, Array]:
    """Largest gap (mm) and added kink (radians) of pairs: joint, candidate, candidate, (c,) each.

    Candidate -1: the panel stays as fitted.
    """
    gap, kink = np.empty(len(joint)), np.empty(len(joint))
    own = joints.own
    for part in np.array_split(np.arange(len(joint)), max(1, len(joint) // 50000)):
        j = joint[part]
        sides = []
        for side, candidate in ((0, first[part]), (1, second[part])):
            sides.append(
                made_boundary(
                    pool.carriers[candidate],
                    pool.replaced[candidate] & (candidate >= 0),
                    joints.points[j],
                    joints.normals[side, j],
                    joints.ends[j],
                )
            )
        gap[part], kink[part] = compare(sides[0], sides[1], own[j])
    return gap, kink
