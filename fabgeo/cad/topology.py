"""The few steps by which faces are written down vertex by vertex, edge by edge."""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from OCP.BRep import BRep_Builder
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopoDS import (
    TopoDS_Edge,
    TopoDS_Face,
    TopoDS_Shell,
    TopoDS_Solid,
    TopoDS_Vertex,
    TopoDS_Wire,
)

from fabgeo.arrays import Array
from fabgeo.cad import kernel

TOL = 1e-7
"""The kernel's own smallest tolerance, mm."""
FORWARD = TopAbs_Orientation.TopAbs_FORWARD
REVERSED = TopAbs_Orientation.TopAbs_REVERSED
BUILDER = BRep_Builder()


def vertex(corner: Array, tolerance: float = TOL) -> TopoDS_Vertex:
    """A vertex at a point (3,)."""
    made = TopoDS_Vertex()
    BUILDER.MakeVertex(made, kernel.point(corner), tolerance)
    return made


def close_face(face: TopoDS_Face, uses: list[tuple[TopoDS_Edge, bool]]) -> None:
    """Bound a face by a loop of edges in order; True uses an edge in its own sense."""
    wire = TopoDS_Wire()
    BUILDER.MakeWire(wire)
    for edge, forward in uses:
        BUILDER.Add(wire, edge.Oriented(FORWARD if forward else REVERSED))
    wire.Closed(True)
    BUILDER.Add(face, wire)


def close_solid(faces: list[TopoDS_Face]) -> TopoDS_Solid:
    """The solid within a closed set of faces that share their edges."""
    shell = TopoDS_Shell()
    BUILDER.MakeShell(shell)
    for face in faces:
        BUILDER.Add(shell, face)
    shell.Closed(True)
    solid = TopoDS_Solid()
    BUILDER.MakeSolid(solid)
    BUILDER.Add(solid, shell)
    return solid
