"""A net over a surface that has no parametrisation: from its boundary loops alone.

One loop: four corners are found, the four sides span a Coons patch, relaxed on the surface. Two
loops: a tube or ring, the loops are joined and relaxed. More loops: holes are ignored, the longest
loop rules.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

from fabgeo.arrays import Array, IntArray, checked, cross, unit
from fabgeo.errors import InputError
from fabgeo.fitting.starts.net import Net
from fabgeo.fitting.starts.polyline import even
from fabgeo.surfaces.base import DesignSurface

SLIT = 0.05  # area of a hole over that of a disc of its perimeter: below, it is a slit


def net_of_loops(
    surface: DesignSurface, size: int = 25, corners: npt.ArrayLike | None = None
) -> tuple[Net, str]:
    """A net over the surface from its boundary.

    Parameters
    ----------
    surface : DesignSurface
    size : int
        Nodes along each side.
    corners : (4, 3) array_like, optional
        Points beside which the longest loop is divided into four sides; found if not given.

    Returns
    -------
    net : Net
        One loop: `size` x `size`. Two loops: rows from the first loop to the second, columns round
        (closed in t).
    note : str
        What was found.

    Raises
    ------
    InputError
        If the surface has no boundary.
    """
    loops = sorted((_opened(loop) for loop in surface.loops), key=_length, reverse=True)
    if not loops:
        raise InputError(surface.name, "has no boundary to lay a net between", "give sections")
    if corners is None and len(loops) == 2 and _is_tube(surface, loops):
        net = _ring(surface, loops[0], loops[1], size)
        return net, "a tube between its two boundary loops"
    found = corners_of(loops[0]) if corners is None else _nearest(surface, loops[0], corners)
    net = _patch(surface, loops[0], found, size)
    places = ", ".join("({:.4g}, {:.4g}, {:.4g})".format(*loops[0][k]) for k in found)
    note = f"a four-sided domain between corners of the boundary at {places}"
    if len(loops) > 1:
        note += f"; {len(loops) - 1} inner loops ignored"
    return net, note


def _nearest(surface: DesignSurface, loop: Array, corners: npt.ArrayLike) -> IntArray:
    """Indices of the loop's points nearest to four given ones, in the loop's order."""
    given = checked("corners", corners, (4, 3))
    found = np.unique(KDTree(loop).query(given)[1])
    if len(found) < 4:
        raise InputError(
            "corners",
            f"two of the four are nearest to the same point of the boundary of {surface.name}",
            "name four points beside its longest boundary loop",
        )
    return found


def corners_of(loop: Array, window: float = 0.02) -> IntArray:
    """Indices of four corners of a loop (k, 3), in order.

    Where the loop turns most, at least a tenth of its length apart; a loop without clear corners
    gets the four that a rectangle in its own principal axes would have.
    """
    length = _length(loop)
    step = np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1)
    arc = np.concatenate([[0.0], np.cumsum(step)[:-1]])
    reach = window * length
    ahead = _at(loop, arc, arc + reach, length) - loop
    behind = loop - _at(loop, arc, arc - reach, length)
    turn = np.arccos(np.clip(np.einsum("ij,ij->i", unit(ahead), unit(behind)), -1.0, 1.0))
    chosen: list[int] = []
    for k in np.argsort(-turn):
        away = [min(abs(arc[k] - arc[c]), length - abs(arc[k] - arc[c])) for c in chosen]
        if turn[k] > np.radians(30.0) and all(a > 0.08 * length for a in away):
            chosen.append(int(k))
        if len(chosen) == 4:
            return np.sort(np.array(chosen))
    return _rectangle_corners(loop)


def _rectangle_corners(loop: Array) -> IntArray:
    centre = loop.mean(axis=0)
    _, _, axes = np.linalg.svd(loop - centre, full_matrices=False)
    flat = (loop - centre) @ axes[:2].T
    flat = flat / np.abs(flat).max(axis=0)
    signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    return np.sort(np.argmax(flat @ signs.T, axis=0))


def _patch(surface: DesignSurface, loop: Array, corners: IntArray, size: int) -> Net:
    sides = [
        even(_between(loop, int(a), int(b)), size)
        for a, b in zip(corners, np.roll(corners, -1), strict=True)
    ]
    bottom, right, top, left = sides[0], sides[1], sides[2][::-1], sides[3][::-1]
    x = np.linspace(0.0, 1.0, size)
    s, t = x[:, None, None], x[None, :, None]
    ruled = (1 - s) * bottom[None] + s * top[None] + (1 - t) * left[:, None] + t * right[:, None]
    bilinear = (
        (1 - s) * (1 - t) * bottom[0]
        + (1 - s) * t * bottom[-1]
        + s * (1 - t) * top[0]
        + s * t * top[-1]
    )
    return Net(_relaxed(surface, ruled - bilinear, False))


def _ring(surface: DesignSurface, first: Array, second: Array, size: int) -> Net:
    around = 2 * size
    a, b = _resample_closed(first, around), _resample_closed(second, around)
    candidates = [np.roll(x, -k, axis=0) for x in (b, b[::-1]) for k in range(around)]
    b = min(candidates, key=lambda x: float(np.sum((x - a) ** 2)))
    s = np.linspace(0.0, 1.0, size)[:, None, None]
    return Net(_relaxed(surface, (1 - s) * a[None] + s * b[None], True), False, True)


def _relaxed(surface: DesignSurface, grid: Array, closed_t: bool, rounds: int = 30) -> Array:
    """Interior points moved towards the mean of their neighbours and back to the surface."""

    def projected(points: Array) -> Array:
        return surface.closest(points.reshape(-1, 3)).point.reshape(points.shape)

    inner = slice(1, -1), slice(None) if closed_t else slice(1, -1)
    grid = grid.copy()
    grid[inner] = projected(grid[inner])
    for _ in range(rounds):
        mean = (np.roll(grid, 1, 0) + np.roll(grid, -1, 0)) / 4.0
        mean += (np.roll(grid, 1, 1) + np.roll(grid, -1, 1)) / 4.0
        grid[inner] = projected(mean[inner])
    return grid


def _is_tube(surface: DesignSurface, loops: list[Array]) -> bool:
    """Two loops of comparable length bound a tube; a small one beside a large one is a hole.

    So is one that surrounds next to nothing, however long: a slit, as under a fin.
    """
    long, short = (_length(loop) for loop in loops)
    return short > 0.12 * long and 4.0 * np.pi * _surrounded(loops[1]) > SLIT * short**2


def _surrounded(loop: Array) -> float:
    """Area of the loop in the projection that shows most of it."""
    arms = loop - loop.mean(axis=0)
    return float(np.linalg.norm(cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)) / 2.0)


def _opened(loop: Array) -> Array:
    gap = np.linalg.norm(loop[0] - loop[-1])
    return loop[:-1] if gap <= 1e-9 * _length(loop) else loop


def _length(loop: Array) -> float:
    return float(np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1).sum())


def _at(loop: Array, arc: Array, wanted: Array, length: float) -> Array:
    x, y = np.append(arc, length), np.vstack([loop, loop[:1]])
    return np.stack([np.interp(np.mod(wanted, length), x, y[:, k]) for k in range(3)], axis=1)


def _between(loop: Array, a: int, b: int) -> Array:
    return np.roll(loop, -a, axis=0)[: (b - a) % len(loop) + 1]


def _resample_closed(loop: Array, count: int) -> Array:
    return even(np.vstack([loop, loop[:1]]), count + 1)[:-1]
