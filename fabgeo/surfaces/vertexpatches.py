"""Osculating paraboloids at the vertices of a mesh.

Source: Cazals, Pouget, Estimating differential quantities using polynomial fitting of osculating
jets (2005), degree 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix

from fabgeo.arrays import Array, IntArray, cross, dot, unit
from fabgeo.surfaces.mesh import Mesh

NEIGHBOURS = 24  # at most, for one vertex's patch


@dataclass(frozen=True, eq=False)
class VertexPatches:
    """Paraboloids x = v + s e1 + t e2 + h n, h = (a s^2 + 2 b s t + c t^2) / 2 + d s + e t.

    Attributes
    ----------
    frame : (n, 3, 3) array
        Rows e1, e2, n of every vertex.
    form : (n, 5) array
        a, b, c, d, e.
    """

    frame: Array
    form: Array


def vertex_patches(mesh: Mesh) -> VertexPatches:
    """The patches of all vertices: a weighted fit to the two-ring, seen along the mean normal."""
    near = _rings(mesh)
    normal = _vertex_normals(mesh)
    frame = np.empty((len(normal), 3, 3))
    form = np.empty((len(normal), 5))
    for _ in range(2):  # the second time along the fitted normal
        helper = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
        e1 = unit(cross(helper, normal))
        frame = np.stack([e1, cross(normal, e1), normal], axis=1)
        form = _fit(mesh.vertices, near, frame)
        slope = np.stack([-form[:, 3], -form[:, 4], np.ones(len(form))], axis=1)
        normal = unit(np.einsum("nk,nkd->nd", slope, frame))
    return VertexPatches(frame, form)


def _vertex_normals(mesh: Mesh) -> Array:
    p, t = mesh.vertices, mesh.triangulated
    face = cross(p[t[:, 1]] - p[t[:, 0]], p[t[:, 2]] - p[t[:, 0]])
    normal = np.zeros_like(p)
    for k in range(3):
        np.add.at(normal, t[:, k], face)
    return unit(normal)


def _rings(mesh: Mesh) -> IntArray:
    """Nearest of the one- to three-ring of every vertex, (n, NEIGHBOURS), padded with itself."""
    n = len(mesh.vertices)
    f = mesh.faces
    a = np.concatenate([np.array(face) for face in f])
    b = np.concatenate([np.roll(np.array(face), -1) for face in f])
    ones = np.ones(2 * len(a), dtype=bool)
    pairs = np.concatenate([a, b]), np.concatenate([b, a])
    one = coo_matrix((ones, pairs), shape=(n, n)).tocsr()
    two = (one + one @ one).tocsr()
    few = np.diff(two.indptr) < 12
    reach = (two + two @ one).tocsr() if few.any() else two
    near = np.repeat(np.arange(n)[:, None], NEIGHBOURS, axis=1)
    for i in range(n):
        rings = reach if few[i] else two
        ring = rings.indices[rings.indptr[i] : rings.indptr[i + 1]]
        ring = ring[ring != i]
        if len(ring) > NEIGHBOURS:
            distance = np.linalg.norm(mesh.vertices[ring] - mesh.vertices[i], axis=1)
            ring = ring[np.argpartition(distance, NEIGHBOURS)[:NEIGHBOURS]]
        near[i, : len(ring)] = ring
    return near


def _fit(vertices: Array, near: IntArray, frame: Array) -> Array:
    """Quadratic height forms (n, 5) through every vertex and near its neighbours."""
    local = np.einsum("nkd,njd->nkj", vertices[near] - vertices[:, None], frame)
    square = dot(local, local)
    reach = np.sqrt(square.max(axis=1, initial=0.0))[:, None]
    s, t, h = (local / reach[..., None]).transpose(2, 0, 1)
    weight = np.where(square > 0.0, np.exp(-2.0 * square / reach**2), 0.0)
    terms = np.stack([s * s / 2.0, s * t, t * t / 2.0, s, t], axis=-1)
    left = np.einsum("nka,nk,nkb->nab", terms, weight, terms)
    right = np.einsum("nka,nk,nk->na", terms, weight, h)
    left += 1e-9 * np.trace(left, axis1=1, axis2=2)[:, None, None] * np.eye(5)
    form = np.linalg.solve(left, right[..., None])[..., 0]
    form[:, :3] /= reach
    return form
