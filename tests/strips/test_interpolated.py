"""Curves through splines: the error stated is the largest there is, also beside kinks."""

from __future__ import annotations

import numpy as np
import pytest

from fabgeo.errors import GeometryError
from fabgeo.strips.interpolated import interpolated, knots_between
from fabgeo.strips.ruled import RuledPatch

KINK = 4e-3  # rad


def kinked(u: np.ndarray, turn: float = KINK) -> np.ndarray:
    """Two curves (2, k, 3), in mm, that turn by an angle at u = 3."""
    x = 100.0 * u
    y = 1e-3 * x**2 + turn * np.maximum(x - 300.0, 0.0)
    return np.stack([np.stack([x, y + shift, 0.0 * u], axis=-1) for shift in (0.0, 50.0)])


def test_curves_with_small_kinks_are_met_by_short_spans_beside_these():
    made = interpolated(kinked, knots_between(0.0, 8.0, multiplicity=2), 1e-3, "flange")
    u = np.linspace(0.0, 8.0, 40_001)
    off = np.linalg.norm(RuledPatch(made.knots, made.poles).edges(u) - kinked(u), axis=-1)
    assert off.max() == pytest.approx(made.error, rel=0.5)
    assert off.max() < 1.5e-3
    spans = np.diff(np.unique(made.knots))
    assert spans.min() < 1 / 32 < 1.01 * np.median(spans)


def test_curves_with_sharp_kinks_are_refused_by_name():
    with pytest.raises(GeometryError, match="flange"):
        interpolated(lambda u: kinked(u, 1.0), knots_between(0.0, 8.0), 1e-3, "flange")
