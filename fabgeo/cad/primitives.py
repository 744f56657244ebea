"""Plain exact solids: cylinders, tubes, hexagonal prisms, plates with holes; all along z."""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakePolygon,
    BRepBuilderAPI_MakeWire,
)
from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakePrism
from OCP.GC import GC_MakeArcOfCircle
from OCP.gp import gp_Vec
from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain
from OCP.TopoDS import TopoDS_Shape, TopoDS_Solid
from OCP.TopTools import TopTools_ListOfShape

from fabgeo.arrays import Array, cross
from fabgeo.cad import kernel
from fabgeo.errors import PartError

_X, _Y, _Z = np.eye(3)


def cylinder(diameter: float, z0: float, z1: float, x: float = 0.0, y: float = 0.0) -> TopoDS_Solid:
    """A round bar from z0 to z1."""
    frame = kernel.axes(np.array([x, y, z0]), _Z, _X).Ax2()
    return _one(BRepPrimAPI_MakeCylinder(frame, diameter / 2.0, z1 - z0).Shape(), "cylinder")


def tube(
    outer: float, inner: float, z0: float, z1: float, x: float = 0.0, y: float = 0.0
) -> TopoDS_Solid:
    """A round bar with a round bore: a sleeve, a washer, a disc."""
    return cut(cylinder(outer, z0, z1, x, y), [cylinder(inner, z0 - 1.0, z1 + 1.0, x, y)], "tube")


def prism(polygon: Array, z0: float, z1: float) -> TopoDS_Solid:
    """A straight prism over a polygon (n, 2), counter-clockwise."""
    wire = BRepBuilderAPI_MakePolygon()
    for x, y in polygon.tolist():
        wire.Add(kernel.point(np.array([x, y, z0])))
    wire.Close()
    face = BRepBuilderAPI_MakeFace(wire.Wire()).Face()
    return _one(BRepPrimAPI_MakePrism(face, gp_Vec(0.0, 0.0, z1 - z0)).Shape(), "prism")


def hexagon(flats: float, z0: float, z1: float, x: float = 0.0, y: float = 0.0) -> TopoDS_Solid:
    """A hexagonal bar of a width across flats."""
    angle = np.pi / 3.0 * np.arange(6)
    ring = flats / np.sqrt(3.0) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return prism(ring + np.array([x, y]), z0, z1)


def rounded_bar(
    origin: Array, axis: Array, along: Array, width: float, slot: float, height: float
) -> TopoDS_Shape:
    """A bar of stadium section: two half cylinders, `slot` apart, and the box between them."""
    across = cross(axis, along)
    half, radius = slot / 2.0, width / 2.0
    corners = [
        origin + s * half * along + t * radius * across
        for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    wire = BRepBuilderAPI_MakeWire()
    for k, sign in ((0, 1.0), (2, -1.0)):
        a, b, c = corners[k], corners[k + 1], corners[(k + 2) % 4]
        tip = origin + sign * (half + radius) * along
        wire.Add(BRepBuilderAPI_MakeEdge(kernel.point(a), kernel.point(b)).Edge())
        arc = GC_MakeArcOfCircle(kernel.point(b), kernel.point(tip), kernel.point(c)).Value()
        wire.Add(BRepBuilderAPI_MakeEdge(arc).Edge())
    face = BRepBuilderAPI_MakeFace(wire.Wire()).Face()
    x, y, z = (height * axis).tolist()
    return BRepPrimAPI_MakePrism(face, gp_Vec(x, y, z)).Shape()


def rectangle(width: float, height: float) -> Array:
    """Corners (4, 2) of a rectangle about the origin."""
    return np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [width / 2.0, height / 2.0]


def cut(body: TopoDS_Shape, tools: Sequence[TopoDS_Shape], name: str) -> TopoDS_Solid:
    """A body less tools; one solid or a PartError."""
    operation = BRepAlgoAPI_Cut()
    return _boolean(operation, [body], tools, name)


def fuse(bodies: Sequence[TopoDS_Shape], name: str) -> TopoDS_Solid:
    """Bodies in one, coplanar faces merged; one solid or a PartError."""
    operation = BRepAlgoAPI_Fuse()
    return _boolean(operation, bodies[:1], bodies[1:], name)


def shape_list(shapes: Sequence[TopoDS_Shape]) -> TopTools_ListOfShape:
    """The kernel's list of shapes."""
    out = TopTools_ListOfShape()
    for shape in shapes:
        out.Append(shape)
    return out


def _boolean(
    operation: BRepAlgoAPI_Cut | BRepAlgoAPI_Fuse,
    bodies: Sequence[TopoDS_Shape],
    tools: Sequence[TopoDS_Shape],
    name: str,
) -> TopoDS_Solid:
    operation.SetArguments(shape_list(bodies))
    operation.SetTools(shape_list(tools))
    operation.Build()
    if not operation.IsDone():
        raise PartError(name, "the kernel could not cut or join it")
    merged = ShapeUpgrade_UnifySameDomain(operation.Shape(), True, True, False)
    merged.Build()
    return _one(merged.Shape(), name)


def _one(shape: TopoDS_Shape, name: str) -> TopoDS_Solid:
    solids = kernel.solids(shape)
    if len(solids) != 1:
        raise PartError(name, f"expected one solid, found {len(solids)}", "check its dimensions")
    return solids[0]
