"""Candidates that differ: placements that a joint could not tell apart are kept once."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import IntArray
from fabgeo.panels.pool import Pool
from fabgeo.panels.samples import Samples


class Distinct:
    """What the candidates of a growing pool look like.

    Parameters
    ----------
    samples : Samples
        Of all panels.
    fine : float
        mm. Equal are candidates of one panel and class that are in the same cell of this size at
        the panel's corners and middle, and in what their rulings swing from its ends.
    """

    def __init__(self, samples: Samples, fine: float) -> None:
        middle = len(samples.t) // 2
        corners = samples.edges[0][:, [0, middle, -1]]
        self.corners, self.fine = corners.reshape(len(samples), 6, 3), fine
        self.seen: IntArray = np.zeros((0, 10), dtype=np.int64)

    def kept(self, pool: Pool, old: int) -> IntArray:
        """The first `old` candidates, and those that differ from every one before them."""
        index = np.arange(len(self.seen), len(pool))
        panel, carriers = pool.panel[index], pool.carriers[index]
        at = self.corners[panel]
        turn = carriers.coordinates(at[:, [0, 1, 4, 5]])[0]
        look = np.concatenate([carriers.distance(at), turn[:, ::2] - turn[:, 1::2]], axis=1)
        named = np.column_stack([panel, pool.kind[index], np.round(look / self.fine)])
        self.seen = np.concatenate([self.seen, named.astype(np.int64)])
        _, first = np.unique(self.seen, axis=0, return_index=True)
        kept = np.union1d(np.arange(old), first)
        self.seen = self.seen[kept]
        return kept
