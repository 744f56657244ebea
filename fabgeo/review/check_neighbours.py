"""Neighbouring panels measured between their solids: width of the joint, angle across it.

Glossary
--------
facing
    Points of two panels' edges that lie across one joint from each other.
width
    Distance of facing points. Each edge is drawn back by half a joint in its own panel, so that a
    joint across which the panels turn by an angle a is joint cos(a / 2) wide.
gap
    What a joint's width is off that: shapes that replace fitted panels do not meet exactly.
kink
    Angle between the panels' normals at facing points.
slit
    What is open between two panels of a strip from between which a piece too small to make was
    left out: no joint, its width is stated by itself.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from fabgeo.arrays import Array
from fabgeo.review.check_kinks import turns_between
from fabgeo.review.check_rows import CENTRE
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number
from fabgeo.review.panel_edges import PanelEdge, panel_edges

GAP = 0.1  # mm beside the stated gap: joints of strips come off panels before these are replaced
CORNER = np.radians(80.0)  # edges at a corner of the building are no joint
COVERED = 0.97  # share of a long edge with neighbours across: less at a boundary
REACH = 20.0  # mm beside three joints: edges farther apart do not face each other
SPACING = 400.0  # mm, of points by which neighbours are looked for
PLACES = 33  # on an edge at which it is measured
KINK = 0.05  # degrees
SHARE = 0.03  # of the measured: how much an edge's worst place may fall between two samples


@dataclass(frozen=True)
class Facing:
    """Two edges across one joint.

    Attributes
    ----------
    width, widest : float
        Median and largest, mm.
    gap, kink : float
        Largest, in mm and degrees.
    bend : float
        What the panels' own bending may add to the kink across the width of the joint, degrees.
    faced : two pairs of float
        From where to where each edge has the other across, as shares of its length.
    points, turns : (n, 3) array
        Where it is measured on the first edge, and rotation vectors from its panel's normals there.
    """

    width: float
    widest: float
    gap: float
    kink: float
    bend: float
    faced: tuple[tuple[float, float], tuple[float, float]]
    points: Array
    turns: Array


type Joint = tuple[PanelEdge, PanelEdge, Facing]


@dataclass
class Met:
    """What one panel's joints measure: largest gap (mm) and kink (degrees), and to which panel.

    `beside` holds all of these.
    """

    gap: float = 0.0
    gap_at: str = ""
    kink: float = 0.0
    kink_at: str = ""
    bend: float = 0.0
    beside: set[str] = field(default_factory=set)

    def see(self, neighbour: str, facing: Facing) -> None:
        """Take in one more joint."""
        if facing.gap > self.gap:
            self.gap, self.gap_at = facing.gap, neighbour
        if facing.kink > self.kink:
            self.kink, self.kink_at = facing.kink, neighbour
        self.bend = max(self.bend, facing.bend)
        self.beside.add(neighbour)


def check_neighbours(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Measure all joints; compare gaps and kinks with what the panels' rows state.

    gap_measured_mm and kink_measured_deg are the worst of the package; shared_edge_error_mm is the
    difference of the flat lengths less that of the solids' edges.
    """
    rows = {row.get("mark", ""): row for row in package.tables["panels"]}
    plates = {mark: measured.plates[mark] for mark in rows if mark in measured.plates}
    joint = float(package.setting("panels", "joint", 0.0))
    edges = panel_edges(plates)
    pairs = _pairs(edges, joint)
    rails = [pair for pair in pairs if pair[0].rail]
    along = _each_once([(one, other, _across(one, other, joint)) for one, other in rails])
    cut = _cut(edges, along)
    # Rulings of a cut panel may end within the joint's place: its width is known from below.
    slits = {mark: set((row.get("slit_edges") or "").split()) for mark, row in rows.items()}
    rulings = [pair for pair in pairs if not pair[0].rail]
    _check_slits([pair for pair in rulings if _is_slit(pair, slits)], rows, findings)
    rulings = [pair for pair in rulings if not _is_slit(pair, slits)]
    ends = _each_once([(one, other, _across(one, other, joint, cut)) for one, other in rulings])
    met: dict[str, Met] = defaultdict(Met)
    below = package.project.get("cells") or package.project.get("beams")
    trim = package.setting("panels", "trim", not below)
    uncut = trim is False
    near_cut = set(cut)
    for one, other, facing in along + ends:
        met[one.mark].see(other.mark, facing)
        met[other.mark].see(one.mark, facing)
        near_cut |= {one.mark, other.mark} if {one.mark, other.mark} & cut else set()
        _shared(one, other, measured)
    # Beside a solid that lies elsewhere than stated, it is not the neighbour that is wrong.
    elsewhere = {found.part for found in findings.items if found.what == CENTRE}
    lost = ((rows.keys() | measured.names.keys()) - plates.keys()) | elsewhere
    for mark, own in met.items():
        measured.worst("gap_measured_mm", own.gap)
        measured.worst("kink_measured_deg", own.kink)
        if mark in elsewhere or not {own.gap_at, own.kink_at} & elsewhere:
            _judge(mark, own, rows[mark], uncut and mark not in near_cut, findings)
        if uncut:
            _named(mark, own.beside | lost, rows[mark], findings)
    if uncut and not elsewhere:
        measured.joints = along + ends


