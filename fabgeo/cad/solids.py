"""Ruled prisms as exact solids: the topology is written down directly, nothing is searched for.

A prism of N edge curves becomes N ruled faces of degree 3 x 1 and two ends. Vertices, edges and
parameter curves are exact by construction, so tolerances stay at 1e-7 mm.

Glossary
--------
edge curve
    One of the N cubic B-splines c_j(u) that run the prism's length.
section
    The polygon c_0(u) ... c_{N-1}(u) of one u; the two ends are the first and the last section.
side
    The straight edge from c_j to c_{j+1} of an end section.
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from OCP.Geom import Geom_BSplineCurve, Geom_BSplineSurface, Geom_Line, Geom_Plane, Geom_Surface
from OCP.Geom2d import Geom2d_BSplineCurve, Geom2d_Line
from OCP.gp import gp_Dir2d, gp_Pnt2d
from OCP.TopoDS import TopoDS_Edge, TopoDS_Face, TopoDS_Solid

from fabgeo.arrays import Array
from fabgeo.cad import kernel
from fabgeo.cad.bores import SkinFace, bore
from fabgeo.cad.rims import Skin
from fabgeo.cad.sound import check_prism, vector_area
from fabgeo.cad.topology import BUILDER, FORWARD, REVERSED, TOL, close_face, close_solid, vertex
from fabgeo.errors import PartError
from fabgeo.structures.holes import check_apart
from fabgeo.structures.parts import Hole, Prism

PLANAR_TOLERANCE = 5e-4
"""An end whose vertices lie this close to a plane (mm) is a plane, beyond it a bilinear face."""


def prism_solid(
    prism: Prism, planar_tolerance: float = PLANAR_TOLERANCE, holes: Sequence[Hole] = ()
) -> TopoDS_Solid:
    """The solid of a prism.

    Parameters
    ----------
    prism : Prism
        Edge curves in cyclic order, either sense.
    planar_tolerance : float
        An end off its plane by at most this (mm) is closed by a plane, and the tolerance of its
        edges tells the deviation. Beyond it an end of four sides is closed by a bilinear face.

    holes : sequence of Hole
        Bored through the faces 0 and 2 of a prism of four sides, the skins of a plate.

    Returns
    -------
    TopoDS_Solid
        Closed, oriented outwards, N ruled faces first, then the first and the last end, then the
        walls of holes (half cylinders; of slots also planes).

    Raises
    ------
    PartError
        If the prism is folded, crossed or a sliver, or an end of more than four sides is not
        plane: such a prism is never made a solid. If a hole breaks out of the edge, runs more than
        45 degrees from square or touches another.
    """
    outwards = check_prism(prism)
    poles = prism.poles if outwards else prism.poles[::-1]
    if holes and len(poles) != 4:
        raise PartError(prism.mark, f"has {len(poles)} sides and no skins to bore holes through")
    check_apart(prism.mark, holes)
    return _Prism(prism.mark, prism.knots, poles, planar_tolerance).solid(holes)


class _Prism:
    """The topology of one prism while it is put together."""

    def __init__(self, mark: str, knots: Array, poles: Array, planar_tolerance: float) -> None:
        self.mark = mark
        self.poles = poles
        self.count = len(poles)
        self.u = (float(knots[0]), float(knots[-1]))
        self.all_knots = knots
        self.knots = kernel.knot_arrays(knots)
        self.rows: list[list[list[float]]] = poles.tolist()
        self.ends = [_End(mark, poles[:, k], planar_tolerance) for k in (0, -1)]
        self.curves = [self._curve(j) for j in range(self.count)]

    def solid(self, holes: Sequence[Hole]) -> TopoDS_Solid:
        faces = [self._face(j) for j in range(self.count)]
        walls: list[TopoDS_Face] = []
        if holes:
            lower, upper = (SkinFace(self._skin(j), faces[j]) for j in (0, 2))
            walls = bore(holes, (lower, upper))
        ends = [self.ends[0].face(forward=True), self.ends[1].face(forward=False)]
        return close_solid([*faces, *ends, *walls])

    def _skin(self, j: int) -> Skin:
        return Skin(self.mark, self.all_knots, self.poles[[j, (j + 1) % self.count]])

    def _curve(self, j: int) -> TopoDS_Edge:
        curve = Geom_BSplineCurve(kernel.points(self.poles[j]), *self.knots, 3)
        edge = TopoDS_Edge()
        BUILDER.MakeEdge(edge, curve, TOL)
        BUILDER.Range(edge, *self.u)
        BUILDER.Add(edge, self.ends[0].vertices[j].Oriented(FORWARD))
        BUILDER.Add(edge, self.ends[1].vertices[j].Oriented(REVERSED))
        return edge

    def _face(self, j: int) -> TopoDS_Face:
        """Ruled face between curves j and j + 1; natural normal outwards."""
        k = (j + 1) % self.count
        grid = kernel.point_grid([self.rows[j], self.rows[k]])
        surface = Geom_BSplineSurface(grid, self.knots[0], _UNIT[0], self.knots[1], _UNIT[1], 3, 1)
        face = TopoDS_Face()
        BUILDER.MakeFace(face, surface, TOL)
        for edge, v in ((self.curves[j], 0.0), (self.curves[k], 1.0)):
            line = Geom2d_Line(gp_Pnt2d(0.0, v), gp_Dir2d(1.0, 0.0))
            BUILDER.UpdateEdge(edge, line, face, TOL)
            BUILDER.Range(edge, face, *self.u)
        for end, u in zip(self.ends, self.u, strict=True):
            end.on_surface(j, face, (u, 0.0), (u, 1.0))
        close_face(
            face,
            [
                (self.curves[j], True),
                (self.ends[1].sides[j], True),
                (self.curves[k], False),
                (self.ends[0].sides[j], False),
            ],
        )
        return face


class _End:
    """First or last section: vertices, straight sides and the face that closes the prism."""

    def __init__(self, mark: str, corners: Array, planar_tolerance: float) -> None:
        self.corners = corners
        area = vector_area(corners)
        self.normal = area / np.linalg.norm(area)
        self.centre = corners.mean(axis=0)
        off = float(np.abs((corners - self.centre) @ self.normal).max())
        self.planar = off <= planar_tolerance
        if not self.planar and len(corners) != 4:
            raise PartError(
                mark,
                f"an end of {len(corners)} sides is {off:.3g} mm off its plane, expected at most "
                f"{planar_tolerance:g} mm",
                "cut the part by planes",
            )
        tolerance = max(TOL, 1.01 * off) if self.planar else TOL
        self.tolerance = tolerance
        self.vertices = [vertex(corner, tolerance) for corner in corners]
        following = np.roll(corners, -1, axis=0)
        self.lengths = np.linalg.norm(following - corners, axis=1).tolist()
        self.sides = [self._side(j, following[j]) for j in range(len(corners))]

    def _side(self, j: int, end: Array) -> TopoDS_Edge:
        start = self.corners[j]
        line = Geom_Line(kernel.point(start), kernel.direction(end - start))
        edge = TopoDS_Edge()
        BUILDER.MakeEdge(edge, line, self.tolerance)
        BUILDER.Range(edge, 0.0, self.lengths[j])
        BUILDER.Add(edge, self.vertices[j].Oriented(FORWARD))
        BUILDER.Add(edge, self.vertices[(j + 1) % len(self.corners)].Oriented(REVERSED))
        return edge

    def on_surface(
        self, j: int, face: TopoDS_Face, start: tuple[float, float], end: tuple[float, float]
    ) -> None:
        """Lay side j on a surface as the parameter line from start to end."""
        knots = kernel.knot_arrays(np.array([0.0, 0.0, self.lengths[j], self.lengths[j]]))
        curve = Geom2d_BSplineCurve(kernel.points_2d(np.array([start, end])), *knots, 1)
        BUILDER.UpdateEdge(self.sides[j], curve, face, self.tolerance)
        BUILDER.Range(self.sides[j], face, 0.0, self.lengths[j])

    def face(self, forward: bool) -> TopoDS_Face:
        """The end's face; `forward`: the sides' sense is the boundary's."""
        uses = [(side, forward) for side in self.sides]
        if self.planar:
            normal = self.normal if forward else -self.normal
            x = self.corners[1] - self.corners[0]
            surface: Geom_Surface = Geom_Plane(kernel.axes(self.centre, normal, x))
            face = TopoDS_Face()
            BUILDER.MakeFace(face, surface, TOL)
            close_face(face, uses if forward else uses[::-1])
            return face
        return self._bilinear(uses, forward)

    def _bilinear(self, uses: list[tuple[TopoDS_Edge, bool]], forward: bool) -> TopoDS_Face:
        c = self.corners.tolist()
        rows = [[c[0], c[1]], [c[3], c[2]]] if forward else [[c[0], c[3]], [c[1], c[2]]]
        uv = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        if not forward:
            uv = [(v, u) for u, v in uv]
        grid = kernel.point_grid(rows)
        surface = Geom_BSplineSurface(grid, _UNIT[0], _UNIT[0], _UNIT[1], _UNIT[1], 1, 1)
        face = TopoDS_Face()
        BUILDER.MakeFace(face, surface, TOL)
        for j in range(4):
            self.on_surface(j, face, uv[j], uv[(j + 1) % 4])
        close_face(face, uses if forward else uses[::-1])
        return face


_UNIT = kernel.knot_arrays(np.array([0.0, 0.0, 1.0, 1.0]))
