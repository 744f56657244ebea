"""The smallest oriented box around points: what must fit the truck."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from fabgeo.arrays import Array, cross, set_frozen, unit


@dataclass(frozen=True)
class Box:
    """An oriented box: `size` (3,) descending, `axes` (3, 3) unit rows, `centre` (3,)."""

    size: Array
    axes: Array
    centre: Array

    def __post_init__(self) -> None:
        set_frozen(self, "size", (3,))
        set_frozen(self, "axes", (3, 3))
        set_frozen(self, "centre", (3,))

    def fits(self, box: tuple[float, float, float]) -> bool:
        """Whether it goes into a transport box of these three sizes in some axis order."""
        return bool(np.all(np.sort(self.size) <= np.sort(np.asarray(box)) + 1e-6))


def oriented_box(points: Array) -> Box:
    """Smallest box with one face on a face of the convex hull (or one plane, for flat points).

    For every hull face the smallest rectangle of the projection is found by rotating calipers.
    """
    points = np.asarray(points, dtype=np.float64)
    centre = points.mean(axis=0)
    _, spread, axes = np.linalg.svd(points - centre, full_matrices=False)
    size = spread.max()
    if len(points) < 4 or spread[2] <= 1e-9 * size:
        return _on_plane(points, axes[2], spread[1] <= 1e-9 * size)
    try:
        hull = ConvexHull(points)
    except QhullError:
        return _on_plane(points, axes[2], False)
    normals = np.unique(np.round(hull.equations[:, :3], 3), axis=0)
    corners = points[hull.vertices]
    # Thick directions cannot win: try the normals with the thinnest slabs first.
    slab = np.ptp(corners @ unit(normals).T, axis=0)
    boxes = [_on_face(points, hull, n) for n in unit(normals[np.argsort(slab)[:8]])]
    return min(boxes, key=lambda box: float(np.prod(box.size)))


def _on_face(points: Array, hull: ConvexHull, normal: Array) -> Box:
    """Smallest box around a hull with one axis along `normal`.

    A side of the smallest rectangle lies on a side of the outline seen along the normal: on an
    edge of the hull between a face that is turned to the eye and one that is not.
    """
    seen = hull.equations[:, :3] @ normal > 0.0
    face, corner = np.nonzero(seen[:, None] & ~seen[hull.neighbors])
    sides = hull.simplices[face[:, None], (corner[:, None] + [1, 2]) % 3]
    across = cross(normal, points[sides[:, 1]] - points[sides[:, 0]])
    across = unit(across[np.any(across != 0.0, axis=1)])
    along = cross(across, normal)
    corners = points[np.unique(sides)]
    width, height = np.ptp(corners @ along.T, axis=0), np.ptp(corners @ across.T, axis=0)
    k = int(np.argmin(width * height))
    return _box(points[hull.vertices], np.stack([along[k], across[k], normal]))


def _on_plane(points: Array, normal: Array, line: bool) -> Box:
    """Smallest box around flat points with one axis along `normal`."""
    least: Array = np.eye(3)[int(np.argmin(np.abs(normal)))]
    x = unit(cross(normal, least))
    y = cross(normal, x)
    flat = np.stack([points @ x, points @ y], axis=1)
    if line:
        far = int(np.argmax(np.linalg.norm(flat - flat.mean(axis=0), axis=1)))
        directions = unit(flat[far] - flat.mean(axis=0))[None]
    else:
        try:
            outline = flat[ConvexHull(flat).vertices]
            directions = unit(np.roll(outline, -1, axis=0) - outline)
        except QhullError:
            directions = np.eye(2)[:1]
    across = np.stack([-directions[:, 1], directions[:, 0]], axis=1)
    width, height = np.ptp(flat @ directions.T, axis=0), np.ptp(flat @ across.T, axis=0)
    k = int(np.argmin(width * height))
    return _box(
        points, np.stack([d[0] * x + d[1] * y for d in (directions[k], across[k])] + [normal])
    )


def _box(points: Array, axes: Array) -> Box:
    """The box around points along three axes (rows)."""
    along = points @ axes.T
    low, high = along.min(axis=0), along.max(axis=0)
    order = np.argsort(-(high - low), kind="stable")
    return Box((high - low)[order], axes[order], ((low + high) / 2.0) @ axes)
