"""Parameter curves of a solid's edges on its faces, which a STEP file leaves to its reader.

The kernel's reader searches for every one by itself and ends with cubics of 22 spans: on plates
full of slots more than half of its time, and slow to check and to integrate over. Here the edges
of a face are laid on its surface all at once, each by poles over its own knots. A solid of which
this doesn't hold to the kernel's smallest tolerance is left to the kernel. Whether the curves fit
is for BRepCheck to say, as ever.

Glossary
--------
laid
    An edge with a parameter curve (u, v)(t) on a face, so that S(u(t), v(t)) is its curve C(t).
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.Geom import (
    Geom_BSplineCurve,
    Geom_BSplineSurface,
    Geom_CylindricalSurface,
    Geom_Line,
    Geom_Plane,
)
from OCP.Geom2d import Geom2d_BSplineCurve
from OCP.ShapeFix import ShapeFix_Edge
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape
from scipy.interpolate import BSpline

from fabgeo.arrays import Array
from fabgeo.cad import kernel
from fabgeo.cad.rims import Skin
from fabgeo.cad.topology import BUILDER, TOL

OFF_PLANE = 1e-3
"""An edge this close to the plane that it bounds (mm) has its distance as its tolerance."""


def lay(shape: TopoDS_Shape) -> bool:
    """Give the edges of a solid their parameter curves, and tolerances where they bound planes.

    Returns
    -------
    bool
        False, and nothing is changed, if a face is no plane, cylinder or ruled cubic spline, an
        edge no line or spline, a face closed in itself, or an edge off its face.
    """
    edges = _Edges()
    try:
        with np.errstate(divide="ignore", invalid="ignore"):  # of what is no number nothing is laid
            faces = kernel.faces(shape.Located(_UNPLACED))
            made = [one for face in faces for one in _laid(face, edges)]
    except (_NotLaid, np.linalg.LinAlgError):
        return False
    fix = ShapeFix_Edge()
    for one in made:
        if one.curve is not None:
            BUILDER.UpdateEdge(one.edge, one.curve, one.face, TOL)
            BUILDER.Range(one.edge, one.face, *one.ends)
        elif one.off > TOL:
            BUILDER.UpdateEdge(one.edge, 1.01 * one.off)
            fix.FixVertexTolerance(one.edge)
    return True


_UNPLACED = TopLoc_Location()


class _NotLaid(Exception):
    """What the kernel had better do."""


@dataclass(frozen=True)
class _Laid:
    """An edge on a face: its parameter curve over `ends`, or (None) how far it is off a plane."""

    edge: TopoDS_Edge
    face: TopoDS_Face
    curve: Geom2d_BSplineCurve | None
    ends: tuple[float, float] = (0.0, 1.0)
    off: float = 0.0


@dataclass(frozen=True)
class _Basis:
    """B-splines over [0, 1], through values at sites.

    Attributes
    ----------
    to_poles : (k, k) array
        From values at the sites to poles.
    at_both : (k + k - 1, k) array
        From poles to values at the sites, and between these, where interpolants are judged.
    """

    to_poles: Array
    at_both: Array

    @staticmethod
    @lru_cache(maxsize=256)
    def of(degree: int, knots: bytes) -> _Basis:
        """Greville's sites; Chebyshev's of one polynomial, whose degree may be high."""
        u = np.frombuffer(knots)
        count = len(u) - degree - 1
        if count == degree + 1:
            sites = 0.5 - 0.5 * np.cos(np.pi * np.arange(count) / degree)
        else:
            sites = np.array([u[k + 1 : k + degree + 1].mean() for k in range(count)])
        both = np.concatenate([sites, 0.5 * (sites[1:] + sites[:-1])]).clip(0.0, 1.0)
        matrix = BSpline.design_matrix(both, u, degree).toarray()
        return _Basis(np.linalg.inv(matrix[:count]), matrix)


@dataclass(frozen=True)
class _Edge:
    """An edge's curve in numbers: knots over [first, last], samples at its sites and between."""

    degree: int
    knots: Array
    basis: _Basis
    samples: Array

    @property
    def ends(self) -> tuple[float, float]:
        """First and last parameter."""
        return float(self.knots[0]), float(self.knots[-1])

    def with_poles(self, poles: Array) -> Geom2d_BSplineCurve:
        """A curve in the plane over the same knots."""
        return Geom2d_BSplineCurve(
            kernel.points_2d(poles), *kernel.knot_arrays(self.knots), self.degree
        )

    @staticmethod
    def of(edge: TopoDS_Edge) -> _Edge:
        curve = BRep_Tool.Curve_s(edge, 0.0, 0.0)
        first, last = BRep_Tool.Range_s(edge)
        if isinstance(curve, Geom_Line):
            degree, knots = 1, np.array([first, first, last, last])
            poles = np.array([curve.Value(t).Coord() for t in (first, last)])
        elif isinstance(curve, Geom_BSplineCurve) and not curve.IsRational():
            degree, knots = curve.Degree(), _full_knots(curve.Knots(), curve.Multiplicities())
            poles = np.array([curve.Pole(k).Coord() for k in range(1, curve.NbPoles() + 1)])
        else:
            raise _NotLaid
        whole = len(knots) == len(poles) + degree + 1 and last > first
        if not (whole and knots[degree] == knots[0] == first and knots[~degree] == last):
            raise _NotLaid  # periodic, or a piece of a curve
        if not np.isfinite(poles).all():
            raise _NotLaid
        basis = _Basis.of(degree, ((knots - first) / (last - first)).tobytes())
        return _Edge(degree, knots, basis, basis.at_both @ poles)


