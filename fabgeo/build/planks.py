"""What the schedule says of geodesic strips as planks: how straight they lie, and edge to edge."""

from __future__ import annotations

from typing import Any

import numpy as np

from fabgeo.build.seams import nearest
from fabgeo.panels.flat import FlatPart
from fabgeo.sheets.boards import opposite_congruence, plank
from fabgeo.strips.ruled import RuledPatch
from fabgeo.strips.within import Span
from fabgeo.structures.parts import Plate


def plank_row(
    one: tuple[Plate, FlatPart],
    beside: tuple[Plate | None, FlatPart | None],
    seam: bool = False,
) -> dict[str, Any]:
    """How straight a geodesic strip lies, and how far its edge to the next is from opposite.

    Its plank is its flat length and width; parts without two long edges have no figures. Across a
    `seam` between two models u is not common to both.
    """
    (plate, flat), (other, its_flat) = one, beside
    edges = {edge.name: edge for edge in flat.outline}
    if not {"first", "second"} <= edges.keys():
        return {}
    found = plank(flat)
    row: dict[str, Any] = {"plank_sag_mm": found.sag, "plank_yield": found.yield_}
    across = [e for e in its_flat.outline if e.name == "first"] if its_flat is not None else []
    if other is not None and its_flat is not None and across and across[0].shared == flat.mark:
        here, there = _common(plate.mid, other.mid, seam)
        common = _of_edge(plate, flat, 1, here), _of_edge(other, its_flat, 0, there)
        row["edge_congruence_mm"] = opposite_congruence(edges["second"], across[0], common)
    return row


def _common(one: RuledPatch, other: RuledPatch, seam: bool) -> tuple[Span, Span]:
    """Which u of a patch's second edge, and of the next one's first, have the other across."""
    if not seam:
        span = max(one.u0, other.u0), min(one.u1, other.u1)
        return span, span
    ends = [patch.edges(np.array([patch.u0, patch.u1])) for patch in (one, other)]
    (low, high), (begin, end) = nearest(ends[1][0], one, 1)[0], nearest(ends[0][1], other, 0)[0]
    return (float(low), float(high)), (float(begin), float(end))


def _of_edge(plate: Plate, flat: FlatPart, side: int, span: Span) -> Span:
    """Which part of an edge's length lies within a span of u, in the outline's sense."""
    u = np.unique(np.concatenate([plate.mid.parameters(16), span]))
    way = np.linalg.norm(np.diff(plate.mid.edges(u)[side], axis=0), axis=-1).cumsum()
    low, high = np.interp(span, u, np.append(0.0, way / way[-1])).tolist()
    name = ("first", "second")[side]
    begin = next(e for e in flat.outline if e.name == name).points[0]
    assert flat.refold is not None  # unfold states it
    ends = flat.refold[[0, -1], side, :2]
    forward = np.linalg.norm(begin - ends[0]) <= np.linalg.norm(begin - ends[1])
    return (low, high) if forward else (1.0 - high, 1.0 - low)
