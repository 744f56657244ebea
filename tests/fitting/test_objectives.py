"""Every term's exact Jacobian against central differences, open and closed both ways."""

from __future__ import annotations

import numpy as np
import pytest
from fit_helpers import quadric

from fabgeo.fitting.objectives.anchor import Anchor
from fabgeo.fitting.objectives.base import State
from fabgeo.fitting.objectives.boundary import Boundary
from fabgeo.fitting.objectives.circular import Circular
from fabgeo.fitting.objectives.conical import Conical
from fabgeo.fitting.objectives.cover import Cover
from fabgeo.fitting.objectives.developable import Developable
from fabgeo.fitting.objectives.even_widths import EvenWidths, TargetWidths
from fabgeo.fitting.objectives.fair_edges import FairEdges
from fabgeo.fitting.objectives.fair_rulings import FairRulings
from fabgeo.fitting.objectives.geodesic import Geodesic
from fabgeo.fitting.objectives.points import MountingPoints
from fabgeo.fitting.objectives.proximity import EdgeProximity, MiddleProximity
from fabgeo.fitting.reference import Reference, Side
from fabgeo.fitting.samples import Net, Sites

RNG = np.random.default_rng(7)
FREE = [Developable, EdgeProximity, MiddleProximity, EvenWidths, TargetWidths]
FREE += [Conical, Circular, Geodesic]
HELD = [FairEdges, FairRulings, Anchor, Boundary, Cover, MountingPoints]


def shaken(net):
    """A model of unit-wide strips, well away from any symmetry."""
    i, j = np.meshgrid(np.arange(net.edges), np.arange(net.columns), indexing="ij")
    grid = np.stack([0.8 * j, 1.0 * i, 0.05 * i * j + 0.02 * j**2], axis=-1)
    return grid + 0.15 * RNG.standard_normal(grid.shape)


def built(term, net):
    sites = Sites.gauss(net, 2)
    shape = (net.edges, *sites.u.shape, 3)
    normals = RNG.standard_normal(shape)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    if term is FairEdges:
        return FairEdges(sites, normals, 0.7, 0.1)
    if term is FairRulings:
        return FairRulings(sites, normals, 0.1)
    if term is Anchor:
        return Anchor(sites, RNG.standard_normal(shape), normals)
    if term is Boundary:
        side = Side(np.array([[-100.0, 0.3, 0.0], [0.0, 0.3, 0.0], [100.0, 0.3, 0.0]]))
        return Boundary(sites, np.array([0]), side, normals[:1], 0.3)
    if term is Cover:
        sites = Sites.gauss(net, 1)
        start = np.full((net.edges, *sites.u.shape, 3), [9.0, 1.0, 0.0])
        room = np.full(start.shape[:-1], 5.8)
        return Cover(sites, np.arange(net.edges), start, normals[..., :1, :], room)
    if term is MountingPoints:
        points = RNG.standard_normal((5, 3)) + np.array([2.0, 1.5, 0.0])
        return MountingPoints(net, np.array([0, 1, 1, 2, 3]), np.linspace(0.1, 3.9, 5), points)
    return term(sites)


@pytest.mark.parametrize("closed", [(False, False), (True, False), (False, True), (True, True)])
@pytest.mark.parametrize(
    "term", [*FREE, FairEdges, FairRulings, Anchor, Boundary, Cover, MountingPoints]
)
def test_jacobian_is_exact(term, closed):
    net = Net(5, 6, *closed)
    control = shaken(net)
    reference = Reference(quadric(0.02, -0.03, (9.0, 9.0)), 1.0)
    objective = built(term, net)
    objective.weight = 2.5
    block = objective.block(State(net, control, reference))
    step = RNG.standard_normal(control.shape)
    local = step.reshape(-1, 3)[block.nodes]
    predicted = np.einsum("ckrw,kwc->kr", block.jacobian, local)
    h = 1e-5
    ahead, back = (
        objective.block(State(net, control + s * h * step, reference)).residual for s in (1, -1)
    )
    error = np.abs((ahead - back) / (2 * h) - predicted).max()
    assert error < 1e-7 * max(1.0, np.abs(predicted).max())
    assert objective.cost(State(net, control, reference)) == pytest.approx(
        0.5 * np.sum(block.residual**2), rel=1e-12
    )


def test_developable_is_the_distance_of_the_quads_diagonals():
    net = Net(2, 3, False, False)
    sites = Sites.gauss(net, 2)
    state = State(net, shaken(net), Reference(quadric(0.0, 0.0), 1.0))
    value = Developable(sites).evaluate(state, False)[0][0, :, :, 0]
    p0, p1 = state.at(sites)
    d0, d1 = state.at(sites, 1)
    ruling = np.linalg.norm(p1 - p0, axis=-1, keepdims=True)
    far0 = p0 + ruling * d0 / np.linalg.norm(d0, axis=-1, keepdims=True)
    far1 = p1 + ruling * d1 / np.linalg.norm(d1, axis=-1, keepdims=True)
    # Two lines: p0 -> far1 and p1 -> far0; their distance by the common perpendicular.
    common = np.cross(far1 - p0, far0 - p1)
    distance = np.sum((p1 - p0) * common, axis=-1) / np.linalg.norm(common, axis=-1)
    np.testing.assert_allclose(np.abs(value), np.abs(distance), rtol=1e-10)
