"""Strips parted along their rulings are the same surface."""

from __future__ import annotations

import numpy as np
import pytest

from fabgeo.errors import InputError
from fabgeo.strips.measures import measure
from fabgeo.strips.model import StripModel


def ring(closed: bool) -> StripModel:
    """Four edges around an axis, their points moved at random."""
    moved = np.random.default_rng(3).normal(scale=0.1, size=(4, 9, 3))
    angle = np.arange(4)[:, None] * np.pi / 2.0
    radius = np.linspace(3.0, 9.0, 9)
    flat = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.0 * radius + 0 * angle], -1)
    return StripModel(flat + moved, closed_i=closed)


@pytest.mark.parametrize("closed", [False, True])
def test_the_parts_lie_on_the_rulings_of_their_strip(closed):
    model = ring(closed)
    counts = [3, 1, 2, 4][: model.strips]
    parts = model.divided(counts)
    assert parts.strips == sum(counts)
    assert parts.closed_i == closed
    u = model.parameters(5)
    first, second = model.pairs(model.points(u))
    begin, end = parts.pairs(parts.points(u))
    at = 0
    for strip, count in enumerate(counts):
        for k in range(count):
            for edge, v in ((begin[at], k / count), (end[at], (k + 1) / count)):
                on = (1.0 - v) * first[strip] + v * second[strip]
                np.testing.assert_allclose(edge, on, atol=1e-12)
            at += 1


def test_parts_are_as_wide_and_as_straight_as_they_should_be():
    model = ring(True)
    parts = model.divided(2)
    whole, halves = measure(model), measure(parts)
    assert halves.width_max.value == pytest.approx(whole.width_max.value / 2.0, rel=1e-12)
    assert halves.width_min.value == pytest.approx(whole.width_min.value / 2.0, rel=1e-12)


@pytest.mark.parametrize("counts", [0, [1, 2], [2, 0, 1]])
def test_counts_that_divide_nothing_are_refused(counts):
    with pytest.raises(InputError, match="3 strips"):
        ring(False).divided(counts)
