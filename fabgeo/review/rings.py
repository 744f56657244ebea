"""Closed polygons in the plane: distances from them."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array


def distances(points: Array, ring: Array) -> Array:
    """Distances (k,) of points (k, 2) from a closed polygon (n, 2), through a tree of its sides."""
    import shapely

    sides = np.array(shapely.linestrings(np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)))
    tree = shapely.STRtree(sides)
    (_, _), found = tree.query_nearest(
        shapely.points(points), return_distance=True, all_matches=False
    )
    return np.asarray(found)
