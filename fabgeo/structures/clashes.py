"""Clashes between fixings, panels and beams, found on oriented boxes and edge distances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from fabgeo.arrays import Array, cross, unit
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
    over = sorted({(c.panel, c.beam) for c in connectors})
    for panel, beam in over:
        room = min(clear_distance(plates[panel], flange) for flange in flanges[beam])
        if room < 0.0:
            found.append(Clash(panel, beam, "the flange touches the panel", -room))
    edges = {
        plate.mark: plate.mid.edges(plate.mid.parameters(8))
        for plate in (*plates.values(), *(f for own in flanges.values() for f in own))
    }
    for connector in connectors:
        fixing = products[connector.product]
        frame = connector.frame
        height = (fixing.stand_off + plates[connector.panel].thickness / 2.0) * frame[:3, 2]
        room = edge_room(edges[connector.panel], frame[:3, 3] + height)
        if room < fixing.disc_diameter / 2.0:
            depth = fixing.disc_diameter / 2.0 - room
            found.append(Clash(connector.mark, connector.panel, "disc beyond panel edge", depth))
        corners = base_corners(frame, fixing)
        room = max(
            min(edge_room(edges[flange.mark], corner) for corner in corners)
            for flange in flanges[connector.beam]
        )
        if room < 0.0:
            found.append(
                Clash(connector.mark, connector.beam, "base plate overhangs its flange", -room)
            )
    return found


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


def edge_room(edges: Array, point: Array) -> float:
    """Distance from a point to the nearest edge of a plate, within its tangent plane there.

    Negative outside. `edges` (2, k, 3) are points of its edge curves.
    """
    a, b = edges
    outline = np.concatenate([a, b[::-1]])
    k = int(np.argmin(np.linalg.norm((a + b) / 2.0 - point, axis=1)))
    k = min(k, len(a) - 2)
    e = unit(b[k] - a[k])
    along: Array = a[k + 1] + b[k + 1] - a[k] - b[k]
    side = unit(along - (along @ e) * e)
    x = (outline - point) @ np.stack([side, e], axis=1)  # the outline around the point, in plane
    d = np.roll(x, -1, axis=0) - x
    t = np.clip(-np.sum(x * d, axis=1) / np.maximum(np.sum(d * d, axis=1), 1e-300), 0.0, 1.0)
    distance = float(np.linalg.norm(x + t[:, None] * d, axis=1).min())
    angles = np.arctan2(
        x[:, 0] * np.roll(x[:, 1], -1) - x[:, 1] * np.roll(x[:, 0], -1),
        np.sum(x * np.roll(x, -1, axis=0), axis=1),
    )
    return distance if abs(angles.sum()) > np.pi else -distance


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
