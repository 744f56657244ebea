"""What kinks replacement by simpler shapes adds between panels, and which row names which.

Glossary
--------
turn
    Rotation vector (radians) that carries one panel's normal to its neighbour's across a joint.
own turn
    The same of the fitted strips: none across a ruling within a strip.
added kink
    Length of the difference of both.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable

import numpy as np

from fabgeo.arrays import Array, cross
from fabgeo.errors import FabgeoError
from fabgeo.review.check_strips import NAME, model_names
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number

ADDED = 0.05  # degrees: 550 panels had 0.002 more than stated at most
KINK = 0.15  # degrees: how much less than at the worst joint it was at that named, 0.08 at most
SHARE = 0.1  # of the stated and of the worst, besides
PER_SEGMENT = 64  # places of an edge between strips to a segment

type Own = Callable[[Array], Array]


def check_kinks(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """No joint of a panel adds more than its row states, nor much more than that which it names.

    Nothing is told of strips that were altered themselves, nor of panels that were named before.
    """
    known = {finding.part for finding in findings.items}
    rows = {row.get("mark", ""): row for row in package.tables["panels"]}
    strips = {number(row, "strip") for row in rows.values()}
    own = _own_turns(package, len(strips)) if measured.joints and NAME not in known else None
    if own is None:
        return
    found: dict[str, dict[str, float]] = defaultdict(dict)
    for one, other, facing in measured.joints:
        added = _added(own, one.rail, facing.points, facing.turns, facing.bend)
        for mark, beside in ((one.mark, other.mark), (other.mark, one.mark)):
            found[mark][beside] = max(found[mark].get(beside, 0.0), added)
    for mark, kinks in found.items():
        if mark in known:
            continue
        stated, named = number(rows[mark], "kink_added_deg"), rows[mark].get("kink_edge") or ""
        worst = max(kinks, key=lambda beside: kinks[beside])
        most = kinks[worst]
        if stated is not None and most > stated + ADDED + SHARE * stated:
            words = f"at most {stated:.4f}"
            findings.add(mark, f"kink_added_deg of its solid, to {worst}", words, most)
        elif named in kinks and kinks[named] < most - KINK - SHARE * most:
            words = f"{worst}, {most:.3f}"
            findings.add(mark, "kink_edge by its solid", words, f"{named}, {kinks[named]:.3f}")


def _own_turns(package: WrittenPackage, strips: int) -> Own | None:
    """Own turns (k, 3) at points (k, 3) of the edges between strips.

    None of several models, of rings, and where panels are of other strips than the model's: of
    lanes.
    """
    from scipy.spatial import KDTree

    from fabgeo.fitting.store import load_model
    from fabgeo.strips.frames import frames

    names = model_names(package)
    if len(names) != 1:
        return None
    try:
        model = load_model(package.folder / names[0])
    except FabgeoError:
        return None
    if model.closed_i or model.strips != strips or strips < 2:
        return None
    f = frames(model, model.parameters(PER_SEGMENT))
    before, after, edges = f.at_edges(f.m_second)[0], f.at_edges(f.m_first)[1], f.p[1:-1]
    turns, tree = turns_between(before, after).reshape(-1, 3), KDTree(edges.reshape(-1, 3))
    return lambda points: turns[np.asarray(tree.query(points)[1])]


def turns_between(one: Array, other: Array) -> Array:
    """Rotation vectors (..., 3) from directions to others, whichever way each of them points."""
    cosine = np.sum(one * other, axis=-1, keepdims=True)
    axis = cross(one, other) * np.where(cosine < 0.0, -1.0, 1.0)
    sine = np.linalg.norm(axis, axis=-1, keepdims=True)
    return axis * (np.arctan2(sine, np.abs(cosine)) / np.maximum(sine, 1e-15))


def _added(own: Own, rail: bool, points: Array, turns: Array, bend: float) -> float:
    """Largest added kink (degrees) of a joint, whichever of its panels is the first."""
    if not rail:
        return max(float(np.degrees(np.linalg.norm(turns, axis=1).max())) - bend, 0.0)
    there = own(points)
    off = (np.linalg.norm(turns - sign * there, axis=1).max() for sign in (1.0, -1.0))
    return float(np.degrees(min(off)))
