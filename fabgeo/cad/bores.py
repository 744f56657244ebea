"""The walls of holes through a plate, put into its topology directly.

Cutting with cylinders costs 80 ms a hole and leaves tolerances of several micrometres; here every
rim is found to 1e-7 mm and shared exactly by skin and wall.

Glossary
--------
low, high
    The skins that the hole's axis enters and leaves by.
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from OCP.Geom import Geom_BSplineCurve, Geom_CylindricalSurface, Geom_Line, Geom_Plane
from OCP.Geom2d import Geom2d_BSplineCurve, Geom2d_Line
from OCP.gp import gp_Dir2d, gp_Pnt2d
from OCP.TopoDS import TopoDS_Edge, TopoDS_Face, TopoDS_Vertex

from fabgeo.arrays import Array, cross
from fabgeo.cad import kernel
from fabgeo.cad.rims import Piece, Rim, Skin, walls_of
from fabgeo.cad.topology import BUILDER, FORWARD, REVERSED, TOL, close_face, vertex
from fabgeo.structures.parts import Hole

_HALF_TURN = (0.5 * np.pi, 1.5 * np.pi)
"""Angles of a half cylinder: its seam lies in the void, so that no rim begins on it."""


@dataclass(frozen=True)
class SkinFace:
    """A skin as numbers and as the face that is being made of it."""

    skin: Skin
    face: TopoDS_Face


def bore(holes: Sequence[Hole], skins: tuple[SkinFace, SkinFace]) -> list[TopoDS_Face]:
    """Add holes to both skins.

    Returns
    -------
    list of TopoDS_Face
        The faces of their walls, oriented out of the material.

    Raises
    ------
    PartError
        If a hole breaks out of a skin or runs far from square to it.
    """
    walls = walls_of(holes)
    flat = [piece for wall in walls for piece in wall]
    rims = [side.skin.rims(flat) for side in skins]
    out: list[TopoDS_Face] = []
    at = 0
    for wall in walls:
        rings = [_Ring(r[at : at + len(wall)], s) for r, s in zip(rims, skins, strict=True)]
        at += len(wall)
        low, high = sorted(rings, key=lambda ring: ring.rims[0].ends[0])
        posts = [_post(piece, low, high, k) for k, piece in enumerate(wall)]
        low.cut(forward=True)
        high.cut(forward=False)
        out += [_wall(piece, low, high, posts, k) for k, piece in enumerate(wall)]
    return out


class _Ring:
    """All rims of one hole on one skin: a closed loop of edges."""

    def __init__(self, rims: list[Rim], side: SkinFace) -> None:
        self.rims, self.side = rims, side
        count = len(rims)
        worst = max(rim.deviation for rim in rims)
        # Measured at some places of every rim: where a knot of the skin runs through it, it swings
        # between these.
        self.tolerance = max(TOL, 2.0 * worst)
        self.vertices: list[TopoDS_Vertex] = [vertex(rim.points[0], self.tolerance) for rim in rims]
        self.edges = [
            self._edge(rim, self.vertices[k], self.vertices[(k + 1) % count])
            for k, rim in enumerate(rims)
        ]

    def _edge(self, rim: Rim, start: TopoDS_Vertex, end: TopoDS_Vertex) -> TopoDS_Edge:
        degree = len(rim.points) - 1
        curve = Geom_BSplineCurve(kernel.points(rim.points), *kernel.one_span(degree), degree)
        edge = TopoDS_Edge()
        BUILDER.MakeEdge(edge, curve, self.tolerance)
        BUILDER.Range(edge, 0.0, 1.0)
        BUILDER.Add(edge, start.Oriented(FORWARD))
        BUILDER.Add(edge, end.Oriented(REVERSED))
        self._lay(edge, rim.skin, self.side.face)
        return edge

    def _lay(self, edge: TopoDS_Edge, poles: Array, face: TopoDS_Face) -> None:
        degree = len(poles) - 1
        flat = Geom2d_BSplineCurve(kernel.points_2d(poles), *kernel.one_span(degree), degree)
        BUILDER.UpdateEdge(edge, flat, face, self.tolerance)
        BUILDER.Range(edge, face, 0.0, 1.0)

    def cut(self, forward: bool) -> None:
        """Bound the skin's face by the loop."""
        uses = [(edge, forward) for edge in self.edges]
        close_face(self.side.face, uses if forward else uses[::-1])

    def on_cylinder(self, k: int, face: TopoDS_Face) -> None:
        """Lay rim k on its half cylinder: the angle grows evenly, the height is s."""
        rim = self.rims[k]
        angle = np.linspace(*_HALF_TURN, len(rim.height))  # poles of a straight line
        self._lay(self.edges[k], np.stack([angle, rim.height], axis=1), face)


def _post(piece: Piece, low: _Ring, high: _Ring, k: int) -> TopoDS_Edge:
    """The straight edge along the axis at a piece's start, from low to high."""
    edge = TopoDS_Edge()
    line = Geom_Line(kernel.point(piece.start), kernel.direction(piece.frame[2]))
    BUILDER.MakeEdge(edge, line, TOL)
    BUILDER.Range(edge, low.rims[k].ends[0], high.rims[k].ends[0])
    BUILDER.Add(edge, low.vertices[k].Oriented(FORWARD))
    BUILDER.Add(edge, high.vertices[k].Oriented(REVERSED))
    return edge


def _wall(piece: Piece, low: _Ring, high: _Ring, posts: list[TopoDS_Edge], k: int) -> TopoDS_Face:
    x, y, z = piece.frame
    start, end = posts[k], posts[(k + 1) % len(posts)]
    face = TopoDS_Face()
    if piece.radius > 0.0:
        frame = kernel.axes(piece.centre, z, -y)
        BUILDER.MakeFace(face, Geom_CylindricalSurface(frame, piece.radius), TOL)
        low.on_cylinder(k, face)
        high.on_cylinder(k, face)
        for post, angle in zip((start, end), _HALF_TURN, strict=True):
            line = Geom2d_Line(gp_Pnt2d(float(angle), 0.0), gp_Dir2d(0.0, 1.0))
            BUILDER.UpdateEdge(post, line, face, TOL)
    else:
        # The wall's outside is the material: x runs along it, z up, so x cross z points there.
        BUILDER.MakeFace(face, Geom_Plane(kernel.axes(piece.centre, cross(x, z), x)), TOL)
    close_face(face, [(low.edges[k], True), (end, True), (high.edges[k], False), (start, False)])
    return face.Reversed()


__all__ = ["SkinFace", "bore"]
