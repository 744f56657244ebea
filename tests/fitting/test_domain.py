"""Nets laid between the boundary loops of a surface."""

from __future__ import annotations

import numpy as np
import pytest

from fabgeo.errors import InputError
from fabgeo.fitting.starts.domain import corners_of, net_of_loops
from fabgeo.fitting.starts.methods import called
from fabgeo.surfaces.formula import FormulaSurface
from fabgeo.surfaces.nurbs import NurbsFace, NurbsSurface

DOME = FormulaSurface(
    "u", "v", "-0.5e-4 * u**2 + 0.3e-4 * u * v - 0.3e-4 * v**2", (-4e3, 4e3), (-4e3, 4e3)
)
TUBE = FormulaSurface(
    "3000*cos(u)", "2000*sin(u)", "v", (0.0, 2 * np.pi), (0.0, 9000.0), closed_u=True
)


def test_loops_give_corners_and_a_net_over_the_whole_surface():
    loop = DOME.loops[0]
    corners = loop[corners_of(loop)][:, :2]
    assert np.allclose(np.sort(np.abs(corners), axis=None), 4e3)
    net, _ = net_of_loops(DOME, 13)
    assert (
        np.abs(DOME.closest(net.points.reshape(-1, 3)).point - net.points.reshape(-1, 3)).max() < 1
    )
    ring, note = net_of_loops(TUBE, 9)
    assert ring.closed_t
    assert "tube" in note


def plate(*loops):
    """A flat face of 8 x 8 m within trimming loops."""
    poles = np.array([[[-4e3, -4e3, 0], [-4e3, 4e3, 0]], [[4e3, -4e3, 0], [4e3, 4e3, 0]]], float)
    knots = np.array([-4e3, -4e3, 4e3, 4e3])
    return NurbsSurface([NurbsFace(poles, None, knots, knots, 1, 1, loops)], "plate")


def box(x, y):
    return np.array([[-x, -y], [x, -y], [x, y], [-x, y]])


@pytest.mark.parametrize(("width", "closed"), [(30.0, False), (2e3, True)])
def test_strips_lead_round_a_hole_but_not_round_a_slit(width, closed):
    net, note = net_of_loops(plate(box(3.9e3, 3.9e3), box(3e3, width)))
    assert net.closed_t == closed
    assert ("1 inner loops ignored" in note) != closed


def test_sides_lie_between_the_corners_that_are_given():
    # A disc has no corners: four points on its rim are taken, wherever they are wanted.
    t = np.linspace(0.0, 2.0 * np.pi, 721)[:-1]
    rim = np.stack([3e3 * np.cos(t), 3e3 * np.sin(t)], axis=1)
    disc = plate(rim)
    at = np.radians([10.0, 80.0, 190.0, 260.0])
    wanted = 3e3 * np.stack([np.cos(at), np.sin(at), 0.0 * at], axis=1)
    net, note = net_of_loops(disc, corners=1.1 * wanted)
    found = net.points[[0, 0, -1, -1], [0, -1, -1, 0]]
    gap = np.linalg.norm(found[:, None] - wanted, axis=2).min(axis=1)
    assert gap == pytest.approx(0.0, abs=20.0)
    assert "corners of the boundary at" in note
    with pytest.raises(InputError, match="nearest to the same point"):
        net_of_loops(disc, corners=wanted[[0, 0, 1, 2]])
    # Edge and ruling have one direction at a smooth corner: the start folds, but not short of it.
    model, notes = called("iso", disc, 8, 8, "v", None, {"corners": wanted, "overhang": (-0.1, 0)})
    assert any("edges end 10 % short" in n for n in notes)
    ends = np.linalg.norm(model.points(np.array([0.0, 8.0]))[1:-1, :, :2], axis=2)
    assert (ends[:, 0] < 2900.0).all()
    assert ends[:, 1] == pytest.approx(3e3, abs=1.0)
