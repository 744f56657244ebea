"""Splines against scipy's, exact refinement and conversion, order of interpolation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline

from fabgeo import spline
from fabgeo.errors import InputError

RNG = np.random.default_rng(3)


@pytest.mark.parametrize("m", [1, 2, 3, 7])
def test_open_curves_agree_with_scipy_in_clamped_form(m: int) -> None:
    control = RNG.normal(size=(2, m + 3, 3))
    u = np.linspace(0.0, m, 41)
    knots, poles = spline.to_clamped(control)
    for order in range(3):
        ours = spline.evaluate(control, u, derivative=order)
        for i in range(2):
            theirs = BSpline(knots, poles[i], 3)(u, nu=order)
            np.testing.assert_allclose(ours[i], theirs, atol=1e-11)


@pytest.mark.parametrize("closed", [False, True])
def test_refinement_keeps_the_curve(closed: bool) -> None:
    control = RNG.normal(size=(8, 3))
    u = np.linspace(0.0, spline.segments_of(8, closed), 60)
    fine = spline.refine(control, closed)
    np.testing.assert_allclose(
        spline.evaluate(fine, 2 * u, closed), spline.evaluate(control, u, closed), atol=1e-14
    )


@pytest.mark.parametrize(
    ("closed", "u0", "u1"), [(False, 0.0, 5.0), (False, 1.3, 1.6), (True, 6.5, 10.25)]
)
def test_clipping_is_exact_also_over_the_seam(closed: bool, u0: float, u1: float) -> None:
    control = RNG.normal(size=(8, 3))
    knots, poles = spline.clip(control, closed, u0, u1)
    u = np.linspace(u0, u1, 33)
    np.testing.assert_allclose(
        BSpline(knots, poles, 3)(u), spline.evaluate(control, u, closed), atol=1e-13
    )


def test_interpolation_reproduces_cubics_and_falls_with_the_fourth_power() -> None:
    t = np.arange(12.0)[:, None]
    control = spline.interpolate(np.hstack([t, t**2, t**3]))
    u = np.linspace(0.0, 11.0, 200)
    np.testing.assert_allclose(spline.evaluate(control, u)[:, 2], u**3, atol=1e-9)
    errors = []
    for m in (16, 32, 64):
        angle = 2.0 * np.pi * np.arange(m) / m
        circle = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
        points = spline.evaluate(spline.interpolate(circle, True), np.linspace(0, m, 999), True)
        errors.append(np.abs(np.linalg.norm(points, axis=1) - 1.0).max())
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (orders > 3.8).all()


def test_greville_sites_stay_inside_their_interval() -> None:
    knots = spline.clamped_knots(0.0, 1.495133103, 3)
    sites = spline.greville(knots)
    assert sites[0] >= knots[0]
    assert sites[-1] <= knots[-1]
    assert len(sites) == len(knots) - 4


def test_too_few_points_are_refused() -> None:
    with pytest.raises(InputError, match="needs 4 points"):
        spline.interpolate(np.zeros((3, 3)))


NET = RNG.normal(size=(2, 7, 3))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: spline.evaluate(NET[:, :3], np.zeros(1)), "needs 4 control points"),
        (lambda: spline.evaluate(NET[:, :2], np.zeros(1), True), "needs 3 control points"),
        (lambda: spline.evaluate(NET, np.zeros((1, 1))), "expected parameters"),
        (lambda: spline.evaluate(None, np.zeros(1)), "evaluate: expected"),
        (lambda: spline.refine(NET[:, :3]), "needs 4 control points"),
        (lambda: spline.refine([1, 2, 3]), "2 dimensions or more"),
        (lambda: spline.to_clamped(NET[:, :3]), "needs 4 control points"),
        (lambda: spline.interpolate(np.full((30, 3), np.nan)), "not finite"),
        (lambda: spline.interpolate("abc"), "expected numbers"),
        (lambda: spline.greville(np.zeros(3)), "greville degree"),
        (lambda: spline.clamped_knots(1, 0, 2), "expected u0 < u1"),
        (lambda: spline.clamped_knots(0, 1, 10**12), "from 1 to 1,000,000"),
        (lambda: spline.clip(NET, False, 2.0, 1.0), "expected u0 < u1"),
        (lambda: spline.clip(NET, False, 0.0, np.nan), "clip u1"),
        (lambda: spline.clip(NET, True, 0.0, 1e9), "within a round"),
    ],
)
def test_what_is_no_curve_is_refused(call, words: str) -> None:
    with pytest.raises(InputError, match=words):
        call()


def test_lists_are_taken_as_arrays() -> None:
    u = np.linspace(0.0, 4.0, 9)
    np.testing.assert_array_equal(
        spline.evaluate(NET.tolist(), u.tolist()), spline.evaluate(NET, u)
    )
