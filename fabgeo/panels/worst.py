"""The largest gaps and kinks at every panel's joints, and on which side."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array
from fabgeo.panels.joints import Joints


class Worst:
    """Largest figures over a panel's joints."""

    def __init__(self) -> None:
        self.gap = self.added = self.own = 0.0
        self.gap_edge = self.kink_edge = ""

    def see(self, side: str, gap: float, added: float, own: float) -> None:
        """Take in what one joint measures."""
        if gap > self.gap:
            self.gap, self.gap_edge = float(gap), side
        if added > self.added:
            self.added, self.kink_edge = float(added), side
        self.own = max(self.own, float(own))


def worst_of(joints: Joints, gap: Array, added: Array, count: int) -> list[Worst]:
    """The largest figures of every panel's joints."""
    kinks = np.linalg.norm(joints.own, axis=-1).max(axis=-1)
    worst = [Worst() for _ in range(count)]
    for j in range(len(joints)):
        for s in (0, 1):
            worst[joints.panels[j, s]].see(joints.sides[j][s], gap[j], added[j], kinks[j])
    return worst
