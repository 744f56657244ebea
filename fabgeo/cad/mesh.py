"""Triangles of prisms and of any solid, for viewing."""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Shape
from scipy.interpolate import BSpline

from fabgeo.cad import kernel
from fabgeo.cad.boredmesh import Mesh, bored_skin, bores, joined, rings_of
from fabgeo.cad.rims import Skin, walls_of
from fabgeo.cad.sound import check_prism
from fabgeo.structures.parts import Hole, Prism


def prism_mesh(prism: Prism, per_span: int = 4, holes: Sequence[Hole] = ()) -> Mesh:
    """Triangles of a prism straight from its edge curves; no vertex is shared between faces.

    Ends of more than four sides are fanned from their centre, so they should be star-shaped.
    Holes run through the faces 0 and 2 of a prism of four sides.
    """
    poles = prism.poles if check_prism(prism) else prism.poles[::-1]
    spans = np.unique(prism.knots)
    steps = per_span * (len(spans) - 1)
    u = np.interp(np.arange(steps + 1) / per_span, np.arange(len(spans)), spans)
    curves = np.moveaxis(np.asarray(BSpline(prism.knots, np.moveaxis(poles, 1, 0), 3)(u)), 1, 0)
    strip = np.arange(steps)
    lower, upper = strip, strip + steps + 1
    band = np.concatenate(
        [np.stack([lower, lower + 1, upper], 1), np.stack([lower + 1, upper + 1, upper], 1)]
    )
    made: list[Mesh] = []
    for j in range(len(poles)):
        k = (j + 1) % len(poles)
        if not (holes and j in (0, 2)):
            made.append((np.concatenate([curves[j], curves[k]]), band))
    if holes:
        skins = [Skin(prism.mark, prism.knots, poles[[j, j + 1]]) for j in (0, 2)]
        walls = walls_of(holes)
        rings = [rings_of(skin, walls) for skin in skins]
        made += [
            bored_skin(u, curves[[j, j + 1]], own) for j, own in zip((0, 2), rings, strict=True)
        ]
        made += bores(*rings)
    for k, forward in ((0, True), (-1, False)):
        ring = curves[:, k]
        j = np.arange(len(ring))
        fan = np.stack([j, (j + 1) % len(ring), np.full(len(ring), len(ring))], 1)
        ends = np.concatenate([ring, ring.mean(axis=0)[None]])
        made.append((ends, fan if forward else fan[:, ::-1]))
    return joined(made)


def shape_mesh(shape: TopoDS_Shape, sag: float = 1.0, angle: float = 0.2) -> Mesh:
    """Triangles of any shape by the kernel: `sag` in mm, `angle` in radians."""
    BRepMesh_IncrementalMesh(shape, sag, False, angle, False)
    made: list[Mesh] = []
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
        made.append((xyz @ matrix[:3, :3].T + matrix[:3, 3], index - 1))
    return joined(made)