def _is_slit(pair: tuple[PanelEdge, PanelEdge], slits: Mapping[str, set[str]]) -> bool:
    one, other = pair
    return other.mark in slits[one.mark] or one.mark in slits[other.mark]


def _check_slits(
    pairs: Iterable[tuple[PanelEdge, PanelEdge]],
    rows: Mapping[str, dict[str, str]],
    findings: Findings,
) -> None:
    """A slit is no wider than both its panels' rows state."""
    for one, other in pairs:
        for edge, beside in ((one, other), (other, one)):
            stated = number(rows[edge.mark], "slit_max_mm") or 0.0
            facing = _across(edge, beside, 0.0, reach=REACH + 1.5 * stated)
            if facing is not None and facing.widest > stated + GAP + SHARE * stated:
                what = f"slit_max_mm of its solid, to {beside.mark}"
                findings.add(edge.mark, what, f"at most {stated:.1f}", facing.widest)


def _each_once(found: list[tuple[PanelEdge, PanelEdge, Facing | None]]) -> list[Joint]:
    """Joints, narrowest first: two panels' edges face each other once.

    The edge along which a panel is cut leaves its neighbour's at a small angle; beside it runs the
    edge that truly faces the neighbour.
    """
    joints = [(one, other, facing) for one, other, facing in found if facing is not None]
    taken: set[tuple[str, int, str]] = set()
    out: list[Joint] = []
    for one, other, facing in sorted(joints, key=lambda joint: joint[2].width):
        keys = {(one.mark, one.number, other.mark), (other.mark, other.number, one.mark)}
        if not keys & taken:
            taken |= keys
            out.append((one, other, facing))
    return out


def _cut(edges: list[PanelEdge], along: list[Joint]) -> set[str]:
    """Panels with a long edge that has no neighbour across some of its length."""
    faced: dict[tuple[str, int], float] = {(e.mark, e.number): 0.0 for e in edges if e.rail}
    for one, other, facing in along:
        for edge, (low, high) in zip((one, other), facing.faced, strict=True):
            faced[edge.mark, edge.number] += high - low
    return {mark for (mark, _), share in faced.items() if share < COVERED}


def _judge(mark: str, own: Met, row: dict[str, str], whole: bool, findings: Findings) -> None:
    """A panel's worst joint against its row; `whole`: no part of a joint was cut away."""
    gap = number(row, "gap_max_mm")
    if gap is not None and own.gap > gap + GAP + SHARE * gap:
        words = f"at most {gap:.3f}"
        findings.add(mark, f"gap_max_mm of its solid, to {own.gap_at}", words, own.gap)
    kink, added = number(row, "kink_max_deg"), number(row, "kink_added_deg") or 0.0
    if kink is None:
        return
    within = added + KINK + SHARE * kink + own.bend
    if own.kink > kink + within or (whole and own.kink < kink - within):
        words = f"{kink:.3f} within {within:.3f}"
        findings.add(mark, f"kink_max_deg of its solid, to {own.kink_at}", words, own.kink)


