"""Closest points of a mesh's flat triangles, many at once.

The nearest of points spread over the triangles tell which triangles to look at; from the best of
them the way goes on to those around it as long as one is nearer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import KDTree

from fabgeo.arrays import Array, IntArray, dot

CANDIDATES = 6  # triangles looked at for one closest point, before those around the best of them
MOST_AROUND = 24  # triangles that are looked at around one
HOPS = 4  # times that a closest point moves on to a triangle around the last


@dataclass(frozen=True, eq=False)
class Place:
    """Places on the triangles: which one (k,) and barycentric coordinates (k, 3)."""

    triangle: IntArray
    weight: Array


class FlatTriangles:
    """The triangles (t, 3) of vertices (n, 3), prepared for searches."""

    def __init__(self, vertices: Array, triangles: IntArray) -> None:
        self._vertices, self._triangles = vertices, triangles
        self._samples, self._owner = _samples(vertices, triangles)
        self._around = _around(triangles)
        self._tree = KDTree(self._samples)

    def __getstate__(self) -> dict[str, object]:
        return {k: v for k, v in self.__dict__.items() if k != "_tree"}

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        self._tree = KDTree(self._samples)

    def nearest(self, x: Array) -> tuple[Place, Array]:
        """Closest places on the flat triangles, and their points."""
        count = min(CANDIDATES, len(self._samples))
        _, near = self._tree.query(x, k=count)
        place, at = self._nearest_of(x, self._owner[near.reshape(len(x), count)])
        # On a side of a triangle: one around it that has no sample near may be nearer.
        todo = np.flatnonzero(place.weight.min(axis=1) <= 0.0)
        for _ in range(HOPS):
            new, foot = self._nearest_of(x[todo], self._around[place.triangle[todo]])
            before, now = (((p - x[todo]) ** 2).sum(axis=1) for p in (at[todo], foot))
            nearer = now < before * (1.0 - 1e-12)
            if not nearer.any():
                break
            todo = todo[nearer]
            place.triangle[todo], place.weight[todo] = new.triangle[nearer], new.weight[nearer]
            at[todo] = foot[nearer]
        return place, at

    def _nearest_of(self, x: Array, candidates: IntArray) -> tuple[Place, Array]:
        """Closest places on candidate triangles (k, c), and their points."""
        corners = self._vertices[self._triangles[candidates]]
        weight = _barycentric(x[:, None], corners)
        at = np.einsum("kca,kcad->kcd", weight, corners)
        pick = np.argmin(((at - x[:, None]) ** 2).sum(axis=-1), axis=1)
        rows = np.arange(len(x))
        return Place(candidates[rows, pick], weight[rows, pick]), at[rows, pick]


def _around(triangles: IntArray) -> IntArray:
    """Triangles that have a corner in common with each, (t, at most MOST_AROUND), and itself."""
    count = len(triangles)
    row = np.repeat(np.arange(count), 3)
    at = csr_array((np.ones(len(row)), (row, triangles.ravel())))
    shared = csr_array(at @ at.T)
    place = np.arange(len(shared.indices)) - np.repeat(shared.indptr[:-1], np.diff(shared.indptr))
    width = min(int(np.diff(shared.indptr).max()), MOST_AROUND)
    # Those across a side, which share two corners, come first.
    owner = np.repeat(np.arange(count), np.diff(shared.indptr))
    order = np.lexsort((-shared.data, owner))
    around = np.repeat(np.arange(count)[:, None], width, axis=1)
    kept = place < width
    around[owner[kept], place[kept]] = shared.indices[order][kept]
    return around


def _samples(vertices: Array, triangles: IntArray) -> tuple[Array, IntArray]:
    """Points on the triangles so dense that the nearest ones tell which triangles are near."""
    p = vertices[triangles]
    longest = np.linalg.norm(p - np.roll(p, 1, axis=1), axis=-1).max(axis=1)
    parts = np.clip(np.ceil(longest / np.median(longest)), 1, 12).astype(np.int64)
    points, owner = [], []
    for n in np.unique(parts):
        rows = np.flatnonzero(parts == n)
        i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
        inside = i + j < n
        a, b = (i[inside] + 1 / 3) / n, (j[inside] + 1 / 3) / n
        weight = np.stack([1.0 - a - b, a, b], axis=1)
        points.append(np.einsum("ca,tad->tcd", weight, p[rows]).reshape(-1, 3))
        owner.append(np.repeat(rows, len(a)))
    return np.concatenate(points), np.concatenate(owner)


def _barycentric(x: Array, corners: Array) -> Array:
    """Barycentric coordinates (..., 3) of the closest points of triangles (..., 3, 3).

    Source: Ericson, Real-Time Collision Detection, section 5.1.5 (all regions at once: the
    projection if it lies inside, else the best of the three sides).
    """
    a, b, c = corners[..., 0, :], corners[..., 1, :], corners[..., 2, :]
    ab, ac, ax = b - a, c - a, x - a
    aa, bb, cc = dot(ab, ab), dot(ab, ac), dot(ac, ac)
    p, q = dot(ab, ax), dot(ac, ax)
    det = np.maximum(aa * cc - bb * bb, 1e-300)
    v, w = (cc * p - bb * q) / det, (aa * q - bb * p) / det
    best = np.stack([1.0 - v - w, v, w], axis=-1)
    outside = (best < 0.0).any(axis=-1)
    shortest = np.where(outside, np.inf, -1.0)
    for k in range(3):
        start, end = corners[..., k, :], corners[..., (k + 1) % 3, :]
        along = end - start
        t = np.clip(dot(x - start, along) / np.maximum(dot(along, along), 1e-300), 0.0, 1.0)
        distance = ((start + t[..., None] * along - x) ** 2).sum(axis=-1)
        side = np.zeros_like(best)
        side[..., k], side[..., (k + 1) % 3] = 1.0 - t, t
        nearer = distance < shortest
        best = np.where(nearer[..., None], side, best)
        shortest = np.minimum(shortest, np.where(nearer, distance, shortest))
    return best
