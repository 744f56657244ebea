"""Where the principal directions of a surface are not defined.

Glossary
--------
umbilic
    A point where both principal curvatures are equal. Flat ones are those where both vanish.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, IntArray
from fabgeo.surfaces.base import DesignSurface, SurfacePoints

NEARLY = 6.0  # times the limit of an umbilic, up to which one is looked for around
STEPS = 12  # of that search


@dataclass(frozen=True)
class Umbilic:
    """A place where principal directions are not defined or hardly: point, curvatures there."""

    point: Array
    kappa: Array

    def __str__(self) -> str:
        x, y, z = self.point
        return (
            f"umbilic near ({x:.4g}, {y:.4g}, {z:.4g}): principal curvatures "
            f"{self.kappa[0]:.3g} and {self.kappa[1]:.3g}"
        )


def anisotropy(at: SurfacePoints) -> Array:
    """|k1 - k2| / (|k1| + |k2|) of (k,) points: 0 at an umbilic, 2 / 2 = 1 for a cylinder."""
    kappa, _ = at.principal()
    total = np.abs(kappa).sum(axis=1)
    return np.abs(kappa[:, 0] - kappa[:, 1]) / np.maximum(total, 1e-300)


def umbilics(surface: DesignSurface, count: int = 600, least: float = 0.05) -> list[Umbilic]:
    """Places near `count` samples where principal directions are hardly defined.

    Where both principal curvatures are small against those of the whole surface, it is flat:
    these count by their difference over the surface's median, else by their anisotropy. From
    the most umbilic samples the way goes down to the most umbilic place near by; neighbouring
    ones are merged.
    """
    at = surface.sample(count)
    size = float(np.linalg.norm(surface.bounds[1] - surface.bounds[0]))
    usual = max(float(np.median(np.abs(at.principal()[0]).sum(axis=1))), 1e-6 / size)
    ratio = _umbilic(at, usual)
    order = np.argsort(ratio)
    order = order[ratio[order] < NEARLY * least]
    chosen = _apart(at.point, order, 0.1 * size)
    if not chosen:
        return []
    point, ratio = _descended(surface, at.point[chosen], usual, 1.5 * size / np.sqrt(count))
    order = np.argsort(ratio)
    chosen = _apart(point, order[ratio[order] < least], 0.1 * size)
    if not chosen:
        return []
    found = surface.closest(point[chosen])
    return [Umbilic(p, k) for p, k in zip(found.point, found.principal()[0], strict=True)]


def _umbilic(at: SurfacePoints, usual: float) -> Array:
    """Difference of the principal curvatures over their sum, or over a usual one if larger."""
    kappa, _ = at.principal()
    return np.abs(kappa[:, 0] - kappa[:, 1]) / np.maximum(np.abs(kappa).sum(axis=1), usual)


def _apart(points: Array, order: IntArray, distance: float) -> list[int]:
    """Of indices in their order those whose points (k, 3) lie apart from all before them."""
    found: list[int] = []
    for k in order:
        if all(np.linalg.norm(points[k] - points[o]) > distance for o in found):
            found.append(int(k))
    return found


def _descended(
    surface: DesignSurface, points: Array, usual: float, reach: float
) -> tuple[Array, Array]:
    """The most umbilic points (k, 3) within about `reach` of given ones, by a search in the plane.

    Each looks at six places around it, and nearer ones where none of these is more umbilic.
    """
    at = surface.closest(points)
    best, ratio = at.point, _umbilic(at, usual)
    turn = np.pi / 3.0 * np.arange(6)
    step = np.full(len(best), reach / 2.0)
    for _ in range(STEPS):
        _, axes = at.principal()
        around = np.einsum("a,ki->kai", np.cos(turn), axes[:, 0])
        around += np.einsum("a,ki->kai", np.sin(turn), axes[:, 1])
        tried = surface.closest((best[:, None] + step[:, None, None] * around).reshape(-1, 3))
        values = _umbilic(tried, usual).reshape(-1, 6)
        which = np.argmin(values, axis=1)
        better = values[np.arange(len(best)), which] < ratio
        ratio = np.where(better, values.min(axis=1), ratio)
        places = tried.point.reshape(-1, 6, 3)[np.arange(len(best)), which]
        best = np.where(better[:, None], places, best)
        step = np.where(better, step, step / 2.0)
        at = surface.closest(best)
    return best, ratio