def _named(mark: str, beside: set[str], row: dict[str, str], findings: Findings) -> None:
    """A row names panels across joints of its own; which is worst is told of the fitted model."""
    for key in ("gap_edge", "kink_edge"):
        named = row.get(key) or ""
        if named.startswith("P-") and named not in beside:
            findings.add(mark, f"{key} by its solid", "a neighbour", named)


def _pairs(edges: list[PanelEdge], joint: float) -> list[tuple[PanelEdge, PanelEdge]]:
    """Edges of one kind of different panels that come near each other somewhere, once each."""
    from scipy.spatial import KDTree

    if len(edges) < 2:
        return []
    some = [edge.spaced(SPACING) for edge in edges]
    points = np.concatenate(some)
    owner = np.repeat(np.arange(len(edges)), [len(own) for own in some])
    reach = 3.0 * joint + REACH + SPACING
    near = owner[KDTree(points).query_pairs(reach, output_type="ndarray")]
    pairs = np.unique(np.sort(near[near[:, 0] != near[:, 1]], axis=1), axis=0)
    return [
        (edges[i], edges[j])
        for i, j in pairs.tolist()
        if edges[i].mark != edges[j].mark and edges[i].rail == edges[j].rail
    ]


def _across(
    one: PanelEdge,
    other: PanelEdge,
    joint: float,
    cut: Container[str] = (),
    reach: float | None = None,
) -> Facing | None:
    """What lies across a joint; None where the edges do not face each other within reach, mm.

    Of a panel in `cut` the ruling's slower end may be cut away: its half of the joint is known by
    its fan alone, and from below.
    """
    some = np.unique(np.linspace(1, len(one.points) - 2, PLACES).round().astype(int))
    place, t = other.nearest(one.points[some])
    width = np.linalg.norm(other.at(place, t) - one.points[some], axis=1)
    inside = (place + t > 0.25) & (place + t < len(other.points) - 1.25)
    inside &= width < (3.0 * joint + REACH if reach is None else reach)
    if inside.sum() < 3:
        return None
    some, place, t, width = some[inside], place[inside], t[inside], width[inside]
    n1, n2 = one.normals[some], other.normal_at(place, t)
    turns = turns_between(n1, n2)
    angle = np.linalg.norm(turns, axis=1)
    if angle.max() > CORNER:
        return None
    half = 0.5 * joint * np.cos(0.5 * angle)
    halves = half * one.fan[some], half * other.fan_at(place, t)
    fixed, loose = np.zeros_like(half), np.zeros_like(half)
    for edge, own in zip((one, other), halves, strict=True):
        if edge.mark in cut:
            loose = loose + own
        else:
            fixed = fixed + own
    expected = fixed + loose
    if loose.any():
        expected = fixed + loose * max(float(np.median((width - fixed) / loose)), 1.0)
    back = (place + t) / (len(other.points) - 1)
    own = some / (len(one.points) - 1)
    return Facing(
        float(np.median(width)),
        float(width.max()),
        float(np.abs(width - expected).max()),
        float(np.degrees(angle.max())),
        float(np.degrees(joint * (one.curvature + other.curvature))),
        ((float(own.min()), float(own.max())), (float(back.min()), float(back.max()))),
        one.points[some],
        turns,
    )


def _shared(one: PanelEdge, other: PanelEdge, measured: Measured) -> None:
    if one.mark in measured.edge_errors and other.mark in measured.edge_errors:
        error = (
            measured.edge_errors[one.mark][one.number]
            - measured.edge_errors[other.mark][other.number]
        )
        measured.worst("shared_edge_error_mm", abs(float(error)))
