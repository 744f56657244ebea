"""Whether edges can end on a boundary curve: rulings along it must be conjugate to the edges.

Glossary
--------
lean
    The angle between the boundary's normal direction in the surface and the direction conjugate to
    the boundary: how far edges must lean to have rulings along the boundary. 90 degrees where the
    boundary runs in an asymptotic direction: there no edge can end with a ruling along it.
"""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array, cross, unit
from fabgeo.fitting.starts.net import Net
from fabgeo.surfaces.base import DesignSurface

STEEP = 75.0  # degrees of lean from which an end is said not to hold


def leans(net: Net, surface: DesignSurface, end: float, count: int = 96) -> tuple[Array, Array]:
    """Lean (k,) in degrees along the end t = 0 or 1 of a net, and the points (k, 3)."""
    s = (np.arange(count) + 0.5) / count
    t = np.full(count, end)
    at = surface.closest(net.evaluate(s, t))
    along = unit(net.evaluate(s, t, 1, 0))
    across = cross(at.normal, along)
    bend = np.einsum("kij,kj->ki", at.shape, along)
    own, mixed = np.einsum("ki,ki->k", bend, along), np.einsum("ki,ki->k", bend, across)
    scale = 1e-6 / float(np.linalg.norm(surface.bounds[1] - surface.bounds[0]))
    lean = np.degrees(np.arctan2(np.abs(mixed), np.abs(own)))
    return np.where(np.hypot(own, mixed) < scale, 0.0, lean), at.point


def steep_ends(net: Net, surface: DesignSurface) -> tuple[tuple[bool, bool], list[str]]:
    """Which of the two ends of the edges can't be held on the boundary, and where."""
    steep, notes = [False, False], []
    for k in () if net.closed_t else (0, 1):
        lean, points = leans(net, surface, float(k))
        # On nearly flat or single-curved borders a few places are harmless.
        steep[k] = float(np.mean(lean > STEEP)) > 0.05
        if steep[k]:
            x, y, z = points[int(np.argmax(lean))]
            notes.append(
                f"the boundary at the edges' {'end' if k else 'start'} runs close to an asymptotic "
                f"direction of the surface, most at ({x:.4g}, {y:.4g}, {z:.4g}) (edges would lean "
                f"{lean.max():.0f} deg): no developable strips end along it; overhang and trim"
            )
    return (steep[0], steep[1]), notes
