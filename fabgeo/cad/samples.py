"""Faces and edges of a solid as plain numbers."""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepLProp import BRepLProp_SLProps
from OCP.BRepTools import BRepTools
from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
from OCP.GCPnts import GCPnts_AbscissaPoint
from OCP.gp import gp_Dir, gp_Pnt, gp_Pnt2d
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum, TopAbs_State
from OCP.TopoDS import TopoDS, TopoDS_Face, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from fabgeo.arrays import Array
from fabgeo.cad import kernel, measure


@dataclass(frozen=True)
class FaceSamples:
    """One face in numbers.

    Attributes
    ----------
    kind : str
        plane, cylinder, cone, bspline, ...
    area : float
        mm2.
    points, normals : (k, 3) array
        On the face; normals point out of the solid.
    curvatures : (k, 2) array
        Principal curvatures (1/mm), of the larger and of the smaller size; positive where the
        face bends away from its outward normal.
    directions : (k, 2, 3) array
        Principal directions that belong to them.
    """

    kind: str
    area: float
    points: Array
    normals: Array
    curvatures: Array
    directions: Array


@dataclass(frozen=True)
class ReadEdge:
    """One edge in numbers.

    Attributes
    ----------
    kind : str
        line, circle, bspline, ...
    length : float
        mm.
    faces : tuple of int
        Indices of the faces that it bounds, in the part's order of faces.
    spans, poles : int
        Knot spans and control points; of what is no B-spline 1, and 2 for a line, 0 for others.
    curve : BRepAdaptor_Curve
    """

    kind: str
    length: float
    faces: tuple[int, ...]
    spans: int
    poles: int
    curve: BRepAdaptor_Curve

    def points(self, count: int) -> Array:
        """Points (count, 3) at even parameters, first and last with them."""
        first, last = self.curve.FirstParameter(), self.curve.LastParameter()
        sites = (first + (last - first) * _even(count)).tolist()
        return np.array([self.curve.Value(at).Coord() for at in sites])


@cache
def _even(count: int) -> Array:
    return np.linspace(0.0, 1.0, count)


def face_samples(face: TopoDS_Face, count: int) -> FaceSamples:
    """One face on a count x count grid of its parameters, points inside only."""
    adaptor = BRepAdaptor_Surface(face)
    sign = -1.0 if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else 1.0
    inside = BRepTopAdaptor_FClass2d(face, 1e-7)
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
    points, normals, curvatures, directions = [], [], [], []
    for u in np.linspace(u0, u1, count):
        for v in np.linspace(v0, v1, count):
            if inside.Perform(gp_Pnt2d(u, v)) == TopAbs_State.TopAbs_OUT:
                continue
            local = BRepLProp_SLProps(adaptor, float(u), float(v), 2, 1e-9)
            if not local.IsNormalDefined():
                continue
            points.append(_xyz(local.Value()))
            normals.append(sign * _xyz(local.Normal()))
            values, axes = _principal(local)
            curvatures.append(-sign * values)
            directions.append(axes)
    return FaceSamples(
        measure.surface_kind(adaptor),
        measure.surface_area(face),
        np.reshape(points, (-1, 3)),
        np.reshape(normals, (-1, 3)),
        np.reshape(curvatures, (-1, 2)),
        np.reshape(directions, (-1, 2, 3)),
    )


def gaussian_curvatures(face: TopoDS_Face, count: int) -> Array:
    """Gaussian curvatures (k,) in 1/mm2 on a count x count grid of a face's parameters.

    Holes are not left out: the surface goes on across them.
    """
    adaptor = BRepAdaptor_Surface(face)
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
    found = []
    for u in np.linspace(u0, u1, count).tolist():
        for v in np.linspace(v0, v1, count).tolist():
            local = BRepLProp_SLProps(adaptor, u, v, 2, 1e-9)
            if local.IsNormalDefined() and local.IsCurvatureDefined():
                found.append(local.GaussianCurvature())
    return np.array(found)


def _principal(local: BRepLProp_SLProps) -> tuple[Array, Array]:
    """Principal curvatures and directions, the larger by size first; zeros on planes."""
    if not local.IsCurvatureDefined():
        return np.zeros(2), np.zeros((2, 3))
    high, low = gp_Dir(), gp_Dir()
    values = np.array([local.MaxCurvature(), local.MinCurvature()])
    local.CurvatureDirections(high, low)
    axes = np.array([_xyz(high), _xyz(low)])
    order = np.argsort(-np.abs(values))
    return values[order], axes[order]


def _xyz(value: gp_Pnt | gp_Dir) -> Array:
    return np.array([value.X(), value.Y(), value.Z()])


def read_edges(shape: TopoDS_Shape) -> Iterator[ReadEdge]:
    """Every edge once, but for degenerate ones."""
    known = TopTools_IndexedMapOfShape()
    around: dict[int, dict[int, None]] = {}
    for number, face in enumerate(kernel.faces(shape)):
        for edge in kernel.explore(face, TopAbs_ShapeEnum.TopAbs_EDGE):
            around.setdefault(known.Add(edge), {})[number] = None
    for key, faces in around.items():
        edge = TopoDS.Edge_s(known.FindKey(key))
        if not BRep_Tool.Degenerated_s(edge):
            yield _read_edge(BRepAdaptor_Curve(edge), tuple(faces))


def _read_edge(curve: BRepAdaptor_Curve, faces: tuple[int, ...]) -> ReadEdge:
    kind = curve.GetType().name.removeprefix("GeomAbs_").removesuffix("Curve").lower()
    length = float(GCPnts_AbscissaPoint.Length_s(curve, 1e-7))
    if kind == "bspline":
        return ReadEdge(kind, length, faces, curve.NbKnots() - 1, curve.NbPoles(), curve)
    return ReadEdge(kind, length, faces, 1, 2 if kind == "line" else 0, curve)
