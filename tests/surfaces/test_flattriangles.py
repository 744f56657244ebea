"""Closest points on meshes: all triangles that matter are looked at, and all of the boundary."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from fabgeo.surfaces.flattriangles import FlatTriangles
from fabgeo.surfaces.mesh import Mesh, checked_mesh
from fabgeo.surfaces.meshsurface import MeshSurface


def _scattered(points: np.ndarray) -> Mesh:
    """A mesh over scattered places (n, 2), lifted to a dome."""
    faces = Delaunay(points).simplices
    height = 2.0 - 0.03 * points[:, 0] ** 2 - 0.06 * points[:, 1] ** 2
    return checked_mesh("dome", np.column_stack([points, height]), faces.tolist())


def test_nearest_of_slender_triangles_is_that_of_all():
    rng = np.random.default_rng(4)
    mesh = _scattered(rng.uniform((-6.0, -1.0), (6.0, 1.0), (60, 2)))
    triangles = mesh.triangulated
    x = mesh.vertices.mean(axis=0) + rng.normal(size=(400, 3)) * (3.5, 0.6, 0.4)
    _, found = FlatTriangles(mesh.vertices, triangles).nearest(x)
    each = [FlatTriangles(mesh.vertices, t[None]).nearest(x)[1] for t in triangles]
    best = np.min([np.linalg.norm(y - x, axis=1) for y in each], axis=0)
    assert np.linalg.norm(found - x, axis=1) == pytest.approx(best, abs=1e-12)


def test_all_that_lies_beyond_a_round_boundary_is_beside_it():
    rim = np.linspace(0.0, 2.0 * np.pi, 61)[:-1]
    k = np.arange(300)
    r, angle = np.sqrt((k + 0.5) / 300) * 0.97, k * 2.399963
    inner = np.column_stack([r * np.cos(angle), r * np.sin(angle)])
    outer = np.column_stack([np.cos(rim), np.sin(rim)])
    surface = MeshSurface(_scattered(np.concatenate([inner, outer]) * (8.0, 6.0)))
    dense = np.linspace(0.0, 2.0 * np.pi, 2000)
    beyond = np.column_stack([9.0 * np.cos(dense), 7.0 * np.sin(dense), 0.0 * dense - 0.5])
    assert surface.closest(beyond).on_boundary.all()