class _Edges:
    """The edges of a solid in numbers, each told once."""

    def __init__(self) -> None:
        self.keys = TopTools_IndexedMapOfShape()
        self.known: dict[int, _Edge] = {}

    def around(self, face: TopoDS_Face) -> tuple[list[TopoDS_Edge], list[_Edge]]:
        """The edges of a face."""
        edges = [TopoDS.Edge_s(e) for e in kernel.explore(face, TopAbs_ShapeEnum.TopAbs_EDGE)]
        keys = [self.keys.Add(edge) for edge in edges]
        if len(set(keys)) < len(keys):  # a seam has a curve on each side
            raise _NotLaid
        for key, edge in zip(keys, edges, strict=True):
            if key not in self.known:
                self.known[key] = _Edge.of(edge)
        return edges, [self.known[key] for key in keys]


def _laid(face: TopoDS_Face, solid: _Edges) -> list[_Laid]:
    """The edges of a face laid on it."""
    edges, own = solid.around(face)
    surface: Any = BRep_Tool.Surface_s(face)
    samples = np.concatenate([edge.samples for edge in own])
    bounds = np.cumsum([len(edge.samples) for edge in own])[:-1]
    if isinstance(surface, Geom_Plane):
        return _on_plane(surface, face, edges, np.split(samples, bounds))
    laid_on = _Ruled.of(surface) if isinstance(surface, Geom_BSplineSurface) else None
    if isinstance(surface, Geom_CylindricalSurface):
        laid_on = _Cylinder.of(surface)
    if laid_on is None:
        raise _NotLaid
    uv = np.split(laid_on.parameters(samples), bounds)
    poles = [e.basis.to_poles @ at[: len(e.basis.to_poles)] for e, at in zip(own, uv, strict=True)]
    curves = [e.basis.at_both @ pole for e, pole in zip(own, poles, strict=True)]
    _refuse(laid_on.at(np.concatenate(curves)) - samples, TOL)
    return [
        _Laid(edge, face, numbers.with_poles(pole), numbers.ends)
        for edge, numbers, pole in zip(edges, own, poles, strict=True)
    ]


def _on_plane(
    plane: Geom_Plane, face: TopoDS_Face, edges: list[TopoDS_Edge], samples: list[Array]
) -> list[_Laid]:
    """The kernel finds curves on planes by itself, but not how far edges are off."""
    frame = plane.Position()
    origin, normal = np.array(frame.Location().Coord()), np.array(frame.Direction().Coord())
    off = [float(np.abs((points - origin) @ normal).max()) for points in samples]
    _refuse(np.array(off)[:, None], OFF_PLANE)
    return [_Laid(edge, face, None, off=far) for edge, far in zip(edges, off, strict=True)]


def _refuse(away: Array, limit: float) -> None:
    if not np.linalg.norm(away, axis=1).max() <= limit:
        raise _NotLaid


@dataclass(frozen=True)
class _Cylinder:
    """A cylinder: origin, frame (rows x, y, axis) and radius; u is the angle, v the height."""

    origin: Array
    frame: Array
    radius: float

    @staticmethod
    def of(surface: Geom_CylindricalSurface) -> _Cylinder:
        own = surface.Position()
        frame = [d.Coord() for d in (own.XDirection(), own.YDirection(), own.Direction())]
        return _Cylinder(np.array(own.Location().Coord()), np.array(frame), surface.Radius())

    def parameters(self, points: Array) -> Array:
        """Angles go on from their middle's, on both sides by less than half a turn."""
        x, y, height = ((points - self.origin) @ self.frame.T).T
        angle = np.arctan2(y, x)
        middle = np.arctan2(np.sin(angle).sum(), np.cos(angle).sum()) % (2.0 * np.pi)
        angle = middle + (angle - middle + np.pi) % (2.0 * np.pi) - np.pi
        if np.ptp(angle) > 1.5 * np.pi:
            raise _NotLaid  # all around
        return np.stack([angle, height], axis=1)

    def at(self, uv: Array) -> Array:
        around = self.radius * np.stack([np.cos(uv[:, 0]), np.sin(uv[:, 0])], axis=1)
        return self.origin + around @ self.frame[:2] + uv[:, 1:] * self.frame[2]


@dataclass(frozen=True)
class _Ruled:
    """A spline surface of degree 3 x 1 with one span across."""

    skin: Skin

    @staticmethod
    def of(surface: Geom_BSplineSurface) -> _Ruled | None:
        degrees, across = (surface.UDegree(), surface.VDegree()), surface.NbVPoles()
        unit = (surface.VKnot(1), surface.VKnot(2)) == (0.0, 1.0)
        closed = surface.IsUPeriodic() or surface.IsURational() or surface.IsVRational()
        if degrees != (3, 1) or across != 2 or closed or not unit:
            return None
        knots = _full_knots(surface.UKnots(), surface.UMultiplicities())
        u = range(1, surface.NbUPoles() + 1)
        poles = np.array([[surface.Pole(k, side).Coord() for k in u] for side in (1, 2)])
        return _Ruled(Skin("", knots, poles)) if np.isfinite(poles).all() else None

    def parameters(self, points: Array) -> Array:
        return self.skin.closest(points)

    def at(self, uv: Array) -> Array:
        return self.skin.at(uv)[0]


def _full_knots(values: Any, counts: Any) -> Array:
    """Knots as often as they count."""
    each = range(1, values.Length() + 1)
    return np.repeat([values.Value(k) for k in each], [counts.Value(k) for k in each])
