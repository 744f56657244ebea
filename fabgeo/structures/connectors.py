"""Point fixings between panels and outer flanges (paper Fig. 9): placed, drilled, checked.

A fixing stands on the outer face of a beam's outer flange, square to the panel. Its holes are laid
out once, in its own frame, and pierce panel and flange along the same axes: the holes of both
plates are the same holes.

Their parameters and frames are told in `fabgeo.structures.fixing`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.strips.pierce import pierce
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.beams import with_holes
from fabgeo.structures.fixing import Fixing, Fixings, LocalHole
from fabgeo.structures.parts import Beam, Connector, Hole, Plate
from fabgeo.structures.prisms import ruled_normals


def connect(panels: Sequence[Plate], beams: Sequence[Beam], fixing: Fixing) -> Fixings:
    """Place fixings along both edges of every panel where a beam runs below.

    Positions are spread evenly, `end_distance` clear of the panel's ends and clear of the joints
    between beam segments. What cannot be fixed (a flange too narrow, a stand-off out of reach) is
    refused by name, never drawn wrongly.
    """
    flanges: dict[int, list[tuple[Beam, Plate]]] = defaultdict(list)
    for beam in beams:
        for plate in beam.plates:
            if plate.role == "flange_outer":
                flanges[beam.edge].append((beam, plate))
    edges = (max(flanges) + 1) if flanges else 0
    drilled: dict[str, list[Hole]] = defaultdict(list)
    refused: dict[str, str] = {}
    products: dict[str, Fixing] = {}
    connectors: list[Connector] = []
    for panel in panels:
        strip = int(panel.mark.split("-")[1])
        number = 0
        for side in (0, 1):
            edge = strip + side
            if edge not in flanges and side == 1 and 0 in flanges and edge == edges:
                edge = 0  # a model closed in i
            for beam, flange in flanges.get(edge, ()):
                if _far(panel.mid, flange.mid):
                    continue
                sites = _sites(panel, side, flange, fixing)
                for made in _fit(panel, flange, sites, fixing) if sites is not None else ():
                    if isinstance(made, str):
                        refused[f"{panel.mark}, edge {edge}, {beam.mark}"] = made
                        continue
                    frame, product, in_panel, in_flange = made
                    number += 1
                    mark = f"K-{panel.mark.removeprefix('P-')}-{number}"
                    products[product.product] = product
                    connectors.append(
                        Connector(mark, product.product, frame, panel.mark, beam.mark)
                    )
                    drilled[panel.mark] += in_panel
                    drilled[flange.mark] += in_flange
    return Fixings(
        connectors,
        products,
        [_drill(panel, drilled) for panel in panels],
        [with_holes(b, [_drill(p, drilled) for p in b.plates]) for b in beams],
        refused,
    )


def _drill(plate: Plate, drilled: Mapping[str, Sequence[Hole]]) -> Plate:
    holes = drilled.get(plate.mark, ())
    return replace(plate, holes=(*plate.holes, *holes)) if holes else plate


@dataclass(frozen=True)
class _Sites:
    """Places on a panel's mid-surface: parameters, points, edge directions, normals."""

    u: Array
    point: Array
    along: Array
    normal: Array


def _sites(panel: Plate, side: int, flange: Plate, fixing: Fixing) -> _Sites | None:
    """Evenly spread places along one edge, over one flange segment and clear of its ends."""
    mid = panel.mid
    grid = mid.parameters(8)
    edge = mid.edges(grid)[side]
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(edge, axis=0), axis=1))])
    low, high = fixing.end_distance, arc[-1] - fixing.end_distance
    clear = fixing.base_length / 2.0 + 5.0
    ends = _over(flange.mid, edge, arc, clear)
    low, high = max(low, ends[0]), min(high, ends[1])
    if high < low:
        return None
    count = max(2, int(np.ceil((high - low) / fixing.spacing)) + 1)
    if high - low < 2.0 * fixing.base_length:
        count = 1
    places = np.linspace(low, high, count) if count > 1 else np.array([(low + high) / 2.0])
    u = np.interp(places, arc, grid)
    a, b = mid.edges(u)
    tangents = unit(mid.edges(u, 1)[side])
    chord: Array = b - a
    e = unit(chord) if side == 0 else -unit(chord)
    m = ruled_normals(mid, u)
    sine = np.abs(dot(cross(tangents, e), m))
    points = mid.edges(u)[side] + (fixing.edge_distance / sine)[:, None] * e
    return _Sites(u, points, tangents, m)


def _far(panel: RuledPatch, flange: RuledPatch) -> bool:
    """Whether a flange runs past a panel's parameters by more than the panel's own length."""
    length = panel.u1 - panel.u0
    return flange.u0 > panel.u1 + length or flange.u1 < panel.u0 - length


