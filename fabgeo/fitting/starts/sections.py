"""Start from planar parallel sections, such as floor slabs (paper, Fig. 2).

Edge curves are the sections. Developability asks for a constant tangent plane along a ruling, and
the section's tangent lies in it at both ends: points correspond where tangents are parallel.

Sections are first given a common parameter, half arc length and half turning of the tangent, and
a common origin by their shape; then the correspondence is solved for parallel tangents
(`conjugate_parameters`), which also holds where sections are concave.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from fabgeo.arrays import Array, checked, shown, unit
from fabgeo.errors import InputError
from fabgeo.fitting.starts.draw import model_of_net
from fabgeo.fitting.starts.iso import iso_net
from fabgeo.fitting.starts.net import Net
from fabgeo.fitting.starts.polyline import even, spread
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import DesignSurface

AROUND = 128  # points of a section in the net


def sections_start(
    surface: DesignSurface,
    strips: int | None,
    segments: int | None,
    direction: Any = None,
    seed: Sequence[npt.ArrayLike] | None = None,
    *,
    heights: npt.ArrayLike | None = None,
    **options: Any,
) -> tuple[StripModel, list[str]]:
    """Edges along planar parallel sections, rulings between parallel tangents.

    Parameters
    ----------
    direction : (3,) array_like, optional
        Normal of the section planes, (0, 0, 1) by default.
    seed : sequence of (k, 3) array_like, optional
        The sections themselves, in order; by default the surface's own (`sections`), or those
        where the planes at `heights` cut it.
    heights : array_like, optional
        Heights of the planes along `direction`; evenly spread if there are no sections given.
    """
    own_sections = getattr(surface, "sections", None)
    if direction is None and own_sections is not None and seed is None:
        direction = own_sections.normal
    normal = unit(checked("direction", (0.0, 0.0, 1.0) if direction is None else direction, (3,)))
    if seed is not None:
        if isinstance(seed, str | bytes) or not np.iterable(seed):
            raise InputError("seed", f"expected sections as curves of points, found {shown(seed)}")
        net = net_of_sections([checked("section", c, (None, 3)) for c in seed], normal)
        own, note = len(net.points) - 1, f"{len(net.points)} sections given"
    elif own_sections is not None and heights is None:
        net = Net(own_sections.grid(AROUND), False, own_sections.closed)
        own, note = len(net.points) - 1, f"the surface's own {len(net.points)} sections"
    else:
        net, own = cut(surface, normal, strips, heights)
        note = f"{own + 1} planar sections cut"
    places = np.linspace(0.0, 1.0, own + 1) if strips in (None, own) else None
    strips = own if strips is None else strips
    model, notes = model_of_net(net, surface, strips, segments, places=places, **options)
    return model, [note, *notes]


def net_of_sections(sections: list[Array], normal: Array, around: int = AROUND) -> Net:
    """A net whose rows are the sections, with a common parameter and origin.

    Raises
    ------
    InputError
        If there are fewer than two, some closed and some open, or one not planar.
    """
    if len(sections) < 2:
        raise InputError("sections", f"expected two or more, found {len(sections)}")
    closed = [_is_closed(c) for c in sections]
    if any(closed) and not all(closed):
        odd = closed.index(not closed[0])
        words = ("open", "closed")
        raise InputError(
            f"section {odd}",
            f"is {words[closed[odd]]} while section 0 is {words[closed[0]]}",
            "close all sections or none",
        )
    rows: list[Array] = []
    for k, section in enumerate(sections):
        height = section @ normal
        size = float(np.ptp(section, axis=0).max())
        if np.ptp(height) > 1e-3 * size:
            raise InputError(
                f"section {k}",
                f"leaves its plane by {np.ptp(height):.3g}",
                "give planar sections, or another direction",
            )
        row = _common(section, closed[0], around)
        rows.append(row if not rows else _aligned(rows[-1], row, closed[0]))
    return Net(np.stack(rows), False, closed[0])


def cut(
    surface: DesignSurface, normal: Array, strips: int | None, heights: npt.ArrayLike | None
) -> tuple[Net, int]:
    """Sections where planes cut the surface, on a net whose columns rise along the normal.

    Raises
    ------
    InputError
        If the surface's net does not rise along the direction.
    """
    net, _ = iso_net(surface)
    for candidate in (net, net.turned):
        if candidate.closed_s:
            continue
        rise = np.diff(candidate.points @ normal, axis=0)
        if np.all(rise > 0.0) or np.all(rise < 0.0):
            break
    else:
        raise InputError(
            surface.name, "its parameter lines do not rise steadily through the sections",
            "give the sections, or another direction",
        )  # fmt: skip
    s = np.linspace(0.0, 1.0, 129)
    t = _stations(AROUND, candidate.closed_t)
    dense = candidate.sampled(s, t)
    high = dense @ normal
    if heights is None:
        low, top = (np.sort([h.max(), h.min()]) for h in (high[0], high[-1]))
        ends = (low[1], top[0]) if low.mean() < top.mean() else (low[0], top[1])
        wanted = np.linspace(*ends, (strips or 12) + 1)
    else:
        wanted = checked("heights", heights, (None,))
    order = 1 if high[0].mean() < high[-1].mean() else -1
    rows = np.empty((len(wanted), dense.shape[1], 3))
    for j in range(dense.shape[1]):
        place = np.interp(wanted, high[::order, j], s[::order])
        rows[:, j] = candidate.evaluate(place, np.full(len(place), t[j]))
    rows += (wanted[:, None] - rows @ normal)[..., None] * normal
    if candidate.closed_t:
        rows = np.concatenate([rows, rows[:, :1]], axis=1)
    return net_of_sections(list(rows), normal), len(wanted) - 1


def _common(section: Array, closed: bool, around: int) -> Array:
    """Points at even steps of half arc length, half turning."""
    line = np.vstack([section[:-1], section[:1]]) if closed and _is_closed(section) else section
    fine = even(line, 8 * around + 1)
    step = unit(np.diff(fine, axis=0))
    turn = np.arccos(np.clip(np.einsum("ij,ij->i", step[:-1], step[1:]), -1.0, 1.0))
    if closed:
        last = np.arccos(np.clip(step[-1] @ step[0], -1.0, 1.0))
        bend = (np.append(turn, last) + np.append(last, turn)) / 2.0
    else:
        bend = (np.append(turn, 0.0) + np.append(0.0, turn)) / 2.0
    # Spread the turning of a corner over its neighbourhood, so that it keeps some points.
    reach = np.ones(2 * around // 8 + 1)
    mode = np.pad(bend, len(reach) // 2, mode="wrap" if closed else "edge")
    smooth = np.convolve(mode, reach / len(reach), mode="valid")
    weight = 1.0 / len(step) + smooth / max(float(smooth.sum()), 1e-12)
    points = spread(fine, weight, around + 1)
    return points[:-1] if closed else points


def _aligned(before: Array, row: Array, closed: bool) -> Array:
    """The row in the sense, and from the origin, in which it is most like the one before."""
    shifts = range(len(row)) if closed else (0,)
    ways = [np.roll(r, -k, axis=0) for r in (row, row[::-1]) for k in shifts]

    def unlike(way: Array) -> float:
        shape = before - before.mean(axis=0) - way + way.mean(axis=0)
        turned = unit(np.gradient(before, axis=0)) - unit(np.gradient(way, axis=0))
        return float(np.sum(shape**2) / np.sum((before - before.mean(axis=0)) ** 2)) + float(
            np.mean(np.sum(turned**2, axis=1))
        )

    return min(ways, key=unlike)


def _is_closed(section: Array) -> bool:
    length = np.linalg.norm(np.diff(section, axis=0), axis=1).sum()
    return bool(np.linalg.norm(section[0] - section[-1]) < 1e-6 * length)


def _stations(count: int, closed: bool) -> Array:
    return np.linspace(0.0, 1.0, count + 1)[: count if closed else None]
