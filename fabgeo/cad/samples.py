"""Faces and edges of a solid as plain numbers."""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepLProp import BRepLProp_SLProps
from OCP.BRepTools import BRepTools
from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
from OCP.GCPnts import GCPnts_AbscissaPoint
from OCP.GeomAbs import GeomAbs_CurveType
from OCP.gp import gp_Dir, gp_Pnt, gp_Pnt2d
from OCP.TopAbs import TopAbs_Orientation, TopAbs_State
from OCP.TopoDS import TopoDS_Edge, TopoDS_Face, TopoDS_Shape

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
class EdgeSamples:
    """One edge in numbers: its kind (line, circle, bspline, ...), length (mm), points (k, 3)."""

    kind: str
    length: float
    points: Array
    faces: tuple[int, ...]
    """Indices of the faces that it bounds, in the part's order of faces."""


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


def edge_samples(shape: TopoDS_Shape, count: int, most: int = 0) -> Iterator[EdgeSamples]:
    """Every edge once, sampled at `count` even parameters.

    Where `most` is more, at up to so many, all edges alike: as many as give two to a knot span of
    the edge that has most of them. A cubic spline through them is then such an edge itself.
    """
    users: list[tuple[TopoDS_Edge, list[int]]] = []
    index: dict[int, list[int]] = {}
    for number, face in enumerate(kernel.faces(shape)):
        for edge in kernel.edges(face):
            bucket = index.setdefault(hash(edge), [])
            key = next((k for k in bucket if users[k][0].IsSame(edge)), -1)
            if key < 0:
                bucket.append(len(users))
                users.append((edge, [number]))
            elif number not in users[key][1]:
                users[key][1].append(number)
    curves = [
        (BRepAdaptor_Curve(edge), faces)
        for edge, faces in users
        if not BRep_Tool.Degenerated_s(edge)
    ]
    if most > count:
        spans = max((_spans(curve) for curve, _ in curves), default=1)
        count = max(count, min(2 * spans + 1, most))
    for curve, faces in curves:
        first, last = curve.FirstParameter(), curve.LastParameter()
        points = _points(curve, np.linspace(first, last, count))
        kind = curve.GetType().name.removeprefix("GeomAbs_").removesuffix("Curve").lower()
        length = float(GCPnts_AbscissaPoint.Length_s(curve, 1e-7))
        yield EdgeSamples(kind, length, points, tuple(faces))


def _spans(curve: BRepAdaptor_Curve) -> int:
    """Knot spans of a B-spline; of any other curve one."""
    spline = curve.GetType() == GeomAbs_CurveType.GeomAbs_BSplineCurve
    return curve.NbKnots() - 1 if spline else 1


def _points(curve: BRepAdaptor_Curve, t: Array) -> Array:
    """Points (k, 3) of a curve: one array for all, as one for each takes longer than the curve."""
    points = [curve.Value(at) for at in t.tolist()]
    return np.array([(p.X(), p.Y(), p.Z()) for p in points])
