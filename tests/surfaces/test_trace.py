"""Traced curves against closed forms: circles of a torus, great circles, helices."""

from __future__ import annotations

import numpy as np
import pytest

from fabgeo.arrays import dot, unit
from fabgeo.surfaces.formula import FormulaSurface
from fabgeo.surfaces.trace import (
    both_ways,
    conjugate_direction,
    trace_geodesics,
    trace_principal,
)
from fabgeo.surfaces.trace_extension import Extended
from fabgeo.surfaces.umbilics import anisotropy, umbilics

SPHERE = FormulaSurface(
    "cos(u)*cos(v)", "sin(u)*cos(v)", "sin(v)", (-1.2, 1.2), (-1.2, 1.2), name="sphere"
)
TORUS = FormulaSurface(
    "(5 + 2*cos(v))*cos(u)", "(5 + 2*cos(v))*sin(u)", "2*sin(v)", (-1.5, 1.5), (-1.5, 1.5)
)
PARABOLOID = FormulaSurface("u", "v", "0.1*u**2 + 0.1*v**2 + 0.05*u**3", (-2, 2), (-2, 2))


def test_principal_lines_of_a_torus_are_circles():
    start = np.array([[7.0, 0.0, 0.0]])
    ring = trace_principal(TORUS, start, np.array([[0.0, 1.0, 0.0]]), 0.1, 60)[0]
    assert np.abs(np.hypot(ring[:, 0], ring[:, 1]) - 7.0).max() < 1e-7
    assert np.arctan2(ring[-1, 1], ring[-1, 0]) == pytest.approx(6.0 / 7.0, abs=1e-7)
    tube = trace_principal(TORUS, start, np.array([[0.0, 0.0, 1.0]]), 0.1, 20)[0]
    assert np.abs(tube[:, 1]).max() < 1e-7
    assert tube[-1, 2] == pytest.approx(2.0 * np.sin(1.0), abs=1e-7)


def test_geodesics_of_a_sphere_are_great_circles():
    direction = unit(np.array([[0.0, 1.0, 0.7]]))
    line, tangent = trace_geodesics(SPHERE, np.array([[1.0, 0.0, 0.0]]), direction, 0.05, 20)
    s = 0.05 * np.arange(21)[:, None]
    assert np.abs(line[0] - np.cos(s) * [1, 0, 0] - np.sin(s) * direction).max() < 1e-7
    assert np.abs(tangent[0] + np.sin(s) * [1, 0, 0] - np.cos(s) * direction).max() < 1e-7


def test_geodesic_error_falls_with_the_fourth_power():
    start, along = np.array([[6.5, 1.0, 1.2]]), np.array([[-0.2, 1.0, 0.3]])
    ends = [trace_geodesics(TORUS, start, along, 2.0 / n, n)[0][0, -1] for n in (4, 8, 64)]
    coarse, fine = (np.linalg.norm(e - ends[2]) for e in ends[:2])
    assert fine < coarse / 10.0


def test_clairaut_holds_along_a_geodesic_of_revolution():
    start, along = np.array([[6.5, 0.0, 1.3]]), np.array([[0.0, 1.0, 0.5]])
    line, tangent = trace_geodesics(TORUS, start, along, 0.05, 60)
    radius = np.hypot(line[0, :, 0], line[0, :, 1])
    around = np.stack([-line[0, :, 1], line[0, :, 0], 0 * radius], axis=1) / radius[:, None]
    momentum = radius * dot(around, tangent[0])
    assert np.ptp(momentum) < 1e-6 * momentum[0]


def test_curves_both_ways_join_at_their_start():
    start = np.array([[7.0, 0.0, 0.0]])
    lines, middle = both_ways(
        lambda x, d: trace_principal(TORUS, x, d, 0.1, 5), start, np.array([[0.0, 1.0, 0.0]])
    )
    assert lines.shape == (1, 11, 3)
    assert np.allclose(lines[0, middle], start[0])
    assert np.allclose(lines[0, :, 1], -lines[0, ::-1, 1], atol=1e-9)


def test_conjugate_directions_see_no_mixed_curvature():
    at = TORUS.sample(50)
    along = unit(np.cross(at.normal, np.array([0.3, 0.5, 0.8])))
    other = conjugate_direction(at, along)
    assert np.abs(np.einsum("ki,kij,kj->k", along, at.shape, other)).max() < 1e-12


def test_umbilics_are_found_where_they_are():
    # Principal curvatures of z = a(u^2 + v^2) + c u^3 agree at the origin.
    found = umbilics(PARABOLOID, 900, 0.08)
    assert np.linalg.norm(found[0].point) < 0.25
    assert "umbilic near" in str(found[0])
    assert anisotropy(SPHERE.sample(50)).max() < 1e-6


def test_umbilics_of_an_ellipsoid_and_of_a_monkey_saddle():
    # Of axes a > b > c: at x^2 = a^2 (a^2 - b^2) / (a^2 - c^2), y = 0.
    ellipsoid = FormulaSurface(
        "12*cos(u)*cos(v)", "8*sin(u)*cos(v)", "5*sin(v)", (0.0, 2.0 * np.pi), (0.3, 1.4)
    )
    x = [found.point for found in umbilics(ellipsoid)]
    there = 12.0 * np.sqrt((144 - 64) / (144 - 25)), 5.0 * np.sqrt((64 - 25) / (144 - 25))
    assert len(x) == 2
    assert np.abs(np.sort([p[0] for p in x]) - (-there[0], there[0])).max() < 0.05
    assert np.abs([(p[1], p[2] - there[1]) for p in x]).max() < 0.05
    # Its only umbilic is flat: beside it the curvatures differ in sign alone.
    monkey = FormulaSurface("u", "v", "(u**3 - 3*u*v**2)/60", (-5.1, 5), (-5, 5.3))
    (flat,) = umbilics(monkey)
    assert np.linalg.norm(flat.point) < 0.05


def test_the_continuation_meets_the_surface_smoothly():
    # A paraboloid's own continuation is itself, to the third order of the distance.
    bowl = FormulaSurface("u", "v", "0.05*u**2 + 0.02*v**2", (-2, 2), (-2, 2))
    extended = Extended(bowl, reach=1.0)
    errors = []
    for d in (0.1, 0.2):
        x, y = np.full(9, 2.0 + d), np.linspace(-1.5, 1.5, 9)
        truth = np.stack([x, y, 0.05 * x**2 + 0.02 * y**2], axis=1)
        at = extended.closest(truth)
        errors.append(np.abs(dot(truth - at.point, at.normal)).max())
        assert not at.on_boundary.any()
    assert errors[0] < 1e-4
    assert errors[1] < 10.0 * errors[0]
    inside = np.array([[0.5, 0.5, 1.0]])
    assert np.array_equal(extended.closest(inside).point, bowl.closest(inside).point)
    assert extended.beyond(np.array([[2.5, 0.0, 0.2]]))[0] > 0.4
