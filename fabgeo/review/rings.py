"""Closed polygons in the plane: distances from them."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array


def distances(points: Array, ring: Array) -> Array:
    """Distances (k,) of points (k, 2) from a closed polygon (n, 2), its sides gone through."""
    import shapely

    # A tree of the sides pays from some hundred thousand pairs on only: few outlines have as many.
    return np.asarray(shapely.distance(shapely.points(points), shapely.LinearRing(ring)))
