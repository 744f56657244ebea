"""What a solid measures, by the kernel: validity, closedness, volume, tolerance, surfaces."""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp, BRepGProp_Domain, BRepGProp_Face, BRepGProp_Vinert
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.gp import gp_Pnt
from OCP.GProp import GProp_GProps
from OCP.ShapeAnalysis import ShapeAnalysis_ShapeTolerance
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Face, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from fabgeo.arrays import Array
from fabgeo.cad import kernel
from fabgeo.cad.report import SolidReport
from fabgeo.cad.topology import BUILDER

VOLUME_EPS = 1e-10
"""Relative error asked of the adaptive volume integral; fixed Gauss points miss by up to 1e-3."""

_UNPLACED = TopLoc_Location()
"""What doesn't depend on a shape's place is measured without it: that takes a quarter less time."""

_EXACT = (GeomAbs_SurfaceType.GeomAbs_Plane, GeomAbs_SurfaceType.GeomAbs_Cylinder)


def check_solid(shape: TopoDS_Shape, eps: float = VOLUME_EPS) -> SolidReport:
    """Measure a shape; see `SolidReport`."""
    total, centre = volume(shape, eps)
    return SolidReport(
        solids=len(kernel.solids(shape)),
        valid=is_valid(shape),
        closed=is_closed(shape),
        volume=total,
        centre=centre,
        tolerance=max_tolerance(shape),
        surfaces=surface_kinds(shape),
    )


def is_valid(shape: TopoDS_Shape) -> bool:
    """Whether BRepCheck finds nothing wrong."""
    return bool(BRepCheck_Analyzer(shape.Located(_UNPLACED)).IsValid())


def is_closed(shape: TopoDS_Shape) -> bool:
    """Whether every edge is used once in each sense (seams too)."""
    known = TopTools_IndexedMapOfShape()
    forward: Counter[int] = Counter()
    backward: Counter[int] = Counter()
    for edge in kernel.explore(shape, TopAbs_ShapeEnum.TopAbs_EDGE):
        senses = forward if edge.Orientation() == TopAbs_Orientation.TopAbs_FORWARD else backward
        senses[known.Add(edge)] += 1
    for key in range(1, known.Extent() + 1):
        if BRep_Tool.Degenerated_s(TopoDS.Edge_s(known.FindKey(key))):
            del forward[key], backward[key]
    return bool(forward) and forward == backward and set(forward.values()) == {1}


def volume(shape: TopoDS_Shape, eps: float = VOLUME_EPS) -> tuple[float, Array]:
    """Volume in mm3 and centre of mass: the flux of position through the faces.

    Adaptive integration to a relative error `eps`, loop by loop: the kernel integrates from the
    first parameter line of a face to each edge, for a hole far along a skin across all knots before
    it. Planes and cylinders take as many Gauss points as their edges' degrees ask for: exact.
    """
    own = shape.Located(_UNPLACED)
    origin = _near(own)
    total = GProp_GProps(origin)
    for face in kernel.faces(own):
        adaptive = () if BRepAdaptor_Surface(face, False).GetType() in _EXACT else (eps,)
        for part in _by_loop(face):
            surface, domain = BRepGProp_Face(part), BRepGProp_Domain(part)
            total.Add(BRepGProp_Vinert(surface, domain, origin, origin, *adaptive))
    centre = total.CentreOfMass().Transformed(shape.Location().Transformation())
    return float(total.Mass()), np.array([centre.X(), centre.Y(), centre.Z()])


def _near(shape: TopoDS_Shape) -> gp_Pnt:
    """A point near a shape: fluxes about one far away are large, and nearly cancel."""
    box = Bnd_Box()
    BRepBndLib.AddClose_s(shape, box)
    if box.IsVoid():
        return gp_Pnt()
    low, high = box.CornerMin(), box.CornerMax()
    return gp_Pnt((low.XYZ() + high.XYZ()) * 0.5)


def _by_loop(face: TopoDS_Face) -> Iterator[TopoDS_Face]:
    """A face for each loop of a face: integrals over them add up to its own."""
    loops = list(kernel.explore(face, TopAbs_ShapeEnum.TopAbs_WIRE))
    if len(loops) < 2:
        yield face
        return
    for loop in loops:
        part = TopoDS.Face_s(face.EmptyCopied())
        BUILDER.Add(part, loop)
        yield part


def surface_area(shape: TopoDS_Shape) -> float:
    """Area of all faces in mm2."""
    props = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, props)
    return float(props.Mass())


def max_tolerance(shape: TopoDS_Shape) -> float:
    """The largest tolerance of faces, edges and vertices."""
    return float(ShapeAnalysis_ShapeTolerance().Tolerance(shape, 1))


def surface_kinds(shape: TopoDS_Shape) -> dict[str, int]:
    """Number of faces of each kind of surface."""
    kinds = (surface_kind(BRepAdaptor_Surface(face)) for face in kernel.faces(shape))
    return dict(Counter(kinds))


def surface_kind(surface: BRepAdaptor_Surface) -> str:
    """The kind of a face's surface: plane, cylinder, cone, bspline, ..."""
    return surface.GetType().name.removeprefix("GeomAbs_").removesuffix("Surface").lower()


def bounding_box(shape: TopoDS_Shape) -> tuple[Array, Array]:
    """Lowest and highest corner, tight to the geometry."""
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    low, high = box.CornerMin(), box.CornerMax()
    return np.array([low.X(), low.Y(), low.Z()]), np.array([high.X(), high.Y(), high.Z()])
