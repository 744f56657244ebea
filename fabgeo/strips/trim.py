"""Trim an overhanging strip model to the boundary of its design surface.

A ruling keeps the part whose closest points lie inside the surface. Every trimmed piece is again a
ruled patch: its edges run on the strip's own rulings, either along the strip's edges or along the
boundary.

Glossary
--------
limits
    The parameters v of a ruling between which it lies inside: 0 and 1 where it is whole.
kink
    A u at which the boundary crosses an edge curve: the trimmed patch's edge has a corner there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fabgeo import spline
from fabgeo.arrays import Array, BoolArray, IntArray, set_frozen
from fabgeo.strips.model import Patch, StripModel
from fabgeo.strips.ruled import RuledPatch
from fabgeo.surfaces.base import DesignSurface

ACROSS = 9  # places on a ruling that are tested before the limits are bisected
BISECTIONS = 16
LEAST = 0.02  # part of a ruling below which a patch ends: no slivers


@dataclass(frozen=True)
class StripTrim:
    """Where the rulings of one strip lie inside the surface.

    Attributes
    ----------
    strip : int
    u, low, high : (k,) arrays
        Limits v of the rulings at u; nan where nothing of a ruling is inside.
    intervals : tuple of (float, float)
        The u-intervals in which something of the strip is inside.
    """

    strip: int
    u: Array
    low: Array
    high: Array
    intervals: tuple[tuple[float, float], ...]

    def __post_init__(self) -> None:
        set_frozen(self, "u", ("k",))


@dataclass(frozen=True)
class TrimmedPatch:
    """The part of a patch inside the boundary.

    Attributes
    ----------
    patch : Patch
        The patch, its u-interval shortened to what is inside.
    ruled : RuledPatch
        The trimmed ruled surface; its rulings are parts of the strip's.
    outline : (k, 2) array
        Closed outline in (u, v) of the strip, the first point not repeated.
    share : float
        Part of the patch's area that is kept.
    """

    patch: Patch
    ruled: RuledPatch
    outline: Array
    share: float

    @property
    def whole(self) -> bool:
        """Whether nothing was cut away."""
        return self.share > 1.0 - 1e-9


def limits(model: StripModel, strip: int, surface: DesignSurface, u: Array) -> tuple[Array, Array]:
    """Limits v (k,) of the rulings of a strip at u (k,); nan where none is inside.

    Of a ruling that leaves and enters again the longest part counts.
    """
    first, second = _ends(model, strip, u)
    v = np.linspace(0.0, 1.0, ACROSS)
    inside = _inside(surface, first, second, np.broadcast_to(v, (len(u), ACROSS)))
    low, high = np.full(len(u), np.nan), np.full(len(u), np.nan)
    begin, end = _longest(inside)
    some = np.flatnonzero(end > begin)
    low[some], high[some] = v[begin[some]], v[end[some] - 1]
    cut = some[begin[some] > 0]
    low[cut] = _bisect(surface, first[cut], second[cut], low[cut], v[begin[cut] - 1])
    cut = some[end[some] < ACROSS]
    high[cut] = _bisect(surface, first[cut], second[cut], high[cut], v[end[cut]])
    return low, high


def trim(model: StripModel, surface: DesignSurface, per_segment: int = 8) -> list[StripTrim]:
    """What of every strip lies inside the surface's boundary.

    Parameters
    ----------
    model : StripModel
        Overhanging or not.
    surface : DesignSurface
        The surface itself, not its continuation.
    per_segment : int
        Rulings tested in a knot span.
    """
    u = model.parameters(per_segment)
    found = []
    for strip in range(model.strips):
        low, high = limits(model, strip, surface, u)
        found.append(StripTrim(strip, u, low, high, _intervals(model, strip, surface, u, low)))
    return found


def trimmed_patch(
    model: StripModel,
    patch: Patch,
    surface: DesignSurface,
    least: float = LEAST,
    spans_per_segment: int = 2,
) -> TrimmedPatch | None:
    """The part of a patch inside the boundary, or None if there is none.

    Parameters
    ----------
    least : float
        The patch ends where less than this part of its rulings is inside.
    spans_per_segment : int
        Knot spans of the trimmed edges in a segment of the model.
    """
    count = max(int(np.ceil(8 * (patch.u1 - patch.u0))), 8) + 1
    u = patch.parameters(count)
    low, high = limits(model, patch.strip, surface, u)
    width = np.where(np.isfinite(low), high - low, 0.0)
    begin, end = (int(k[0]) for k in _longest((width > least)[None]))
    if end == begin:
        return None

    some = _touches(model, patch.strip, surface)

    def stop(good: int, bad: int) -> float:
        """Where the width falls to `least`, taken to fall evenly to nothing."""
        nothing = _bisect_u(some, u[good], u[bad])
        return nothing + (u[good] - nothing) * min(least / width[good], 1.0)

    u0 = u[0] if begin == 0 else stop(begin, begin - 1)
    u1 = u[-1] if end == count else stop(end - 1, end)
    if u1 - u0 < 1e-6 * (patch.u1 - patch.u0):
        return None
    kept = Patch(patch.strip, patch.cell, float(u0), float(u1))
    if u0 == patch.u0 and u1 == patch.u1 and low.max() == 0.0 and high.min() == 1.0:
        ruled = RuledPatch.of_model(model, kept)
        outline = np.array([[u0, 0.0], [u1, 0.0], [u1, 1.0], [u0, 1.0]])
        return TrimmedPatch(kept, ruled, outline, 1.0)
    ruled, outline = _through(model, kept, surface, u, low, high, spans_per_segment)
    area = _grid_area(*_ends(model, patch.strip, patch.parameters(65)))
    return TrimmedPatch(kept, ruled, outline, _ruled_area(ruled) / area)


def trimmed_patches(
    model: StripModel, patches: Sequence[Patch], surface: DesignSurface, least: float = LEAST
) -> list[TrimmedPatch]:
    """All patches trimmed; those wholly outside are left out."""
    found = (trimmed_patch(model, p, surface, least) for p in patches)
    return [p for p in found if p is not None]


def _through(
    model: StripModel,
    patch: Patch,
    surface: DesignSurface,
    u: Array,
    low: Array,
    high: Array,
    spans_per_segment: int,
) -> tuple[RuledPatch, Array]:
    """Interpolated edges along the limits, with threefold knots at kinks."""
    kinks = _kinks(model, patch, surface, u, low == 0.0, 0.0)
    kinks += _kinks(model, patch, surface, u, high == 1.0, 1.0)
    near = 1e-3 * (patch.u1 - patch.u0)
    breaks = [patch.u0]
    for k in sorted(kinks):
        if k - breaks[-1] > near and patch.u1 - k > near:
            breaks.append(k)
    breaks.append(patch.u1)
    knots = [patch.u0]
    for a, b in pairwise(breaks):
        spans = max(int(np.ceil(spans_per_segment * (b - a))), 2)
        knots += [a] * 3 + list(np.linspace(a, b, spans + 1)[1:-1])
    all_knots = np.array([*knots, *[patch.u1] * 4])
    sites = spline.greville(all_knots)
    at_low, at_high = limits(model, patch.strip, surface, sites)
    good = np.isfinite(at_low)
    at_low = np.interp(sites, sites[good], at_low[good])
    at_high = np.interp(sites, sites[good], at_high[good])
    first, second = _ends(model, patch.strip, sites)
    a = first + at_low[:, None] * (second - first)
    b = first + at_high[:, None] * (second - first)
    outline = np.concatenate(
        [np.stack([sites, at_low], axis=1), np.stack([sites, at_high], axis=1)[::-1]]
    )
    return RuledPatch.through(all_knots, sites, a, b), outline


def _kinks(
    model: StripModel, patch: Patch, surface: DesignSurface, u: Array, whole: BoolArray, v: float
) -> list[float]:
    """Parameters at which the edge v = 0 or 1 of the strip crosses the boundary."""

    def inside(at: float) -> bool:
        first, second = _ends(model, patch.strip, np.array([at]))
        return bool(_inside(surface, first, second, np.array([[v]]))[0, 0])

    found = []
    for k in np.flatnonzero(whole[1:] != whole[:-1]):
        a, b = (u[k], u[k + 1]) if whole[k] else (u[k + 1], u[k])
        found.append(_bisect_u(inside, a, b))
    return found


def _intervals(
    model: StripModel, strip: int, surface: DesignSurface, u: Array, low: Array
) -> tuple[tuple[float, float], ...]:
    inside = _touches(model, strip, surface)
    good = np.isfinite(low)
    starts = np.flatnonzero(good & ~np.concatenate([[False], good[:-1]]))
    ends = np.flatnonzero(good & ~np.concatenate([good[1:], [False]]))
    return tuple(
        (
            float(u[a]) if a == 0 else _bisect_u(inside, u[a], u[a - 1]),
            float(u[b]) if b == len(u) - 1 else _bisect_u(inside, u[b], u[b + 1]),
        )
        for a, b in zip(starts, ends, strict=True)
    )


def _touches(model: StripModel, strip: int, surface: DesignSurface) -> Callable[[float], bool]:
    """A test whether anything of the ruling at u is inside."""
    v = np.linspace(0.0, 1.0, ACROSS)[None]

    def test(at: float) -> bool:
        return bool(_inside(surface, *_ends(model, strip, np.array([at])), v).any())

    return test


def _ends(model: StripModel, strip: int, u: Array) -> tuple[Array, Array]:
    return model.edge(strip, u), model.edge(strip + 1, u)


def _inside(surface: DesignSurface, first: Array, second: Array, v: Array) -> BoolArray:
    """Whether the points at v (k, m) of k rulings lie inside the boundary: (k, m)."""
    points = first[:, None] + v[..., None] * (second - first)[:, None]
    return ~surface.closest(points.reshape(-1, 3)).on_boundary.reshape(v.shape)


def _bisect(surface: DesignSurface, first: Array, second: Array, good: Array, bad: Array) -> Array:
    """The last v inside between one inside and one outside, for many rulings at once."""
    good, bad = good.copy(), bad.copy()
    for _ in range(BISECTIONS if len(good) else 0):
        middle = (good + bad) / 2.0
        inside = _inside(surface, first, second, middle[:, None])[:, 0]
        good, bad = np.where(inside, middle, good), np.where(inside, bad, middle)
    return good


def _bisect_u(test: Callable[[float], bool], good: float, bad: float) -> float:
    for _ in range(BISECTIONS):
        middle = (good + bad) / 2.0
        good, bad = (middle, bad) if test(middle) else (good, middle)
    return float(good)


def _longest(inside: BoolArray) -> tuple[IntArray, IntArray]:
    """Begin and end (exclusive) of the longest run of True in every row."""
    rows, columns = inside.shape
    run = np.zeros((rows, columns + 1), dtype=np.int64)
    for k in range(columns):
        run[:, k + 1] = np.where(inside[:, k], run[:, k] + 1, 0)
    end = np.argmax(run, axis=1)
    return end - run[np.arange(rows), end], end


def _ruled_area(ruled: RuledPatch) -> float:
    first, second = ruled.edges(ruled.parameters(16))
    return _grid_area(first, second)


def _grid_area(first: Array, second: Array) -> float:
    """Area between two polylines of corresponding points, by triangles."""
    a, b, c, d = first[:-1], first[1:], second[:-1], second[1:]
    halves = np.cross(b - a, c - a), np.cross(c - d, b - d)
    return float(sum(np.linalg.norm(h, axis=1).sum() for h in halves) / 2.0)
