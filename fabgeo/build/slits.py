"""Slits: what stays open between two panels of a strip where a piece too small to make lay.

Cutting along the boundary parts a panel at rulings, and drops pieces that are shorter along the
strip than can be made. The panels beside such a piece face each other across more than a joint:
how wide the slit is stands in their rows, as a gap does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fabgeo.arrays import Array, dot, unit

if TYPE_CHECKING:
    from fabgeo.build.trimming import Cut

PLACES = 33  # on a ruling, where the slit is measured
WIDEST = 250.0  # mm: what lies farther off is across an opening of the surface


@dataclass(frozen=True)
class Slit:
    """What is open between the end of one panel and the start of the next.

    Attributes
    ----------
    panels : (str, str)
    width : float
        The largest, in mm.
    """

    panels: tuple[str, str]
    width: float


def slits_of(pieces: Mapping[str, Sequence[Cut]]) -> tuple[Slit, ...]:
    """All slits between pieces, which come by the marks of the panels that they were cut from."""
    found = []
    for own in pieces.values():
        for cut in own:
            if "end" in cut.plate.shared:
                continue
            after = [c for c in own if c.piece.breaks[0] >= cut.piece.breaks[1]]
            after += pieces.get(cut.whole.shared.get("end", ""), ())
            facing = next((c for c in after if _faces(cut, c)), None)
            width = _width(cut, facing) if facing is not None else None
            if facing is not None and width is not None and width <= WIDEST:
                found.append(Slit((cut.plate.mark, facing.plate.mark), width))
    return tuple(found)


def slit_rows(slits: Sequence[Slit]) -> dict[str, dict[str, Any]]:
    """What rows of panels beside slits tell: the widest, the panels across, a warning."""
    across: dict[str, dict[str, float]] = {}
    for slit in slits:
        for mark, other in (slit.panels, slit.panels[::-1]):
            across.setdefault(mark, {})[other] = slit.width
    return {
        mark: {
            "slit_max_mm": max(own.values()),
            "slit_edges": " ".join(own),
            "verdict": "warn",
            "reason": f"{max(own.values()):.0f} mm stay open to {' and '.join(own)}, where a piece "
            "was too small to make",
        }
        for mark, own in across.items()
    }


def _faces(one: Cut, other: Cut) -> bool:
    """Whether a dropped piece lay between the end of one and the start of the other."""
    if "start" in other.plate.shared or not (one.piece.joined[1] or other.piece.joined[0]):
        return False
    (low, high), (begin, end) = one.piece.ends[1], other.piece.ends[0]
    return min(high, end) > max(low, begin)


def _width(one: Cut, other: Cut) -> float | None:
    """Largest distance of the end ruling's points that have the other's ruling right across."""
    here, there = _ruling(one, -1), _ruling(other, 0)
    v = np.linspace(0.0, 1.0, PLACES)[:, None]
    points = here[0] + v * (here[1] - here[0])
    length, way = float(np.linalg.norm(there[1] - there[0])), unit(there[1] - there[0])
    along = dot(points - there[0], way)
    inside = (along >= 0.0) & (along <= length)
    if not inside.any():
        return None
    feet = there[0] + along[:, None] * way
    return float(np.linalg.norm(points - feet, axis=1)[inside].max())


def _ruling(cut: Cut, row: int) -> Array:
    """Both ends (2, 3) of a piece's first or last ruling."""
    mid = cut.plate.mid
    return mid.edges(np.array([mid.u0, mid.u1]))[:, row]
