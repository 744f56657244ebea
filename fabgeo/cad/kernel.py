"""The one place that imports what varies between versions of the kernel (OCCT 7.9 and 8).

Glossary
--------
OCP
    The Python binding of OCCT. Version 8 drops the named array classes of ``TColgp`` and
    ``TColStd`` and the ``_s`` suffix of static methods; only this file would notice.
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from OCP.BinTools import BinTools
from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt, gp_Pnt2d, gp_Trsf
from OCP.Message import Message, Message_Gravity
from OCP.TColgp import TColgp_Array1OfPnt, TColgp_Array1OfPnt2d, TColgp_Array2OfPnt
from OCP.TCollection import TCollection_ExtendedString, TCollection_HAsciiString
from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Shape, TopoDS_Solid, TopoDS_Vertex

from fabgeo.arrays import Array
from fabgeo.errors import InputError

type Shape = TopoDS_Shape


def point(xyz: Array) -> gp_Pnt:
    """A kernel point of (3,) coordinates."""
    return gp_Pnt(float(xyz[0]), float(xyz[1]), float(xyz[2]))


def direction(xyz: Array) -> gp_Dir:
    """A kernel direction of a (3,) vector of any length but zero."""
    return gp_Dir(float(xyz[0]), float(xyz[1]), float(xyz[2]))


def axes(origin: Array, z: Array, x: Array) -> gp_Ax3:
    """A right-handed frame: z exactly, x as near as possible."""
    return gp_Ax3(point(origin), direction(z), direction(x))


def points(xyz: Array) -> TColgp_Array1OfPnt:
    """Kernel array of (k, 3) points."""
    array = TColgp_Array1OfPnt(1, len(xyz))
    for k, (x, y, z) in enumerate(np.asarray(xyz).tolist(), 1):
        array.SetValue(k, gp_Pnt(x, y, z))
    return array


def points_2d(xy: Array) -> TColgp_Array1OfPnt2d:
    """Kernel array of (k, 2) points of a parameter plane."""
    array = TColgp_Array1OfPnt2d(1, len(xy))
    for k, (x, y) in enumerate(np.asarray(xy).tolist(), 1):
        array.SetValue(k, gp_Pnt2d(x, y))
    return array


def point_grid(rows: list[list[list[float]]]) -> TColgp_Array2OfPnt:
    """Kernel array with column k holding the k-th of the given rows of [x, y, z]."""
    grid = TColgp_Array2OfPnt(1, len(rows[0]), 1, len(rows))
    for column, row in enumerate(rows, 1):
        for k, (x, y, z) in enumerate(row, 1):
            grid.SetValue(k, column, gp_Pnt(x, y, z))
    return grid


def knot_arrays(knots: Array) -> tuple[TColStd_Array1OfReal, TColStd_Array1OfInteger]:
    """Distinct knots and their multiplicities."""
    return _knot_arrays(np.ascontiguousarray(knots, dtype=np.float64).tobytes())


@lru_cache(maxsize=16)
def one_span(degree: int) -> tuple[TColStd_Array1OfReal, TColStd_Array1OfInteger]:
    """Knots of one polynomial over [0, 1]: every program reads B-splines, few Bezier curves."""
    return knot_arrays(np.repeat([0.0, 1.0], degree + 1))


@lru_cache(maxsize=256)
def _knot_arrays(data: bytes) -> tuple[TColStd_Array1OfReal, TColStd_Array1OfInteger]:
    """The kernel copies what it is given, so equal knot vectors can share their arrays."""
    counts = Counter(np.frombuffer(data).tolist())  # in order, as knots are
    reals = TColStd_Array1OfReal(1, len(counts))
    integers = TColStd_Array1OfInteger(1, len(counts))
    for k, (value, count) in enumerate(counts.items(), 1):
        reals.SetValue(k, value)
        integers.SetValue(k, count)
    return reals, integers


def explore(shape: TopoDS_Shape, kind: TopAbs_ShapeEnum) -> Iterator[TopoDS_Shape]:
    """Every sub-shape of a kind, as often as it is used."""
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def faces(shape: TopoDS_Shape) -> list[TopoDS_Face]:
    """The faces of a shape, in the shape's order."""
    return [TopoDS.Face_s(s) for s in explore(shape, TopAbs_ShapeEnum.TopAbs_FACE)]


def edges(shape: TopoDS_Shape) -> list[TopoDS_Edge]:
    """The edge uses of a shape: an edge between two faces comes twice."""
    return [TopoDS.Edge_s(s) for s in explore(shape, TopAbs_ShapeEnum.TopAbs_EDGE)]


def vertices(shape: TopoDS_Shape) -> list[TopoDS_Vertex]:
    """The vertex uses of a shape."""
    return [TopoDS.Vertex_s(s) for s in explore(shape, TopAbs_ShapeEnum.TopAbs_VERTEX)]


def solids(shape: TopoDS_Shape) -> list[TopoDS_Solid]:
    """The solids of a shape (itself, if it is one)."""
    return [TopoDS.Solid_s(s) for s in explore(shape, TopAbs_ShapeEnum.TopAbs_SOLID)]


def to_location(matrix: Array) -> TopLoc_Location:
    """A kernel location of a rigid (4, 4) matrix.

    Raises
    ------
    InputError
        If the matrix holds more than a rotation and a translation.
    """
    m = np.asarray(matrix, dtype=np.float64)
    rotation = m[:3, :3]
    error = np.abs(rotation @ rotation.T - np.eye(3)).max()
    if m.shape != (4, 4) or error > 1e-6 or np.linalg.det(rotation) < 0.0:
        raise InputError("placement", "expected a rigid 4 x 4 matrix, right-handed")
    transform = gp_Trsf()
    transform.SetValues(*(float(value) for value in m[:3].ravel()))
    return TopLoc_Location(transform)


def to_matrix(location: TopLoc_Location) -> Array:
    """The (4, 4) matrix of a kernel location."""
    transform = location.Transformation()
    matrix = np.eye(4)
    for row in range(3):
        for column in range(4):
            matrix[row, column] = transform.Value(row + 1, column + 1)
    return matrix


def text(value: str) -> TCollection_ExtendedString:
    """A kernel string, non-ASCII letters right."""
    return TCollection_ExtendedString(value, True)


def ascii_text(value: str) -> TCollection_HAsciiString:
    """A kernel string of bytes (UTF-8)."""
    return TCollection_HAsciiString(value)


def be_quiet() -> None:
    """Let the kernel print failures only (it announces every transfer else)."""
    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Gravity.Message_Fail)


def to_bytes(shape: TopoDS_Shape) -> bytes:
    """Binary BREP of a shape: the way between processes."""
    stream = io.BytesIO()
    BinTools.Write_s(shape, stream)
    return stream.getvalue()


def from_bytes(data: bytes) -> TopoDS_Shape:
    """The shape of `to_bytes`."""
    shape = TopoDS_Shape()
    BinTools.Read_s(shape, io.BytesIO(data))
    return shape
