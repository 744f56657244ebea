"""What all terms of the functional share: state, weighting, assembly of blocks."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from fabgeo.arrays import Array, IntArray
from fabgeo.fitting.blocks import Block
from fabgeo.fitting.reference import Foot, Reference, Tracker
from fabgeo.fitting.samples import Net, Sites


class State:
    """A model during the fit: control points and, on demand, what is evaluated on it.

    Parameters
    ----------
    net : Net
    control : (edges, columns, 3) array
        In the fit's unit.
    reference : Reference
    trackers : dict, optional
        Closest points remembered by sites from one state to the next; without it every state
        finds them anew.
    """

    def __init__(
        self,
        net: Net,
        control: Array,
        reference: Reference,
        trackers: dict[int, Tracker] | None = None,
    ) -> None:
        self.net, self.control, self.reference = net, control, reference
        self._trackers = {} if trackers is None else trackers
        self._values: dict[tuple[int, int], Array] = {}
        self._feet: dict[int, tuple[Foot, Foot]] = {}

    def at(self, sites: Sites, derivative: int = 0) -> Array:
        """Points or derivatives (edges, elements, q, 3)."""
        key = (id(sites), derivative)
        if key not in self._values:
            self._values[key] = sites.evaluate(self.control, derivative)
        return self._values[key]

    def around(self, sites: Sites, width: int, derivative: int = 0) -> list[Array]:
        """The same for every member of the stencils: `width` arrays (n, elements, q, 3)."""
        values, window = self.at(sites, derivative), self.net.windows(width)
        return [values[window[:, k]] for k in range(width)]

    def feet(self, sites: Sites) -> tuple[Foot, Foot]:
        """Closest points of the edges' points and of the rulings' middles, found together."""
        key = id(sites)
        if key not in self._feet:
            edge = self.at(sites)
            a, b = self.around(sites, 2)
            tracker = self._trackers.setdefault(key, self.reference.tracker())
            both = tracker.feet(np.concatenate([edge, (a + b) / 2.0]))
            n = len(edge)
            self._feet[key] = (
                Foot(both.point[:n], both.normal[:n], both.beyond[:n]),
                Foot(both.point[n:], both.normal[n:], both.beyond[n:]),
            )
        return self._feet[key]


type Gradients = dict[int, Array]


class Objective(ABC):
    """One term: weight times the mean of squared residuals over all its sites and stencils.

    Attributes
    ----------
    name : str
    width : int
        Edges of a stencil, 1 to 3.
    window : (n, width) int array
        The edges of every stencil; all of the net unless a term chooses.
    weight : float
    importance : array or float
        Factors on the squared residuals, broadcast to (n, elements, q); mean about 1.
    constraint : bool
        Whether it has the nature of a constraint, whose weight grows.
    """

    name = ""
    width = 1
    constraint = False

    def __init__(self, sites: Sites) -> None:
        self.sites = sites
        self.weight = 1.0
        self.window = sites.net.windows(self.width)
        self.importance: Array | float = 1.0

    @abstractmethod
    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Residuals (n, elements, q, r); with `slopes` the gradients (n, elements, q, r, width, 3).

        Gradients are by points (0), first (1) and second derivatives (2) of the stencil's edges.
        """
        ...

    def nodes(self) -> IntArray:
        """The nodes of every element, (n * elements, width * 4): one array, kept."""
        return self.sites.nodes(self.window)

    def factor(self) -> Array:
        """Square roots of the weights, (n, elements, q, 1)."""
        count = len(self.window)
        share = self.weight * self.sites.weight / max(count, 1) * self.importance
        return np.sqrt(np.broadcast_to(share, (count, *self.sites.u.shape)))[..., None]

    def cost(self, state: State) -> float:
        """Half of the weighted sum of squares."""
        values = self.evaluate(state, False)[0] * self.factor()
        return 0.5 * float(np.vdot(values, values))

    def block(self, state: State) -> Block:
        """Weighted residuals and Jacobian, batched."""
        values, gradients = self.evaluate(state, True)
        factor = self.factor()
        jacobian = self.sites.jacobian(
            {order: g * factor[..., None, None] for order, g in gradients.items()}
        )
        residual = (values * factor).reshape(jacobian.shape[1:3])
        return Block(self.nodes(), residual, jacobian)

    def rms(self, state: State) -> float:
        """Root of the unweighted mean of squares, in the fit's unit."""
        values = self.evaluate(state, False)[0]
        square = np.einsum("...r,...r->...", values, values)
        return float(np.sqrt(np.mean(square))) if square.size else 0.0
