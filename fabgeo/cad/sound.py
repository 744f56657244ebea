"""Is a prism a body at all? Judged by numbers before the kernel sees it.

The kernel's own checker passes folded offsets with a positive volume, so the sign of the
Jacobian is taken here. Every point of a section is an average of the section's vertices; if all
vertices move to the same side of every section's plane, so does every point between them, and
the prism can't fold.

Glossary
--------
section
    The polygon of the edge curves' points at one u.
vector area
    Half the sum of the cross products around a polygon: its normal times its area.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

from fabgeo.arrays import Array, cross, dot
from fabgeo.errors import PartError
from fabgeo.structures.parts import Prism

SMALLEST = 0.01
"""Sides, heights and lengths below this (mm) make a sliver."""

_FOLD = 1e-3
"""The slowest vertex moves forward at this fraction of the fastest one, at least."""

_PER_SPAN = 4


def vector_area(polygon: Array) -> Array:
    """Vector areas (..., 3) of closed polygons (..., N, 3)."""
    relative = polygon - polygon[..., :1, :]
    return 0.5 * cross(relative[..., 1:-1, :], relative[..., 2:, :]).sum(axis=-2)


def check_prism(prism: Prism, smallest: float = SMALLEST) -> bool:
    """Refuse prisms that are no body.

    Parameters
    ----------
    prism : Prism
    smallest : float
        Least side, height and length in mm.

    Returns
    -------
    bool
        Whether c_u x (c_{j+1} - c_j) points outwards (the section's normal against u).

    Raises
    ------
    PartError
        If the prism is a sliver, its section crosses itself, or it folds over.
    """
    u = _sites(prism.knots)
    curve = BSpline(prism.knots, np.moveaxis(prism.poles, 1, 0), 3)
    sections = np.asarray(curve(u))
    area = vector_area(sections)
    size = np.linalg.norm(area, axis=1)
    _refuse_slivers(prism, sections, size, smallest)
    normal = area / size[:, None]
    forward = dot(np.asarray(curve(u, 1)), normal[:, None, :])
    fastest = np.abs(forward).max()
    slowest = forward.min() if forward.sum() > 0.0 else -forward.max()
    if slowest < _FOLD * fastest:
        k, j = np.unravel_index(np.argmin(forward * np.sign(forward.sum())), forward.shape)
        x, y, z = sections[k, j]
        raise PartError(
            prism.mark,
            f"folds over: edge curve {j} runs backwards or stands still at u = {u[k]:.4g}, near "
            f"({x:.1f}, {y:.1f}, {z:.1f}) mm",
            "take an offset or width smaller than the radius of curvature there",
        )
    _refuse_crossed(prism, sections, normal)
    return bool(forward.sum() < 0.0)


def _sites(knots: Array) -> Array:
    spans = np.unique(knots)
    inner = spans[:-1, None] + np.arange(_PER_SPAN) / _PER_SPAN * np.diff(spans)[:, None]
    return np.append(inner.ravel(), spans[-1])


def _refuse_slivers(prism: Prism, sections: Array, area: Array, smallest: float) -> None:
    sides = np.linalg.norm(np.roll(sections, -1, axis=1) - sections, axis=2)
    steps = np.linalg.norm(np.diff(sections, axis=0), axis=2).sum(axis=0)
    height = area / np.maximum(sides.max(axis=1), 1e-300)
    for what, value in (
        ("shortest side", sides.min()),
        ("shortest edge curve", steps.min()),
        ("height of the section", height.min()),
    ):
        if value < smallest:
            raise PartError(
                prism.mark,
                f"is a sliver: its {what} is {value:.3g} mm, expected {smallest:g} mm or more",
                "merge it with its neighbour or cut elsewhere",
            )


def _refuse_crossed(prism: Prism, sections: Array, normal: Array) -> None:
    """Two sides of one section that are not neighbours must not meet."""
    count = sections.shape[1]
    first, second = np.triu_indices(count, 2)
    keep = (first != 0) | (second != count - 1)
    i, j = first[keep], second[keep]
    a, b = sections[:, i], sections[:, (i + 1) % count]
    c, d = sections[:, j], sections[:, (j + 1) % count]
    n = normal[:, None, :]

    def side(p: Array, q: Array, r: Array) -> Array:
        return np.sign(dot(cross(q - p, r - p), n))

    crossed = (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)
    if crossed.any():
        k, pair = np.argwhere(crossed)[0]
        x, y, z = sections[k].mean(axis=0)
        raise PartError(
            prism.mark,
            f"its section crosses itself (sides {i[pair]} and {j[pair]}) near "
            f"({x:.1f}, {y:.1f}, {z:.1f}) mm",
            "take a smaller depth or joint width",
        )
