"""Which parts of a model's border are held on which part of the surface's boundary."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.fitting.options import BoundaryChoice
from fabgeo.fitting.reference import Reference, Side
from fabgeo.fitting.samples import Net, Sites
from fabgeo.strips.model import Kind

ON_BOUNDARY = 0.25  # mean distance, in mean ruling lengths, up to which a border "lies on" it
OVERHANGS = 0.05  # the same beyond a continued surface's boundary, from which on it overhangs


@dataclass(frozen=True)
class Held:
    """Edges (index to side) and ends (0 or 1 to side) that the boundary holds."""

    edges: dict[int, Side] = field(default_factory=dict)
    ends: dict[int, Side] = field(default_factory=dict)

    def everything(self, net: Net) -> bool:
        """Whether the whole border is held, so that the model cannot leave its domain."""
        return (net.closed_i or len(self.edges) == 2) and (net.closed_u or len(self.ends) == 2)


def choose(
    net: Net, control: Array, reference: Reference, choice: BoundaryChoice, kind: Kind
) -> Held:
    """What to hold; `control` in the fit's unit.

    Raises
    ------
    InputError
        If a boundary is asked for that the surface or the model does not have.
    """
    if choice == "none":
        return Held()
    sides = reference.sides()
    if choice != "auto" and not sides:
        raise InputError(
            "FitOptions.boundary",
            f"asks for {choice!r}, but the surface {reference.surface.name} has no boundary",
            "use 'none' or 'auto'",
        )
    points = Sites.gauss(net, 2).evaluate(control).reshape(net.edges, -1, 3)
    held = Held()
    # A principal net is the surface's own: nothing of it can follow a given curve. The edges of a
    # geodesic net are geodesics, which boundaries seldom are.
    if choice == "auto" and kind in ("conical", "circular"):
        return held
    if (choice in ("edges", "all") or (choice == "auto" and kind != "geodesic")) and (
        not net.closed_i
    ):
        for edge in (0, net.edges - 1):
            if choice != "auto" or not _overhangs(points[edge], reference):
                _hold(held.edges, edge, points[edge], sides, choice == "auto")
    if choice in ("ends", "all", "auto"):
        for end in () if net.closed_u else (0, 1):
            polygon = Sites.at_end(net, bool(end)).evaluate(control).reshape(-1, 3)
            if choice != "auto" or not _overhangs(polygon, reference):
                _hold(held.ends, end, polygon, sides, choice == "auto")
    return held


def _overhangs(points: Array, reference: Reference) -> bool:
    """Whether a border lies beyond the boundary, be it by little: held on it, it would be cut."""
    beyond = np.linalg.norm(reference.outwards(points), axis=-1)
    return float(beyond.mean()) > OVERHANGS


def _hold(held: dict[int, Side], key: int, points: Array, sides: list[Side], if_near: bool) -> None:
    if not sides:
        return
    distances = []
    for side in sides:
        foot, _ = side.closest(points)
        distances.append(float(np.linalg.norm(points - foot, axis=-1).mean()))
    best = int(np.argmin(distances))
    if not if_near or distances[best] <= ON_BOUNDARY:
        held[key] = sides[best]
