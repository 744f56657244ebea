"""Poles of a chart between its samples: where its points run off to infinity, or there are none.

The cells of a coarse grid are quartered again and again, each time to the quarter in whose middle
the second derivatives are largest. Where the chart is smooth the quarters are soon alike; towards a
pole they never are, and first derivatives grow without end. A pole so weak that a sample next to it
sees nothing of it among the rest of the formula is not found.
"""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array
from fabgeo.surfaces.chart import Chart

CELLS = 32  # along each side
ROUND, ROUNDS = 5, 8  # quarterings of a round, and how many there are
UNLIKE = 2.0  # second derivatives of two quarters, once a round at least: towards log(u) it is 9
NOISE = 1e-9  # second derivative over the usual first one that is none
POLE = 1e9  # growth of first derivatives in all: towards log(u) it is 1e12, towards sqrt(u) 1e6
_QUARTERS = np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]])


def pole_of(chart: Chart) -> tuple[float, float] | None:
    """Parameters of a pole of the chart, or of a point that it lacks; None where none is found."""
    low, width = chart.domain[:, 0], np.diff(chart.domain)[:, 0]
    middles = (np.arange(CELLS) + 0.5) / CELLS
    at = np.stack(np.meshgrid(middles, middles, indexing="ij"), axis=-1).reshape(-1, 2)
    size = 0.5 / CELLS  # from a cell's middle to its sides
    slopes, _ = _derivatives(chart, low, width, at)
    usual = float(np.median(slopes))
    if np.isinf(slopes).any():
        return _place(low, width, at[np.argmax(slopes)])
    for _ in range(ROUNDS):
        unlike = np.zeros(len(at), dtype=bool)
        for _ in range(ROUND):
            size /= 2.0
            quarters = at[:, None] + size * _QUARTERS
            slope, bend = _derivatives(chart, low, width, quarters.reshape(-1, 2))
            slope, bend = slope.reshape(-1, 4), bend.reshape(-1, 4)
            rows, best = np.arange(len(at)), np.argmax(bend, axis=1)
            at, slopes, bends = quarters[rows, best], slope[rows, best], bend[rows, best]
            unlike |= bends > np.maximum(UNLIKE * bend.min(axis=1), NOISE * usual)
            if np.isinf(slopes).any():
                return _place(low, width, at[np.argmax(slopes)])
        at, slopes = at[unlike], slopes[unlike]
        if not len(at):
            return None
    worst = int(np.argmax(slopes))
    return _place(low, width, at[worst]) if slopes[worst] > POLE * usual else None


def _place(low: Array, width: Array, at: Array) -> tuple[float, float]:
    u, v = low + width * at
    return float(u), float(v)


def _derivatives(chart: Chart, low: Array, width: Array, at: Array) -> tuple[Array, Array]:
    """Sizes of first and second derivatives (k,) by parameters `at` (k, 2) that run from 0 to 1.

    Both are infinite where the chart has no point.
    """
    d = chart.evaluate(*(low + width * at).T)
    u, v = width
    first = np.maximum(np.abs(d.u * u), np.abs(d.v * v)).max(axis=-1)
    second = np.abs(np.stack([d.uu * u * u, d.uv * u * v, d.vv * v * v])).max(axis=(0, -1))
    lacking = ~np.isfinite(d.point).all(axis=-1)
    # On a cone's very apex there is a point all the same.
    known = np.isfinite(first) & np.isfinite(second)
    sizes = np.where(known, np.stack([first, second]), 0.0)
    first, second = np.where(lacking, np.inf, sizes)
    return first, second
