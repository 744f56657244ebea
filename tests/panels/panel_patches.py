"""Patches cut from exact planes, cylinders and cones, and strip models in closed form."""

from __future__ import annotations

import numpy as np

from fabgeo import spline
from fabgeo.arrays import Array
from fabgeo.panels.samples import PanelInput, Side
from fabgeo.strips.model import Patch, StripModel
from fabgeo.strips.ruled import RuledPatch


def motion(rng: np.random.Generator, reach: float = 1e5) -> tuple[Array, Array]:
    """A random rotation and translation."""
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q)), rng.uniform(-reach, reach, 3)


def exact_patch(
    kind: str,
    rng: np.random.Generator,
    opening: float = 0.3,
    radius: float = 5000.0,
    length: float = 1500.0,
    half_angle: float = 0.3,
    trim: float = 80.0,
    noise: float = 0.0,
    spans: int = 64,
) -> RuledPatch:
    """A trimmed patch in any position; with smooth noise of that size along the normal."""
    knots = spline.clamped_knots(0.0, float(spans), spans)
    sites = spline.greville(knots)
    s = sites / spans
    wave = trim * np.sin(rng.uniform(2, 4) * s + rng.uniform(0, 6))
    turn = (s - 0.5) * opening
    circle = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], -1)
    up = np.array([0.0, 0.0, 1.0])
    if kind == "cylinder":
        a = radius * circle + wave[:, None] * up
        b = radius * circle + (length - 0.5 * wave)[:, None] * up
        normal = circle
    elif kind == "cone":
        ray = np.sin(half_angle) * circle + np.cos(half_angle) * up
        near = radius / np.tan(half_angle)  # where the normal curvature is 1 / radius
        a, b = ray * (near + wave)[:, None], ray * (near + length - 0.5 * wave)[:, None]
        normal = np.cos(half_angle) * circle - np.sin(half_angle) * up
    else:
        a = np.stack([radius * opening * s, wave, 0.0 * s], -1)
        b = a + np.array([50.0, length, 0.0])
        normal = np.broadcast_to(up, a.shape)
    if noise:
        for edge in (a, b):
            swing = np.sin(rng.uniform(1, 7) * s + rng.uniform(0, 6.3))
            edge += noise * swing[:, None] * normal
    q, o = motion(rng)
    return RuledPatch.through(knots, sites, a @ q + o, b @ q + o)


def cone_strips(strips: int = 5, segments: int = 24) -> StripModel:
    """Strips between similar ellipses in parallel planes: general cones, all developable."""
    i, u = np.arange(strips + 1)[:, None], np.arange(segments + 1)[None]
    turn, z = u / segments * 1.2, i * 1500.0 + 0.0 * u
    r = 20000.0 + 3000.0 * np.sin(i / strips * 1.5) + 0.0 * u
    points = np.stack([1.3 * r * np.cos(turn), r * np.sin(turn), z], -1)
    return StripModel(spline.interpolate(points))


def panels_of(model: StripModel, cells: int) -> list[PanelInput]:
    """Panels of a strip model cut at even parameters, with their neighbours."""
    breaks, out = np.linspace(0.0, model.segments, cells + 1), []
    for s in range(model.strips):
        for c in range(cells):
            beside: dict[Side, tuple[int, int]] = {
                "first": (s - 1, c),
                "second": (s + 1, c),
                "start": (s, c - 1),
                "end": (s, c + 1),
            }
            inside = {
                side: Patch(i, j, 0.0, 1.0).mark
                for side, (i, j) in beside.items()
                if 0 <= i < model.strips and 0 <= j < cells
            }
            patch = Patch(s, c, float(breaks[c]), float(breaks[c + 1]))
            out.append(PanelInput(patch.mark, RuledPatch.of_model(model, patch), inside))
    return out