def _over(flange: RuledPatch, edge: Array, arc: Array, clear: float) -> tuple[float, float]:
    """Range of the panel edge's arc length that lies over the flange, `clear` of its ends."""
    out = []
    for u, sign in ((flange.u0, 1.0), (flange.u1, -1.0)):
        at = np.array([u])
        point = flange.points(at, np.array([0.5]))[0]
        direction = sign * unit(flange.edges(at, 1).mean(axis=0))[0]
        ahead = (edge - point) @ direction - clear
        inside = ahead >= 0.0
        if not inside.any():
            return (1.0, 0.0)
        first = int(np.argmax(inside)) if sign > 0 else len(arc) - 1 - int(np.argmax(inside[::-1]))
        out.append(_crossing(arc, ahead, first, first - int(sign)))
    return out[0], out[1]


def _crossing(arc: Array, value: Array, inside: int, outside: int) -> float:
    """Arc length where `value` crosses zero between two neighbouring samples."""
    if not 0 <= outside < len(arc):
        return float(arc[inside])
    t = value[inside] / (value[inside] - value[outside])
    return float(arc[inside] + t * (arc[outside] - arc[inside]))


type _Fitted = tuple[Array, Fixing, list[Hole], list[Hole]] | str


def _fit(panel: Plate, flange: Plate, sites: _Sites, fixing: Fixing) -> list[_Fitted]:
    """Frame, product and holes of every fixing of one panel edge, or why there is none."""
    mid = flange.mid
    guess = np.clip(sites.u, mid.u0, mid.u1)
    u, v, h = pierce(mid, sites.point, sites.normal, guess)
    z = -np.sign(h)[:, None] * sites.normal
    x = unit(sites.along - dot(sites.along, z)[:, None] * z)
    at = np.clip(u, mid.u0, mid.u1)
    a, b = mid.edges(at)
    half = flange.thickness / 2.0 / np.abs(dot(ruled_normals(mid, at), z))
    stand_off = np.abs(h) - panel.thickness / 2.0 - half
    width: Array = np.linalg.norm(b - a, axis=-1)
    frame = np.tile(np.eye(4), (len(u), 1, 1))
    origin = sites.point - z * (np.abs(h) - half)[:, None]
    for k, column in enumerate((x, cross(z, x), z, origin)):
        frame[:, :3, k] = column
    in_panel = _holes(panel, fixing.panel_holes, frame, sites.u)
    in_flange = _holes(flange, fixing.flange_holes, frame, at)
    out: list[_Fitted] = []
    for k in range(len(u)):
        room = float(min(v[k], 1.0 - v[k]) * width[k])
        reason = _refusal(fixing, float(stand_off[k]), room, float(width[k]))
        if not mid.u0 <= u[k] <= mid.u1:
            reason = "lies past the end of the beam segment"
        rounded = float(np.floor(stand_off[k] / fixing.step + 1e-9) * fixing.step)
        out.append(
            reason
            or (
                frame[k],
                replace(fixing, stand_off=rounded),
                in_panel[k],
                in_flange[k],
            )
        )
    return out


def _refusal(fixing: Fixing, stand_off: float, room: float, width: float) -> str:
    """Why a fixing can't stand there; empty if it can."""
    low, high = fixing.limits
    if not low <= stand_off <= high:
        return f"needs a stand-off of {stand_off:.1f} mm; the fixing reaches {low:g} to {high:g} mm"
    least = fixing.base_width / 2.0
    if room < least:
        return (
            f"needs a flange {width + 2.0 * (least - room):.0f} mm wide or a smaller edge "
            f"distance (the flange is {width:.0f} mm wide)"
        )
    return ""


def _holes(plate: Plate, holes: Sequence[LocalHole], frame: Array, u: Array) -> list[list[Hole]]:
    """For every frame (k, 4, 4): where the axes of its holes meet the plate's mid-surface."""
    if not holes:
        return [[] for _ in frame]
    x, y, z, origin = (frame[:, None, :3, k] for k in range(4))
    at = np.array([(hole.x, hole.y) for hole in holes])[..., None]
    turn = np.array([hole.angle for hole in holes])[:, None]
    start = origin + at[:, 0] * x + at[:, 1] * y  # (k, holes, 3)
    axes = np.broadcast_to(z, start.shape).reshape(-1, 3)
    _, _, h = pierce(plate.mid, start.reshape(-1, 3), axes, np.repeat(u, len(holes)))
    centres = start + h.reshape(*start.shape[:2], 1) * z
    directions = np.cos(turn) * x + np.sin(turn) * y
    return [
        [
            Hole(c, axis, hole.diameter, hole.slot, d)
            for hole, c, d in zip(holes, own, along, strict=True)
        ]
        for own, axis, along in zip(centres, z[:, 0], directions, strict=True)
    ]
