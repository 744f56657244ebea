"""Offsets and box-shell cells on exact conical models."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline
from structure_models import generic

from fabgeo.arrays import cross, dot, unit
from fabgeo.errors import GeometryError
from fabgeo.strips.model import StripModel
from fabgeo.strips.offset import offset
from fabgeo.structures.cells import cells
from fabgeo.structures.mixed import admits
from fabgeo.structures.panels import Layer, panels
from fabgeo.structures.parts import Prism
from fabgeo.structures.patches import CutRule, cut
from fabgeo.structures.prisms import prism_properties, prism_volume


@pytest.mark.parametrize("distance", [-400.0, 300.0])
def test_offset_keeps_distance(conical: StripModel, distance: float) -> None:
    made = offset(conical, distance)
    assert made.errors.curve <= 1e-3
    assert made.errors.ruling < 0.01
    assert made.errors.plane < 0.01
    assert made.errors.angle_deg < 0.01


def test_folded_offset_is_refused_by_strip_and_radius(torus: StripModel) -> None:
    with pytest.raises(GeometryError, match=r"strip \d+ at u.*smallest radius.* 49\d\d"):
        offset(torus, -5100.0)


def test_general_model_is_refused_with_the_reason() -> None:
    rng = np.random.default_rng(5)
    control = generic(1).control + rng.normal(0.0, 60.0, generic(1).control.shape)
    model = StripModel(control)
    with pytest.raises(GeometryError, match="need a conical or a circular model"):
        cells(model, cut(model, CutRule(count=2)), -300.0)
    assert not admits(model).beams
    assert "common axis" in admits(model).reason
    assert panels(
        StripModel(control[:2]),
        cut(StripModel(control[:2]), CutRule(count=2)),
        Layer("skin", 0.0, 3.0, "steel"),
    )


def test_neighbouring_cells_share_faces_to_the_last_digit(conical: StripModel) -> None:
    patches = cut(conical, CutRule(length=1500.0))
    made = {(c.patch.strip, c.patch.cell): c.prism for c in cells(conical, patches, -300.0)}
    for (strip, cell), prism in made.items():
        beside = made.get((strip + 1, cell))
        if beside is not None:
            assert np.array_equal(prism.knots, beside.knots)
            assert np.array_equal(prism.poles[1], beside.poles[0])
            assert np.array_equal(prism.poles[2], beside.poles[3])
        after = made.get((strip, cell + 1))
        if after is not None:
            assert np.abs(prism.poles[:, -1] - after.poles[:, 0]).max() < 1e-9


def test_cell_walls_are_plane_and_volume_agrees_with_a_second_route(conical: StripModel) -> None:
    patches = cut(conical, CutRule(count=3))
    for cell in cells(conical, patches, -300.0):
        for end in (0, -1):
            a, b, c, d = cell.prism.poles[:, end]
            normal = unit(cross(c - a, d - b))
            assert abs(float(dot(b - a, normal))) < 1e-3
    prism = cells(conical, patches, -300.0)[4].prism
    # Divergence theorem over dense bilinear faces, a route without the Jacobian.
    assert np.isclose(prism_volume(prism), _volume_by_surface(prism), rtol=2e-6)


def _volume_by_surface(prism: Prism, count: int = 400) -> float:
    u = np.linspace(prism.knots[0], prism.knots[-1], count + 1)
    p = np.moveaxis(np.asarray(BSpline(prism.knots, np.moveaxis(prism.poles, 1, 0), 3)(u)), 0, 1)
    p = p - p.mean(axis=(0, 1))
    q = np.roll(p, -1, axis=0)
    total = 0.0
    for a, b, c in (
        (p[:, :-1], q[:, :-1], q[:, 1:]),
        (p[:, :-1], q[:, 1:], p[:, 1:]),
        (p[:, :-1], q[:, :-1], p[:, 1:]),
        (q[:, :-1], q[:, 1:], p[:, 1:]),
    ):  # both ways to split a bilinear face, halved: exact for its volume
        total += float(dot(a, cross(b, c)).sum()) / 12.0
    ends = 0.0
    for k, sign in ((0, -1.0), (-1, 1.0)):
        a, b, c, d = p[:, k]
        ends += sign * float(dot(a, cross(b, c)) + dot(a, cross(c, d))) / 6.0
        ends += sign * float(dot(b, cross(c, d)) + dot(b, cross(d, a))) / 6.0
    return abs(total + ends / 2.0)


def test_folded_cell_is_refused_by_mark() -> None:
    knots = np.array([0.0] * 4 + [1.0] * 4)
    s = np.linspace(0.0, 1.0, 4)[:, None]
    ends = np.array(
        [
            [[0, 0, 0], [100, 0, 0]],
            [[0, 50, 0], [100, 50, 0]],
            [[100, 50, 30], [0, 50, 30]],
            [[100, 0, 30], [0, 0, 30]],
        ],
        dtype=float,
    )
    poles = np.stack([e[0] + s * (e[1] - e[0]) for e in ends])
    assert prism_properties(Prism("C-00-00", knots, poles)).orientation < 0.0
