"""The sides of a plate's solid, between its two skins, chained into the loops of its outline.

Glossary
--------
skin
    One of the two large faces of a plate.
side
    A face between the skins; its edges on both skins average to one edge of the mid-surface.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fabgeo.arrays import Array

if TYPE_CHECKING:
    from fabgeo.cad.readback import ReadEdge

PER_POLE = 2  # samples of an opening's edge to a control point
ROUGH = 5  # samples tell which of two edges is the nearer, and which way it runs


@dataclass(frozen=True)
class Side:
    """A side face's edge on each skin, whether the second runs against the first.

    Their mid-edge runs as the first, or against it where it is turned.
    """

    one: ReadEdge
    two: ReadEdge
    against: bool
    ends: Array
    turned: bool = False

    @property
    def length(self) -> float:
        """Mean length of both edges."""
        return 0.5 * (self.one.length + self.two.length)

    def apart(self, count: int) -> tuple[Array, Array]:
        """Points (count, 3) of both edges, in the mid-edge's sense."""
        one, two = self.one.points(count), self.two.points(count)
        two = two[::-1] if self.against else two
        return (one[::-1], two[::-1]) if self.turned else (one, two)

    def rim(self, count: int) -> Array:
        """Points of the mid-edge of an opening: `count`, of splines as many as tell them."""
        poles = self.one.poles, self.two.poles
        one, two = self.apart(PER_POLE * max(poles) + 1 if all(poles) else count)
        return 0.5 * (one + two)


def skins(edges: list[ReadEdge]) -> tuple[int, int]:
    """The two faces with the longest edges around them."""
    around: dict[int, float] = {}
    for edge in edges:
        for face in edge.faces:
            around[face] = around.get(face, 0.0) + edge.length
    order = sorted(around, key=lambda face: -around[face])
    return (order[0], order[1]) if len(order) > 1 else (-1, -1)


def sides(edges: list[ReadEdge], one: int, two: int) -> list[Side]:
    """For every side face its edges on one skin, each with the nearest on the other."""
    by_side: dict[int, dict[int, list[tuple[ReadEdge, Array]]]] = {}
    for edge in edges:
        for skin in (one, two):
            if skin in edge.faces:
                rough = edge.points(ROUGH)
                for side in edge.faces:
                    if side not in (one, two):
                        by_side.setdefault(side, {}).setdefault(skin, []).append((edge, rough))
    found = []
    for own in by_side.values():
        for a, points in own.get(one, []):
            pairs = [(*b, turned) for b in own.get(two, []) for turned in (False, True)]
            if not pairs:
                continue
            b, others, against = min(pairs, key=lambda pair: _apart(points, pair[1], pair[2]))
            others = others[::-1] if against else others
            found.append(Side(a, b, against, 0.5 * (points + others)[[0, -1]]))
    return found


def _apart(a: Array, b: Array, turned: bool) -> float:
    return float(np.linalg.norm(a - (b[::-1] if turned else b), axis=1).max())


def loops(found: list[Side], reach: float = 1e-2) -> list[list[Side]]:
    """Edges chained end to end into loops."""
    ends = np.array([side.ends for side in found]).reshape(-1, 2, 3)
    free, out = np.ones(len(found), dtype=bool), []
    while free.any():
        first = int(free.argmax())
        free[first] = False
        loop, (start, end) = [found[first]], ends[first]
        while np.linalg.norm(end - start) > reach:
            away = np.linalg.norm(ends - end, axis=2)
            away[~free] = np.inf
            k, flip = divmod(int(away.argmin()), 2)
            if away[k, flip] > reach:
                break
            free[k] = False
            loop.append(replace(found[k], turned=bool(flip)))
            end = ends[k, 1 - flip]
        out.append(loop)
    return out
