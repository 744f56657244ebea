"""Panel classes over the tolerance, every panel by itself: closed forms."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import make_interp_spline

from fabgeo.arrays import Array
from fabgeo.panels.pool import CLASSES
from fabgeo.panels.samples import PanelInput
from fabgeo.panels.tradeoff import by_deviation, trade_off
from fabgeo.strips.ruled import RuledPatch

RADIUS, ANGLE, WIDTH = 30_000.0, 0.12, 1500.0


def ruled(first: Array, second: Array) -> RuledPatch:
    """The patch between two curves (n, 3), sampled alike."""
    sites = np.linspace(0.0, 1.0, len(first))
    curve = make_interp_spline(sites, np.concatenate([first, second], axis=1), k=3)
    poles = np.asarray(curve.c)
    return RuledPatch(curve.t, np.stack([poles[:, :3], poles[:, 3:]]))


def arc(radius: float, y: float) -> Array:
    turn = ANGLE * (np.linspace(0.0, 1.0, 13) - 0.5)
    return np.stack([radius * np.sin(turn), np.full(13, y), radius * np.cos(turn)], axis=1)


def test_a_panel_takes_the_simplest_class_that_its_deviation_allows() -> None:
    flat = np.stack([np.linspace(0.0, 3000.0, 13), np.zeros(13), np.zeros(13)], axis=1)
    panels = [
        PanelInput("P-00-00", ruled(flat, flat + np.array([0.0, WIDTH, 0.0])), {}),
        PanelInput("P-00-01", ruled(arc(RADIUS, 0.0), arc(RADIUS, WIDTH)), {}),
        PanelInput("P-00-02", ruled(arc(RADIUS, 0.0), arc(0.9 * RADIUS, WIDTH)), {}),
    ]
    # The best plane halves the arc's rise.
    half = 0.5 * RADIUS * (1.0 - np.cos(0.5 * ANGLE))
    rows = by_deviation(panels, (0.1, 0.97 * half, 1.03 * half, 1.5 * half))
    counts = [[row[name] for name in CLASSES] for row in rows]
    assert counts[0] == [1, 1, 1, 0]
    assert counts[1][0] <= 2
    assert counts[2][0] >= 2
    assert all(sum(own) == 3 for own in counts)
    assert [own[0] for own in counts] == sorted(own[0] for own in counts)


def test_no_panels_have_no_classes() -> None:
    assert by_deviation([]) == []


def test_the_shops_radii_hold_at_every_tolerance() -> None:
    radii = (RADIUS, 1.02 * RADIUS)
    panels = [
        PanelInput(
            f"P-0{k}-00", ruled(arc(r, 2.0 * k * WIDTH), arc(r, (2.0 * k + 1.0) * WIDTH)), {}
        )
        for k, r in enumerate(radii)
    ]
    free = next(trade_off(panels, (1.0,), (1.0,)))
    shared = next(trade_off(panels, (1.0,), (1.0,), radii=1))
    assert (free.radii, free.cylinder) == (2, 1.0)
    assert shared.radii == 1
