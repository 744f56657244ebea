"""The strip model's functional, paper eq. (2), as a least-squares problem for the solver."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fabgeo.arrays import Array, IntArray
from fabgeo.fitting.blocks import Block
from fabgeo.fitting.folds import find_fold
from fabgeo.fitting.objectives.base import Objective, State
from fabgeo.fitting.reference import Reference, Tracker
from fabgeo.fitting.samples import Net, Sites


class StripProblem:
    """A weighted sum of objectives over the control points of one net.

    Parameters
    ----------
    net : Net
    reference : Reference
    objectives : sequence of Objective
        Those of weight zero are left out of the sum.
    fold_sites : (Sites, Sites, float) or None
        Where a step is tested for folds, see `find_fold`; None tests nothing.
    trackers : dict, optional
        Closest points remembered by sites; shared by the stages of a level.
    """

    dim = 3

    def __init__(
        self,
        net: Net,
        reference: Reference,
        objectives: Sequence[Objective],
        fold_sites: tuple[Sites, Sites, float] | None = None,
        trackers: dict[int, Tracker] | None = None,
    ) -> None:
        self.net, self.reference = net, reference
        self.objectives = list(objectives)
        self.fold_sites = fold_sites
        self._trackers = {} if trackers is None else trackers
        self._state: tuple[Array, State] | None = None

    @property
    def node_count(self) -> int:
        """Control points of the model."""
        return self.net.edges * self.net.columns

    @property
    def stencils(self) -> Sequence[IntArray]:
        """Nodes of all elements."""
        return [o.nodes() for o in self.objectives]

    def state(self, x: Array) -> State:
        """The evaluated model at unknowns `x`; the last one is kept."""
        if self._state is None or self._state[0] is not x:
            control = x.reshape(self.net.edges, self.net.columns, 3)
            self._state = (x, State(self.net, control, self.reference, self._trackers))
        return self._state[1]

    def costs(self, x: Array) -> Array:
        """Half of the weighted sums of squares: of the constraints, and of all other terms."""
        state, costs = self.state(x), np.zeros(2)
        for objective in self.objectives:
            if objective.weight > 0.0:
                costs[0 if objective.constraint else 1] += objective.cost(state)
        return costs

    def blocks(self, x: Array) -> list[Block]:
        """Residuals and Jacobians of all terms."""
        state = self.state(x)
        return [o.block(state) for o in self.objectives if o.weight > 0.0]

    def admissible(self, x: Array) -> bool:
        """Whether no strip folds over."""
        return self.fold_sites is None or find_fold(self.state(x), *self.fold_sites) is None
