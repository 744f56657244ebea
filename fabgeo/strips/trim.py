"""Trim an overhanging strip model to the boundary of its design surface.

A ruling keeps the part whose closest points lie inside the surface. Every trimmed piece is again a
ruled patch: its edges run on the strip's own rulings, either along the strip's edges or along the
boundary. Where the boundary runs so close to the rulings that they get too short, the piece ends at
the last whole enough ruling: what is lost there is told as an area, never hidden.

Glossary
--------
inside
    A test of points (k, 3): whether they are kept. `Fence` is that of an overhanging model.
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
from fabgeo.arrays import Array, BoolArray, IntArray, cross, set_frozen
from fabgeo.strips.fence import Fence
from fabgeo.strips.model import Patch, StripModel
from fabgeo.strips.ruled import RuledPatch
from fabgeo.surfaces.base import DesignSurface

__all__ = [
    "Fence",
    "StripTrim",
    "TrimmedPatch",
    "TrimmedRuled",
    "limits",
    "trim",
    "trimmed_patch",
    "trimmed_patches",
    "trimmed_ruled",
]

type Inside = Callable[[Array], BoolArray]
type Edges = Callable[[Array], tuple[Array, Array]]

ACROSS = 9  # places on a ruling that are tested before the limits are searched
PARTS, ROUNDS = 16, 5  # limits are found to 16 ** -5 of what they are known to before
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
class TrimmedRuled:
    """The part of a ruled patch that is inside.

    Attributes
    ----------
    ruled : RuledPatch
        Its rulings are parts of the patch's; u keeps its meaning.
    outline : (k, 2) array
        Closed outline in (u, v) of the patch, the first point not repeated.
    share : float
        Kept part of the patch's area.
    lost : float
        Area inside that is not kept, as its rulings are too short.
    """

    ruled: RuledPatch
    outline: Array
    share: float
    lost: float

    @property
    def whole(self) -> bool:
        """Whether nothing was cut away."""
        return self.share == 1.0


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
    return _limits(_of_strip(model, strip), _within(surface), u)


def _limits(edges: Edges, inside: Inside, u: Array) -> tuple[Array, Array]:
    first, second = edges(u)
    v = np.linspace(0.0, 1.0, ACROSS)
    within = _inside(inside, first, second, np.broadcast_to(v, (len(u), ACROSS)))
    low, high = np.full(len(u), np.nan), np.full(len(u), np.nan)
    begin, end = _longest(within)
    some = np.flatnonzero(end > begin)
    low[some], high[some] = v[begin[some]], v[end[some] - 1]
    cut = some[begin[some] > 0]
    low[cut] = _bisect(inside, first[cut], second[cut], low[cut], v[begin[cut] - 1])
    cut = some[end[some] < ACROSS]
    high[cut] = _bisect(inside, first[cut], second[cut], high[cut], v[end[cut]])
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
    inside = _within(surface)
    found = []
    for strip in range(model.strips):
        edges = _of_strip(model, strip)
        low, high = _limits(edges, inside, u)
        found.append(StripTrim(strip, u, low, high, _intervals(edges, inside, u, low)))
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
    ruled = RuledPatch.of_model(model, patch)
    found = trimmed_ruled(ruled, _within(surface), least, patch.u1 - patch.u0, spans_per_segment)
    if found is None:
        return None
    kept = Patch(patch.strip, patch.cell, found.ruled.u0, found.ruled.u1)
    return TrimmedPatch(kept, found.ruled, found.outline, found.share)


def trimmed_ruled(
    ruled: RuledPatch,
    inside: Inside,
    least: float = LEAST,
    segments: float = 1.0,
    spans_per_segment: int = 2,
) -> TrimmedRuled | None:
    """The part of a ruled patch that is inside, or None if there is none.

    Parameters
    ----------
    least : float
        The piece ends where less than this part of its rulings is inside.
    segments : float
        Knot spans that the patch has on its model: how finely it is tested and cut.
    """
    count = max(int(np.ceil(8 * segments)), 8) + 1
    u = np.linspace(ruled.u0, ruled.u1, count)
    edges = _of_ruled(ruled)
    low, high = _limits(edges, inside, u)
    width = np.where(np.isfinite(low), high - low, 0.0)
    begin, end = (int(k[0]) for k in _longest((width > least)[None]))
    if end == begin:
        return None
    some = _touches(edges, inside)

    def stop(good: int, bad: int) -> float:
        """Where the width falls to `least`, taken to fall evenly to nothing."""
        nothing = _last_u(some, u[good], u[bad])
        return nothing + (u[good] - nothing) * min(least / width[good], 1.0)

    u0 = u[0] if begin == 0 else stop(begin, begin - 1)
    u1 = u[-1] if end == count else stop(end - 1, end)
    if u1 - u0 < 1e-6 * (u[-1] - u[0]):
        return None
    if u0 == u[0] and u1 == u[-1] and low.max() == 0.0 and high.min() == 1.0:
        outline = np.array([[u0, 0.0], [u1, 0.0], [u1, 1.0], [u0, 1.0]])
        return TrimmedRuled(ruled, outline, 1.0, 0.0)
    spans = max(int(np.ceil(spans_per_segment * segments * (u1 - u0) / (u[-1] - u[0]))), 2)
    cut, outline = _through(edges, inside, (float(u0), float(u1)), (u, low, high), spans)
    area, kept = _grid_area(*edges(np.linspace(u[0], u[-1], 65))), _ruled_area(cut)
    return TrimmedRuled(cut, outline, kept / area, max(_area_inside(edges, inside, u) - kept, 0.0))


def trimmed_patches(
    model: StripModel, patches: Sequence[Patch], surface: DesignSurface, least: float = LEAST
) -> list[TrimmedPatch]:
    """All patches trimmed; those wholly outside are left out."""
    found = (trimmed_patch(model, p, surface, least) for p in patches)
    return [p for p in found if p is not None]


def _through(
    edges: Edges,
    inside: Inside,
    ends: tuple[float, float],
    tested: tuple[Array, Array, Array],
    spans: int,
) -> tuple[RuledPatch, Array]:
    """Interpolated edges along the limits, with threefold knots at kinks."""
    u, low, high = tested
    kinks = _kinks(edges, inside, u, low == 0.0, 0.0)
    kinks += _kinks(edges, inside, u, high == 1.0, 1.0)
    near = 1e-3 * (ends[1] - ends[0])
    breaks = [ends[0]]
    for k in sorted(kinks):
        if k - breaks[-1] > near and ends[1] - k > near:
            breaks.append(k)
    breaks.append(ends[1])
    knots = [ends[0]]
    for a, b in pairwise(breaks):
        own = max(int(np.ceil(spans * (b - a) / (ends[1] - ends[0]))), 2)
        knots += [a] * 3 + list(np.linspace(a, b, own + 1)[1:-1])
    all_knots = np.array([*knots, *[ends[1]] * 4])
    sites = spline.greville(all_knots)
    at_low, at_high = _limits(edges, inside, sites)
    good = np.isfinite(at_low)
    at_low = np.interp(sites, sites[good], at_low[good])
    at_high = np.interp(sites, sites[good], at_high[good])
    first, second = edges(sites)
    a = first + at_low[:, None] * (second - first)
    b = first + at_high[:, None] * (second - first)
    outline = np.concatenate(
        [np.stack([sites, at_low], axis=1), np.stack([sites, at_high], axis=1)[::-1]]
    )
    return RuledPatch.through(all_knots, sites, a, b), outline


def _kinks(edges: Edges, inside: Inside, u: Array, whole: BoolArray, v: float) -> list[float]:
    """Parameters at which the edge v = 0 or 1 crosses the boundary."""

    def kept(at: Array) -> BoolArray:
        rows = at.ravel()
        return _inside(inside, *edges(rows), np.full((len(rows), 1), v)).reshape(at.shape)

    changes = np.flatnonzero(whole[1:] != whole[:-1])
    good = np.where(whole[changes], u[changes], u[changes + 1])
    bad = np.where(whole[changes], u[changes + 1], u[changes])
    return [float(found) for found in _last(kept, good, bad)]


def _intervals(
    edges: Edges, inside: Inside, u: Array, low: Array
) -> tuple[tuple[float, float], ...]:
    some = _touches(edges, inside)
    good = np.isfinite(low)
    starts = np.flatnonzero(good & ~np.concatenate([[False], good[:-1]]))
    ends = np.flatnonzero(good & ~np.concatenate([good[1:], [False]]))
    return tuple(
        (
            float(u[a]) if a == 0 else _last_u(some, u[a], u[a - 1]),
            float(u[b]) if b == len(u) - 1 else _last_u(some, u[b], u[b + 1]),
        )
        for a, b in zip(starts, ends, strict=True)
    )


def _touches(edges: Edges, inside: Inside) -> Callable[[Array], BoolArray]:
    """A test whether anything of the rulings at u is inside."""

    def test(at: Array) -> BoolArray:
        rows = at.ravel()
        v = np.broadcast_to(np.linspace(0.0, 1.0, ACROSS), (len(rows), ACROSS))
        return _inside(inside, *edges(rows), v).any(axis=1).reshape(at.shape)

    return test


def _of_strip(model: StripModel, strip: int) -> Edges:
    return lambda u: (model.edge(strip, u), model.edge(strip + 1, u))


def _of_ruled(ruled: RuledPatch) -> Edges:
    def edges(u: Array) -> tuple[Array, Array]:
        first, second = ruled.edges(u)
        return first, second

    return edges


def _within(surface: DesignSurface) -> Inside:
    return lambda points: ~surface.closest(points).on_boundary


def _inside(inside: Inside, first: Array, second: Array, v: Array) -> BoolArray:
    """Whether the points at v (k, m) of k rulings are inside: (k, m)."""
    points = first[:, None] + v[..., None] * (second - first)[:, None]
    return inside(points.reshape(-1, 3)).reshape(v.shape)


def _bisect(inside: Inside, first: Array, second: Array, good: Array, bad: Array) -> Array:
    """The last v inside between one inside and one outside, for many rulings at once."""
    return _last(lambda v: _inside(inside, first, second, v), good, bad)


def _last(test: Callable[[Array], BoolArray], good: Array, bad: Array) -> Array:
    """The last values (k,) before the test fails first between good and bad: parted in `PARTS`.

    `test` takes values (k, PARTS - 1), a row for each of the k.
    """
    rows = np.arange(len(good))
    for _ in range(ROUNDS if len(good) else 0):
        grid = good[:, None] + np.linspace(0.0, 1.0, PARTS + 1) * (bad - good)[:, None]
        failed = np.ones((len(good), PARTS), dtype=bool)
        failed[:, :-1] = ~test(grid[:, 1:-1])
        first = np.argmax(failed, axis=1)
        good, bad = grid[rows, first], grid[rows, first + 1]
    return good


def _last_u(test: Callable[[Array], BoolArray], good: float, bad: float) -> float:
    return float(_last(test, np.array([good]), np.array([bad]))[0])


def _area_inside(edges: Edges, inside: Inside, u: Array) -> float:
    """Area inside, by cells of a fine grid."""
    first, second = edges(np.linspace(u[0], u[-1], 2 * len(u) - 1))
    v = np.linspace(0.0, 1.0, 17)
    grid = first[:, None] + v[:, None] * (second - first)[:, None]
    a, b = grid[1:, :-1] - grid[:-1, :-1], grid[:-1, 1:] - grid[:-1, :-1]
    size = np.linalg.norm(cross(a, b), axis=-1)
    middle = (grid[1:, 1:] + grid[:-1, :-1]) / 2.0
    return float(np.sum(size.ravel()[inside(middle.reshape(-1, 3))]))


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
    halves = cross(b - a, c - a), cross(c - d, b - d)
    return float(sum(np.linalg.norm(h, axis=1).sum() for h in halves) / 2.0)
