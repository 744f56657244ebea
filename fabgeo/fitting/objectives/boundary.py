"""Closeness to the boundary: distances to its tangents, f_prox of the boundary in eq. (2)."""

from __future__ import annotations

from fabgeo.arrays import Array, IntArray
from fabgeo.fitting.objectives.base import Gradients, Objective, State
from fabgeo.fitting.objectives.fair_edges import mostly_tangential
from fabgeo.fitting.reference import Side
from fabgeo.fitting.samples import Sites


class Boundary(Objective):
    """x - y without its part along the boundary's tangent, y the closest boundary point.

    Parameters
    ----------
    sites : Sites
    edges : (n,) int array
        Which edge curves are held at these sites.
    side : Side
        The smooth piece of the boundary that holds them.
    normals : (n, elements, q, 3) array
        The surface's normals there, taken at the beginning of a stage and kept.
    share : float
        How much of the part along the normal counts. Chords sag: where the outermost strip may
        stand off by half its sag, like all others, the largest deviation is smaller.
    """

    name = "boundary"
    width = 1

    def __init__(
        self, sites: Sites, edges: IntArray, side: Side, normals: Array, share: float
    ) -> None:
        super().__init__(sites)
        self.window = edges[:, None]
        self._edges, self._side = edges, side
        self._normal_map = mostly_tangential(normals, share)

    def evaluate(self, state: State, slopes: bool) -> tuple[Array, Gradients]:
        """Vectors to the boundary's tangents and their gradients."""
        points = state.at(self.sites)[self._edges]
        foot, tangent = self._side.closest(points)
        across = self._normal_map @ mostly_tangential(tangent, 0.0)
        values = (across @ (points - foot)[..., None])[..., 0]
        return values, {0: across[..., :, None, :]} if slopes else {}
