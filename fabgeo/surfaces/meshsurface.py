"""A smooth design surface over an irregular mesh.

Every vertex carries a quadratic patch fitted to its neighbourhood (an osculating paraboloid). Over
a triangle the three patches of its corners are blended with weights that vanish to first order at
the opposite edge. The blended surface passes through every vertex; normals and shape tensors are
blended in the same way. In its tangent directions a boundary is the mesh's own polygon.
The blend: squares of the barycentric coordinates.
"""

from __future__ import annotations

import hashlib
from functools import cached_property

import numpy as np

from fabgeo.arrays import (
    FARTHEST,
    Array,
    BoolArray,
    IntArray,
    checked,
    checked_count,
    cross,
    dot,
    unit,
)
from fabgeo.errors import InputError
from fabgeo.surfaces.base import MOST_SAMPLES, SurfacePoints
from fabgeo.surfaces.flattriangles import FlatTriangles, Place
from fabgeo.surfaces.mesh import Mesh
from fabgeo.surfaces.units import Unit
from fabgeo.surfaces.vertexpatches import vertex_patches

CHUNK = 20000
# Between the normals of a triangle: of three that cancel, two differ by 120 degrees or more.
LEAST_COSINE = -0.5


class MeshSurface:
    """A smooth design surface over a mesh (protocol `DesignSurface`).

    Parameters
    ----------
    mesh : Mesh
        In millimetres.
    name : str
        For messages.

    Raises
    ------
    InputError
        If the mesh turns by more than 120 degrees within one triangle.

    Attributes
    ----------
    mesh : Mesh
    grid : None
        An irregular mesh has no grid (a regular one makes a `GridSurface`).
    """

    grid = None
    # The unit of the file it was read from; None if it wasn't.
    unit: Unit | None = None

    def __init__(self, mesh: Mesh, name: str = "mesh") -> None:
        self.mesh = mesh
        self._name = name
        self.triangles = mesh.triangulated
        self.patches = vertex_patches(mesh)
        self._check_bends()
        self.size = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
        self._border = _border_sides(self.triangles, mesh)
        self._rim = np.isin(self.triangles, np.concatenate([[-1], *mesh.loops]))
        self._flat = FlatTriangles(mesh.vertices, self.triangles)
        self._sign = 1.0
        self._sign = self._turn()

    @property
    def name(self) -> str:
        """How messages call it."""
        return self._name

    @property
    def bounds(self) -> Array:
        """Bounding box (2, 3) of the vertices."""
        return np.stack([self.mesh.vertices.min(axis=0), self.mesh.vertices.max(axis=0)])

    @cached_property
    def area(self) -> float:
        """Area of the flat triangles."""
        p = self.mesh.vertices[self.triangles]
        return float(np.linalg.norm(cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum() / 2)

    @property
    def loops(self) -> tuple[Array, ...]:
        """Boundary loops with three points more on every edge, curved as the surface is."""
        return self._loops

    @cached_property
    def _loops(self) -> tuple[Array, ...]:
        t = np.arange(4)[:, None] / 4.0
        loops = []
        for loop in self.mesh.loops:
            p = self.mesh.vertices[loop]
            dense = (p[:, None] + t * (np.roll(p, -1, axis=0) - p)[:, None]).reshape(-1, 3)
            place, _ = self._flat.nearest(dense)
            loops.append(self._blend(place)[0])
        return tuple(loops)

    @cached_property
    def fingerprint(self) -> str:
        """Hash of the content: equal for equal surfaces."""
        digest = hashlib.sha256(np.ascontiguousarray(self.mesh.vertices).tobytes())
        digest.update(np.ascontiguousarray(self.triangles).tobytes())
        return digest.hexdigest()

    def sample(self, count: int) -> SurfacePoints:
        """About `count` points spread evenly by area."""
        checked_count("samples", count, 1, MOST_SAMPLES)
        p, t = self.mesh.vertices, self.triangles
        area = np.linalg.norm(cross(p[t[:, 1]] - p[t[:, 0]], p[t[:, 2]] - p[t[:, 0]]), axis=1)
        bound = np.cumsum(area) / area.sum()
        k = np.arange(1, count + 1)
        which = np.minimum(np.searchsorted(bound, (k - 0.5) / len(k)), len(t) - 1)
        a, b = np.mod(0.5 + k[:, None] * np.array([0.7548776662466927, 0.5698402909980532]), 1.0).T
        over = a + b > 1.0
        a, b = np.where(over, 1.0 - a, a), np.where(over, 1.0 - b, b)
        place = Place(which, np.stack([1.0 - a - b, a, b], axis=1))
        return SurfacePoints(*self._blend(place), np.zeros(len(k), dtype=bool))

    def closest(self, points: Array) -> SurfacePoints:
        """Closest points of `points` (k, 3) with normal, shape tensor and boundary flag."""
        x = checked("points", points, (None, 3), most=FARTHEST)
        parts = [self._closest(x[i : i + CHUNK]) for i in range(0, max(len(x), 1), CHUNK)]
        if len(parts) == 1:
            return parts[0]
        columns = zip(*((p.point, p.normal, p.shape, p.on_boundary) for p in parts), strict=True)
        return SurfacePoints(*(np.concatenate(c) for c in columns))

    def _closest(self, x: Array, steps: int = 12) -> SurfacePoints:
        """Walk over the triangles until what is left of x - y points along the normal."""
        place, foot = self._flat.nearest(x)
        point, normal, shape = self._blend(place)
        todo = np.arange(len(x))
        for _ in range(steps):
            # On the border the curvature across it must not push the foot along it.
            here = Place(place.triangle[todo], place.weight[todo])
            bend = np.where(self._on_border(here)[:, None, None], 0.0, shape[todo])
            move = _tangent_step(x[todo] - point[todo], normal[todo], bend)
            new, at = self._flat.nearest(foot[todo] + move)
            going = np.linalg.norm(at - foot[todo], axis=1) > 1e-7 * self.size
            if not going.any():
                break
            rows = todo[going]
            place.triangle[rows], place.weight[rows] = new.triangle[going], new.weight[going]
            foot[rows] = at[going]
            fresh = self._blend(Place(new.triangle[going], new.weight[going]))
            point[rows], normal[rows], shape[rows] = fresh
            todo = rows
        return SurfacePoints(point, normal, shape, self._on_border(place))

    def _blend(self, place: Place) -> tuple[Array, Array, Array]:
        """Points, normals and shape tensors of the smooth surface."""
        corner = self.triangles[place.triangle]
        vertex, frame = self.mesh.vertices[corner], self.patches.frame[corner]
        flat = np.einsum("ka,kad->kd", place.weight, vertex)
        local = np.einsum("kad,kajd->kaj", flat[:, None] - vertex, frame)
        a, b, c, d, e = np.moveaxis(self.patches.form[corner], -1, 0)
        s, t = local[..., 0], local[..., 1]
        hs, ht = a * s + b * t + d, b * s + c * t + e
        h = (a * s * s + 2.0 * b * s * t + c * t * t) / 2.0 + d * s + e * t
        each = vertex + np.einsum("kaj,kajd->kad", np.stack([s, t, h], axis=-1), frame)
        weight = place.weight**2
        weight = weight / weight.sum(axis=1, keepdims=True)
        point = np.einsum("ka,kad->kd", weight, each)
        up = np.stack([-hs, -ht, np.ones_like(hs)], axis=-1)
        up /= np.linalg.norm(up, axis=-1, keepdims=True)
        normal = unit(np.einsum("ka,kaj,kajd->kd", weight, up, frame)) * self._sign
        # The height's Hessian over the slope's length, carried to tangents, is the shape tensor.
        hessian = np.zeros((*h.shape, 3, 3))
        hessian[..., 0, 0], hessian[..., 1, 1] = a, c
        hessian[..., 0, 1] = hessian[..., 1, 0] = b
        hessian *= up[..., 2, None, None]
        bent = np.einsum("ka,kaij,kaid,kajf->kdf", weight, hessian, frame, frame) * self._sign
        tangent = np.eye(3) - normal[:, :, None] * normal[:, None]
        return point, normal, np.einsum("kab,kbc,kcd->kad", tangent, bent, tangent)

    def _on_border(self, place: Place) -> BoolArray:
        """On a side of the boundary, or at its corner in a triangle that has no such side."""
        side = (place.weight < 1e-9) & self._border[place.triangle]
        return (side | ((place.weight > 1.0 - 1e-9) & self._rim[place.triangle])).any(axis=1)

    def _check_bends(self) -> None:
        """Refuse triangles whose corners' normals could cancel: that is no smooth surface."""
        normal = self.patches.frame[self.triangles, 2]
        least = dot(normal, np.roll(normal, -1, axis=1)).min(axis=1)
        if least.min(initial=1.0) > LEAST_COSINE:
            return
        face = int(least.argmin())
        where = np.round(self.mesh.vertices[self.triangles[face]].mean(axis=0), 6).tolist()
        if np.isnan(least[face]):
            raise InputError(
                self._name,
                f"a triangle has no normal at its corners, around {where}",
                "move its vertices apart, or divide the polygons there into triangles",
            )
        angle = np.degrees(np.arccos(np.clip(least[face], -1.0, 1.0)))
        raise InputError(
            self._name,
            f"the mesh turns by {angle:.0f} degrees within one triangle, around {where}",
            "refine it there, or divide it along its creases",
        )

    def _turn(self) -> float:
        """+1 or -1: so that normals point up in the mean, or outwards where that says nothing."""
        at = self.sample(1000)
        up = float(at.normal[:, 2].mean())
        out = float(dot(at.normal, unit(at.point - at.point.mean(axis=0))).mean())
        return float(np.sign(up if abs(up) > 0.1 else out) or 1.0)


def _tangent_step(r: Array, normal: Array, shape: Array) -> Array:
    """Newton step in the tangent plane: (1 - h S) step = r - h n, h = r . n."""
    h = dot(r, normal)
    tangent = r - h[:, None] * normal
    # Beyond the centre of curvature the step would turn round: stay at half the way there.
    bend = np.linalg.norm(shape, axis=(1, 2))
    h = h * np.minimum(1.0, 0.7 / np.maximum(np.abs(h) * bend, 1e-300))
    return np.linalg.solve(np.eye(3) - h[:, None, None] * shape, tangent[..., None])[..., 0]


def _border_sides(triangles: IntArray, mesh: Mesh) -> BoolArray:
    """(t, 3): whether the side opposite to a corner is on the boundary."""
    edges = {(int(a), int(b)) for x in mesh.loops for a, b in zip(x, np.roll(x, -1), strict=True)}
    edges |= {(b, a) for a, b in edges}
    rows = triangles.tolist()
    return np.array([[(t[(k + 1) % 3], t[(k + 2) % 3]) in edges for k in range(3)] for t in rows])
