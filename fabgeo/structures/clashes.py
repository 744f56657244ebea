"""Clashes between fixings, panels and beams, found on oriented boxes and edge distances."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.strips.pierce import pierce
from fabgeo.structures.fixing import Fixing
from fabgeo.structures.parts import Beam, Connector, Plate
from fabgeo.structures.prisms import ruled_normals


@dataclass(frozen=True)
class Clash:
    """Two parts that meet where they must not, and by how much (mm)."""

    first: str
    second: str
    reason: str
    depth: float


def clashes(
    connectors: Sequence[Connector],
    products: Mapping[str, Fixing],
    panels: Sequence[Plate],
    beams: Sequence[Beam],
) -> list[Clash]:
    """Fixings that overlap, leave their panel or overhang their flange; flanges in panels."""
    found = between_fixings(connectors, products, panels)
    return found + with_plates(connectors, products, panels, beams)


def with_plates(
    connectors: Sequence[Connector],
    products: Mapping[str, Fixing],
    panels: Sequence[Plate],
    beams: Sequence[Beam],
) -> list[Clash]:
    """Fixings that leave their panel or overhang their flange; flanges in panels."""
    plates = {panel.mark: panel for panel in panels}
    flanges = {  # one each, or pieces from seam to seam
        beam.mark: [plate for plate in beam.plates if plate.role == "flange_outer"]
        for beam in beams
    }
    found = []
    over: dict[tuple[str, str], list[Connector]] = defaultdict(list)
    for connector in connectors:
        over[connector.panel, connector.beam].append(connector)
    for panel, beam in sorted(over):
        room = min(clear_distance(plates[panel], flange) for flange in flanges[beam])
        if room < 0.0:
            found.append(Clash(panel, beam, "the flange touches the panel", -room))
    edges = {
        plate.mark: plate.mid.edges(plate.mid.parameters(8))
        for plate in (*plates.values(), *(f for own in flanges.values() for f in own))
    }
    for (panel, beam), own in over.items():
        under = [edges[flange.mark] for flange in flanges[beam]]
        found += _beyond(plates[panel], edges[panel], under, own, products)
    return found


def _beyond(
    panel: Plate,
    edges: Array,
    flanges: Sequence[Array],
    connectors: Sequence[Connector],
    products: Mapping[str, Fixing],
) -> Iterator[Clash]:
    """Fixings of a panel on one beam whose disc leaves the panel or whose base leaves its flange.

    Of panel and flanges the edges are given, (2, k, 3) each.
    """
    own = [(connector, products[connector.product]) for connector in connectors]
    half = panel.thickness / 2.0
    discs = [c.frame[:3, 3] + (fixing.stand_off + half) * c.frame[:3, 2] for c, fixing in own]
    corners = np.concatenate([base_corners(c.frame, fixing) for c, fixing in own])
    above = edge_rooms(edges, np.array(discs)).tolist()
    below = [edge_rooms(flange, corners).reshape(-1, 4).min(axis=1) for flange in flanges]
    for (c, fixing), room, base in zip(own, above, np.max(below, axis=0).tolist(), strict=True):
        radius = fixing.disc_diameter / 2.0
        if room < radius:
            yield Clash(c.mark, panel.mark, "disc beyond panel edge", radius - room)
        if base < 0.0:
            yield Clash(c.mark, c.beam, "base plate overhangs its flange", -base)


def clear_distance(panel: Plate, flange: Plate) -> float:
    """Least distance in mm of a panel's face from a flange's face below it; negative: they meet.

    Measured along the flange's normals from its middle line and both its edges; infinite where
    none of it lies below the panel.
    """
    u = flange.mid.parameters(2)
    first, second = flange.mid.edges(u)
    points = np.concatenate([first, (first + second) / 2.0, second])
    normals = np.tile(ruled_normals(flange.mid, u), (3, 1))
    grid = panel.mid.parameters(2)
    sides = panel.mid.edges(grid)
    apart = np.linalg.norm(points[:, None, None] - sides, axis=-1).min(axis=1)
    nearest = np.argmin(apart, axis=1)
    span = float(np.linalg.norm(np.diff(sides, axis=1), axis=-1).max())
    close = apart.min(axis=1) < span + float(np.linalg.norm(second - first, axis=-1).max())
    if not close.any():
        return np.inf
    points, normals, guess = points[close], normals[close], grid[nearest[close]]
    at, v, h = pierce(panel.mid, points, normals, guess)
    below = (at >= panel.mid.u0) & (at <= panel.mid.u1) & (v >= 0.0) & (v <= 1.0)
    if not below.any():
        return np.inf
    cosine = np.abs(np.sum(ruled_normals(panel.mid, at[below]) * normals[below], axis=-1))
    height = h[below] * np.sign(np.median(h[below]))
    thick = flange.thickness + panel.thickness
    return float((height * cosine).min() - thick / 2.0)


def base_corners(frame: Array, fixing: Fixing) -> Array:
    """Corners (4, 3) of the base plate's underside."""
    x, y, origin = frame[:3, 0], frame[:3, 1], frame[:3, 3]
    a, b = fixing.base_length / 2.0, fixing.base_width / 2.0
    return np.array(
        [origin + s * a * x + t * b * y for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    )


def edge_rooms(edges: Array, points: Array) -> Array:
    """Distances (n,) of points (n, 3) to the nearest edge of a plate, in its tangent planes there.

    Negative outside. `edges` (2, k, 3) are points of its edge curves.
    """
    a, b = edges
    outline = np.concatenate([a, b[::-1]])
    nearest = np.linalg.norm((a + b) / 2.0 - points[:, None], axis=-1).argmin(axis=1)
    k = np.minimum(nearest, len(a) - 2)
    e = unit(b[k] - a[k])
    along: Array = a[k + 1] + b[k + 1] - a[k] - b[k]
    side = unit(along - dot(along, e)[:, None] * e)
    x = (outline - points[:, None]) @ np.stack([side, e], axis=-1)  # around each point, in plane
    after = np.roll(x, -1, axis=1)
    d = after - x
    t = np.clip(-dot(x, d) / np.maximum(dot(d, d), 1e-300), 0.0, 1.0)
    distance = np.linalg.norm(x + t[..., None] * d, axis=-1).min(axis=1)
    turn = np.arctan2(x[..., 0] * after[..., 1] - x[..., 1] * after[..., 0], dot(x, after))
    return np.where(np.abs(turn.sum(axis=1)) > np.pi, distance, -distance)


def between_fixings(
    connectors: Sequence[Connector], products: Mapping[str, Fixing], panels: Sequence[Plate]
) -> list[Clash]:
    """Fixings that overlap each other."""
    if len(connectors) < 2:
        return []
    plates = {panel.mark: panel for panel in panels}
    boxes = [_box(c.frame, products[c.product], plates[c.panel].thickness) for c in connectors]
    centres = np.array([centre for centre, _, _ in boxes])
    reach = max(float(np.linalg.norm(half)) for _, _, half in boxes)
    out = []
    for i, j in sorted(KDTree(centres).query_pairs(2.0 * reach)):
        depth = overlap(boxes[i], boxes[j])
        if depth > 0.0:
            first, second = connectors[i].mark, connectors[j].mark
            out.append(Clash(first, second, "fixings overlap", depth))
    return out


def _box(frame: Array, fixing: Fixing, panel: float) -> tuple[Array, Array, Array]:
    """Centre, axes (rows) and half sizes of a fixing's bounding box."""
    height = fixing.stand_off + panel + fixing.disc_thickness
    half = np.array(
        [
            max(fixing.base_length, fixing.disc_diameter) / 2.0,
            max(fixing.base_width, fixing.disc_diameter) / 2.0,
            height / 2.0,
        ]
    )
    return frame[:3, 3] + frame[:3, 2] * half[2], frame[:3, :3].T, half


def overlap(first: tuple[Array, Array, Array], second: tuple[Array, Array, Array]) -> float:
    """Depth by which two oriented boxes overlap (separating axes); negative if apart."""
    (c1, a1, h1), (c2, a2, h2) = first, second
    crossed = cross(np.repeat(a1, 3, axis=0), np.tile(a2, (3, 1)))
    axes = np.concatenate([a1, a2, crossed])
    length = np.linalg.norm(axes, axis=1)
    axes = axes[length > 1e-9] / length[length > 1e-9][:, None]
    reach = np.abs(axes @ a1.T) @ h1 + np.abs(axes @ a2.T) @ h2
    return float((reach - np.abs(axes @ (c2 - c1))).min())
