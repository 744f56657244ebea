"""Long parts cut into pieces at rulings, so that each fits its stock.

Glossary
--------
piece
    A part of a patch between two rulings; its mark is the whole's with a letter: ``P-03-07a``.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline

from fabgeo.arrays import Array
from fabgeo.errors import GeometryError
from fabgeo.panels.unfold import smallest_rectangle
from fabgeo.panels.unfold_develop import develop
from fabgeo.strips.ruled import RuledPatch

MOST_PIECES = 100
LEAST = 0.25  # of its rulings' length: shorter pieces are no panels


def split_at_rulings(mid: RuledPatch, cuts: Array) -> list[RuledPatch]:
    """Cut a ruled patch at parameters strictly inside, exactly, by knot insertion."""
    cuts = np.sort(np.asarray(cuts, dtype=np.float64))
    if len(cuts) == 0:
        return [mid]
    if cuts[0] <= mid.u0 or cuts[-1] >= mid.u1:
        raise GeometryError("split", f"expected cuts inside ({mid.u0:g}, {mid.u1:g}), found {cuts}")
    curve = BSpline(mid.knots, np.moveaxis(mid.poles, 1, 0), 3)
    for cut in cuts:
        there = int(np.count_nonzero(curve.t == cut))
        if there < 4:
            curve = curve.insert_knot(float(cut), 4 - there)
    ends = [mid.u0, *cuts, mid.u1]
    pieces = []
    for low, high in pairwise(ends):
        start = int(np.searchsorted(curve.t, low, side="right")) - 4
        stop = int(np.searchsorted(curve.t, high, side="left")) + 4
        knots = curve.t[start:stop]
        poles = np.moveaxis(np.asarray(curve.c)[start : stop - 4], 0, 1)
        pieces.append(RuledPatch(knots, poles))
    return pieces


def split_to_fit(
    mid: RuledPatch, mark: str, rooms: Sequence[tuple[float, float]], gap: float = 0.0
) -> list[tuple[str, RuledPatch]]:
    """Cut a patch at rulings into the fewest even pieces that each fit one of the rooms.

    Parameters
    ----------
    rooms : sequence of (length, width)
        mm, usable sizes of the stock (margins taken off); the longer side of a piece's smallest
        rectangle lies along the first.
    gap : float
        mm, joint left open between two pieces, half of it taken off each.

    Returns
    -------
    list of (mark, RuledPatch)
        The patch itself under its own mark if it fits.

    Raises
    ------
    GeometryError
        If no number of pieces fits: its rulings are longer than the stock is wide.
    """
    spans = _spans(mid, mark, rooms, gap)
    if len(spans) == 1:
        return [(mark, mid)]
    every = split_at_rulings(mid, np.unique(spans.ravel())[1:-1])
    kept = every[:: 2 if gap > 0.0 else 1]
    return [(f"{mark}{_letters(k)}", piece) for k, piece in enumerate(kept)]


def cuts_to_fit(
    mid: RuledPatch, mark: str, rooms: Sequence[tuple[float, float]]
) -> tuple[float, ...]:
    """Parameters of the fewest cuts, evenly along the middle, after which every piece fits.

    Raises
    ------
    GeometryError
        As `split_to_fit`.
    """
    return tuple(_spans(mid, mark, rooms)[1:, 0].tolist())


def pieces_fit(
    mid: RuledPatch, cuts: Sequence[float], rooms: Sequence[tuple[float, float]]
) -> bool:
    """Whether every piece between given cuts fits one of the rooms, laid flat."""
    flat = develop(mid)
    spans = pairwise([mid.u0, *cuts, mid.u1])
    return all(_fits(flat.rule.breaks, flat.edges, span, rooms) for span in spans)


def _spans(
    mid: RuledPatch, mark: str, rooms: Sequence[tuple[float, float]], gap: float = 0.0
) -> Array:
    """Parameter intervals (n, 2) of the fewest even pieces that fit."""
    flat = develop(mid, mark)
    middle = flat.edges.mean(axis=0)
    way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(middle, axis=0), axis=-1)))
    wide = float(np.linalg.norm(flat.edges[1] - flat.edges[0], axis=-1).max())
    for count in range(1, MOST_PIECES + 1):
        if count > 1 and way[-1] / count < LEAST * wide:
            break
        ends = np.linspace(0.0, way[-1], count + 1)
        low = ends[:-1] + np.where(np.arange(count) > 0, gap / 2.0, 0.0)
        high = ends[1:] - np.where(np.arange(count) < count - 1, gap / 2.0, 0.0)
        spans = np.interp(np.stack([low, high], axis=-1), way, flat.rule.breaks)
        if all(_fits(flat.rule.breaks, flat.edges, span, rooms) for span in spans):
            return spans
    sizes = " or ".join(f"{length:g} x {width:g}" for length, width in rooms)
    raise GeometryError(
        mark, f"fits {sizes or 'no'} mm in no number of pieces", "choose wider stock"
    )


def _letters(k: int) -> str:
    """Count by letters: a to z, then aa, ab and so on."""
    return (_letters(k // 26 - 1) if k >= 26 else "") + chr(97 + k % 26)


def _fits(
    breaks: Array, edges: Array, span: Sequence[float] | Array, rooms: Sequence[tuple[float, float]]
) -> bool:
    inside = (breaks > span[0]) & (breaks < span[1])
    ends = [
        [np.interp(u, breaks, edges[k, :, j]) for j in range(2)] for k in range(2) for u in span
    ]
    points = np.concatenate([edges[:, inside].reshape(-1, 2), np.array(ends)])
    _, long, short = smallest_rectangle(points)
    return any(long <= length and short <= width for length, width in rooms)
