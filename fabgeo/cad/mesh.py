"""Triangles of prisms and of any solid, for viewing."""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Shape
from scipy.interpolate import BSpline

from fabgeo.arrays import Array, IntArray
from fabgeo.cad import kernel
from fabgeo.cad.sound import check_prism
from fabgeo.structures.parts import Prism

type Mesh = tuple[Array, IntArray]
"""Vertices (n, 3) in mm and triangles (m, 3), counter-clockwise seen from outside."""


def prism_mesh(prism: Prism, per_span: int = 4) -> Mesh:
    """Triangles of a prism straight from its edge curves; no vertex is shared between faces.

    Ends of more than four sides are fanned from their centre, so they should be star-shaped.
    """
    poles = prism.poles if check_prism(prism) else prism.poles[::-1]
    spans = np.unique(prism.knots)
    steps = per_span * (len(spans) - 1)
    u = np.interp(np.arange(steps + 1) / per_span, np.arange(len(spans)), spans)
    curves = np.moveaxis(np.asarray(BSpline(prism.knots, np.moveaxis(poles, 1, 0), 3)(u)), 1, 0)
    vertices, triangles, count = [], [], 0
    strip = np.arange(steps)
    lower, upper = strip, strip + steps + 1
    band = np.concatenate(
        [np.stack([lower, lower + 1, upper], 1), np.stack([lower + 1, upper + 1, upper], 1)]
    )
    for j in range(len(poles)):
        vertices.append(np.concatenate([curves[j], curves[(j + 1) % len(poles)]]))
        triangles.append(band + count)
        count += len(vertices[-1])
    for k, forward in ((0, True), (-1, False)):
        ring = curves[:, k]
        vertices.append(np.concatenate([ring, ring.mean(axis=0)[None]]))
        j = np.arange(len(ring))
        fan = np.stack([j, (j + 1) % len(ring), np.full(len(ring), len(ring))], 1)
        triangles.append((fan if forward else fan[:, ::-1]) + count)
        count += len(vertices[-1])
    return np.concatenate(vertices), np.concatenate(triangles).astype(np.int64)


def shape_mesh(shape: TopoDS_Shape, sag: float = 1.0, angle: float = 0.2) -> Mesh:
    """Triangles of any shape by the kernel: `sag` in mm, `angle` in radians."""
    BRepMesh_IncrementalMesh(shape, sag, False, angle, False)
    vertices, triangles, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], 0
    for face in kernel.faces(shape):
        place = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(face, place)
        if mesh is None:
            continue
        matrix = kernel.to_matrix(place)
        nodes = [mesh.Node(k) for k in range(1, mesh.NbNodes() + 1)]
        xyz = np.array([[p.X(), p.Y(), p.Z()] for p in nodes])
        index = np.array([mesh.Triangle(k).Get() for k in range(1, mesh.NbTriangles() + 1)])
        if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
            index = index[:, ::-1]
        vertices.append(xyz @ matrix[:3, :3].T + matrix[:3, 3])
        triangles.append(index - 1 + count)
        count += len(xyz)
    return np.concatenate(vertices), np.concatenate(triangles)
