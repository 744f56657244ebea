"""A face of the kernel as plain B-spline data.

Every surface converts exactly: planes, cylinders, spheres and tori become rational ones.
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.cad.isolated import of_kernel
from fabgeo.errors import InputError
from fabgeo.surfaces.nurbs import NurbsFace

CURVE_SAMPLES = 48  # per polynomial piece of a trimming curve
MOST_SAMPLES = 2000


def nurbs_face(where: str, face: Any, name: str, colour: Any) -> NurbsFace:
    """A face of the kernel as B-spline data with its trimming loops.

    Parameters
    ----------
    where : str
        What an error names: the file.
    face : TopoDS_Face
    name : str
    colour : tuple of float or None
        RGB, kept with the face.

    Raises
    ------
    InputError
        If the kernel can't convert it.
    """
    from OCP.BRep import BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
    from OCP.Geom import Geom_BSplineSurface
    from OCP.GeomConvert import GeomConvert
    from OCP.TopoDS import TopoDS

    try:
        converted = BRepBuilderAPI_NurbsConvert(face, True)
        spline_face = TopoDS.Face_s(converted.Shape())
        surface = BRep_Tool.Surface_s(spline_face)
        if not isinstance(surface, Geom_BSplineSurface):
            surface = GeomConvert.SurfaceToBSplineSurface_s(surface)
        surface = surface.Copy()
        _open_knots(surface)
    except Exception as error:
        if not of_kernel(error):
            raise
        problem = f"{name} can't be converted to a B-spline: {error}"
        raise InputError(where, problem, "trim or rebuild it, and export it again") from error
    poles, weights = _poles(surface)
    return NurbsFace(
        poles=poles,
        weights=weights,
        knots_u=_flat(surface.NbUKnots(), surface.UKnot, surface.UMultiplicity),
        knots_v=_flat(surface.NbVKnots(), surface.VKnot, surface.VMultiplicity),
        degree_u=surface.UDegree(),
        degree_v=surface.VDegree(),
        trims=tuple(_loops(spline_face)),
        name=name,
        colour=colour,
    )


def _open_knots(surface: Any) -> None:
    """Give a periodic surface ordinary end knots."""
    if surface.IsUPeriodic():
        surface.SetUNotPeriodic()
    if surface.IsVPeriodic():
        surface.SetVNotPeriodic()


def _poles(surface: Any) -> tuple[Array, Array | None]:
    rows, columns = surface.NbUPoles(), surface.NbVPoles()
    poles = np.empty((rows, columns, 3))
    weights = np.ones((rows, columns))
    rational = surface.IsURational() or surface.IsVRational()
    for i in range(rows):
        for j in range(columns):
            p = surface.Pole(i + 1, j + 1)
            poles[i, j] = p.X(), p.Y(), p.Z()
            if rational:
                weights[i, j] = surface.Weight(i + 1, j + 1)
    return poles, weights if rational else None


def _flat(count: int, knot: Any, multiplicity: Any) -> Array:
    values = [knot(i) for i in range(1, count + 1)]
    return np.repeat(values, [multiplicity(i) for i in range(1, count + 1)])


def _loops(face: Any) -> list[Array]:
    """Trimming loops as polylines (k, 2) in the face's parameters."""
    from OCP.BRepTools import BRepTools_WireExplorer
    from OCP.TopAbs import TopAbs_WIRE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    loops = []
    wires = TopExp_Explorer(face, TopAbs_WIRE)
    while wires.More():
        explorer = BRepTools_WireExplorer(TopoDS.Wire_s(wires.Current()), face)
        points: list[Array] = []
        while explorer.More():
            points.append(_edge_points(explorer.Current(), face))
            explorer.Next()
        if points:
            loop = _thinned(np.concatenate([p[:-1] for p in points]))
            if len(loop) >= 3:
                loops.append(loop)
        wires.Next()
    return loops


def _thinned(loop: Array) -> Array:
    """The loop without points that lie within 1e-6 of its size on a straight line."""
    import shapely

    size = float(np.linalg.norm(np.ptp(loop, axis=0)))
    line = shapely.LineString(np.concatenate([loop, loop[:1]]))
    return np.asarray(shapely.simplify(line, 1e-6 * size).coords)[:-1]


def _edge_points(edge: Any, face: Any) -> Array:
    """Points (k, 2) of an edge's curve in the face's parameters, in the edge's direction."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve2d
    from OCP.GeomAbs import GeomAbs_BezierCurve, GeomAbs_BSplineCurve, GeomAbs_Line
    from OCP.TopAbs import TopAbs_REVERSED

    curve = BRepAdaptor_Curve2d(edge, face)
    first, last = curve.FirstParameter(), curve.LastParameter()
    kind = curve.GetType()
    pieces = 1
    if kind == GeomAbs_BSplineCurve:
        pieces = curve.NbKnots() - 1
    straight = kind == GeomAbs_Line or (
        kind in (GeomAbs_BSplineCurve, GeomAbs_BezierCurve) and curve.Degree() == 1 and pieces == 1
    )
    count = 2 if straight else min(max(CURVE_SAMPLES * pieces, 512), MOST_SAMPLES) + 1
    values = [curve.Value(t) for t in np.linspace(first, last, count)]
    points = np.array([[p.X(), p.Y()] for p in values])
    return points[::-1] if edge.Orientation() == TopAbs_REVERSED else points
