"""Cutting strips into patches at rulings: by length, count, transport box or given parameters.

Where rulings are common to all strips, ruling polygons run through (what box shells need);
otherwise every strip is cut for itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fabgeo.arrays import Array, checked, checked_count, checked_number
from fabgeo.errors import InputError
from fabgeo.strips.integrate import antiderivative
from fabgeo.strips.model import Patch, StripModel
from fabgeo.structures.boxes import oriented_box

MOST_PATCHES = 1_000_000  # of a model
MOST_OF_A_STRIP = 100_000
TRANSPORT_BOX = (13_600.0, 2_480.0, 2_500.0)  # a common truck, mm


@dataclass(frozen=True)
class CutRule:
    """How strips are cut; exactly one of `length`, `count` and `at` (or `box` alone).

    Attributes
    ----------
    length : float, optional
        Target length of a patch along the strip's middle line, mm: the nearest whole number of
        equal patches.
    count : int, optional
        Patches to a strip.
    at : tuple of float, optional
        Parameters u of the cuts, ends not included.
    box : (3,) tuple, optional
        Every patch must fit this box (mm) in some position; alone or as a condition on top.
    common : bool
        The same rulings on all strips.
    """

    length: float | None = None
    count: int | None = None
    at: tuple[float, ...] | None = None
    box: tuple[float, float, float] | None = None
    common: bool = True

    def __post_init__(self) -> None:
        given = [x is not None for x in (self.length, self.count, self.at)]
        if sum(given) > 1 or not (any(given) or self.box):
            raise InputError("CutRule", "expected one of length, count, at (or box alone)")
        if self.length is not None:
            checked_number("CutRule.length", self.length, above=0.0)
        if self.count is not None:
            checked_count("CutRule.count", self.count, 1, MOST_OF_A_STRIP)
        if self.at is not None and (np.diff(np.sort(checked("cuts", self.at, (None,)))) <= 0).any():
            raise InputError("cuts", "hold a parameter twice", "name every ruling once")


def cut(
    model: StripModel, rule: CutRule, spans: Sequence[tuple[float, float]] | None = None
) -> list[Patch]:
    """Patches of all strips in order.

    Parameters
    ----------
    spans : sequence of (u0, u1), one a strip, optional
        The part of every strip that is kept (a trimmed model); all of it by default.
    """
    ranges = list(spans) if spans is not None else [(0.0, float(model.segments))] * model.strips
    if len(ranges) != model.strips:
        raise InputError("cut", f"expected {model.strips} spans, found {len(ranges)}")
    shared = None
    if rule.common and rule.at is None:
        low, high = min(r[0] for r in ranges), max(r[1] for r in ranges)
        shared = _divisions(model, None, (low, high), rule)
    patches = []
    for strip, (u0, u1) in enumerate(ranges):
        if rule.at is not None:
            inner = np.array(sorted(rule.at))
            if len(inner) and (inner[0] < 0.0 or inner[-1] > model.segments):
                raise InputError("CutRule.at", f"expected 0 <= u <= {model.segments}")
        else:
            inner = _divisions(model, strip, (u0, u1), rule) if shared is None else shared
        tiny = 1e-6 * (u1 - u0)
        inner = inner[(inner > u0 + tiny) & (inner < u1 - tiny)]
        bounds = np.concatenate([[u0], inner, [u1]])
        if len(patches) + len(bounds) - 1 > MOST_PATCHES:
            raise InputError(
                "panels",
                f"expected {MOST_PATCHES:,} panels at most, found more on {model.strips:,} strips",
                "ask for fewer, or longer ones",
            )
        patches += [
            Patch(strip, cell, float(a), float(b)) for cell, (a, b) in enumerate(pairwise(bounds))
        ]
    return patches


def _divisions(
    model: StripModel, strip: int | None, span: tuple[float, float], rule: CutRule
) -> Array:
    """Inner cuts of one strip (of the strip-average where None) at equal lengths."""
    lengths = _middle_length(model, strip)
    total = float(lengths(np.array([span[1]]))[0] - lengths(np.array([span[0]]))[0])
    count = rule.count or 1
    if rule.length is not None:
        if total > MOST_OF_A_STRIP * rule.length:
            raise InputError(
                "panels.length",
                f"{rule.length:g} mm divides a strip of {total:.4g} mm into more than "
                f"{MOST_OF_A_STRIP:,} panels",
                "ask for longer panels",
            )
        count = max(1, round(total / rule.length))
    rows = range(model.strips) if strip is None else [strip]
    while True:
        bounds = _equal(lengths, span, count)
        if rule.box is None or all(_fits(model, i, bounds, rule.box) for i in rows):
            return bounds[1:-1]
        count += 1
        if total / count < min(rule.box) / 50.0:
            raise InputError("CutRule.box", f"no patch fits {rule.box} mm", "use narrower strips")


def _middle_length(model: StripModel, strip: int | None) -> Callable[[Array], Array]:
    """Arc length of the strip's middle line (mean over strips where None) as function of u."""

    def speed(u: Array) -> Array:
        d0, d1 = model.pairs(model.points(u, 1))
        s = np.linalg.norm(d0 + d1, axis=-1) / 2.0
        return s.mean(axis=0) if strip is None else s[strip]

    return antiderivative(speed, model.segments, 2)


def _equal(lengths: Callable[[Array], Array], span: tuple[float, float], count: int) -> Array:
    """Parameters that divide the span into `count` pieces of equal length."""
    grid = np.linspace(span[0], span[1], 64 * max(8, int(span[1] - span[0]) + 1))
    s = lengths(grid)
    targets = np.linspace(s[0], s[-1], count + 1)
    u = np.interp(targets, s, grid)
    u[0], u[-1] = span
    return u


def _fits(model: StripModel, strip: int, bounds: Array, box: tuple[float, float, float]) -> bool:
    for a, b in pairwise(bounds):
        patch = Patch(strip, 0, float(a), float(b))
        points = np.concatenate(patch.edges(model, patch.parameters(9)))
        if np.any(np.sort(oriented_box(points).size) > np.sort(np.array(box)) + 1e-6):
            return False
    return True


def cut_lengths(model: StripModel, patches: Sequence[Patch]) -> Array:
    """Lengths (patches, 2) of the two edges of every patch, mm."""
    arc = antiderivative(lambda u: np.linalg.norm(model.points(u, 1), axis=-1), model.segments)
    out = np.empty((len(patches), 2))
    for row, patch in enumerate(patches):
        ends = arc(np.array([patch.u0, patch.u1]))
        for side in (0, 1):
            edge = (patch.strip + side) % model.edges
            out[row, side] = ends[edge, 1] - ends[edge, 0]
    return out
