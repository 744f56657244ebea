"""A written STEP file read again: its product tree, and its solids as plain numbers.

Who checks a package needs no kernel: `read_package_step` gives parts, and a part gives its
measures, faces and edges as numpy arrays.

Glossary
--------
part
    A leaf of the product tree, in its place: one occurrence of one product.
path
    The names from the root down to the part, the part's own name last.
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.Resource import Resource_DataMapOfAsciiStringAsciiString
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_AsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Shape
from OCP.XCAFDoc import (
    XCAFDoc_ColorTool,
    XCAFDoc_ColorType,
    XCAFDoc_DocumentTool,
    XCAFDoc_ShapeTool,
)

from fabgeo.arrays import Array
from fabgeo.cad import kernel, measure
from fabgeo.cad.assembly import Colour
from fabgeo.cad.laid import lay
from fabgeo.cad.measure import check_solid
from fabgeo.cad.report import SolidReport
from fabgeo.cad.samples import (
    FaceSamples,
    ReadEdge,
    face_samples,
    gaussian_curvatures,
    read_edges,
)
from fabgeo.errors import InputError

_REPAIRS = (
    "FixSolidOrientationMode",
    "FixShellOrientationMode",
    "FixOrientationMode",
    "FixSmallAreaWireMode",
    "FixSmallAreaFaceMode",
    "FixIntersectingWiresMode",
    "FixLoopWiresMode",
    "FixSplitFaceMode",
    "FixSelfIntersectionMode",
    "FixSelfIntersectingEdgeMode",
    "FixIntersectingEdgesMode",
    "FixNonAdjacentIntersectingEdgesMode",
    "FixNotchedEdgesMode",
    "FixReorderMode",
    "FixSmallMode",
    "FixConnectedMode",
    "FixLackingMode",
    "FixTailMode",
)
"""What the kernel would mend while it reads: left as written, since a check wants to see it.

It takes two thirds of the time of reading. What a file leaves to its reader is still done:
parameter curves, seams, apexes, tolerances.
"""

_NOT_LAID = (b"CIRCLE(", b"PCURVE(", b"CONICAL_SURFACE(", b"SPHERICAL_SURFACE(")
"""Words of files with edges or faces that `fabgeo.cad.laid` leaves to the kernel: of fixings."""


@dataclass(frozen=True)
class ReadPart:
    """One part of a file.

    Attributes
    ----------
    name : str
        The occurrence's own name (the mark); the product's where it has none.
    product : str
        The product's name; equal parts share a product.
    path : tuple of str
        Names from the root to the part.
    shape : TopoDS_Shape
        In its place, mm.
    colour : tuple, optional
        sRGB.
    layers : tuple of str
    frames : tuple of (4, 4) arrays
        Placement of each name of the path, the part's own last.
    """

    name: str
    product: str
    path: tuple[str, ...]
    shape: TopoDS_Shape
    colour: Colour | None
    layers: tuple[str, ...]
    frames: tuple[Array, ...]

    @property
    def location(self) -> Array:
        """Placement (4, 4) of the product."""
        return self.frames[-1]

    @property
    def definition(self) -> int:
        """Equal for the instances of one product, wherever they are placed."""
        return hash(self.shape.Located(TopLoc_Location()))

    @cached_property
    def report(self) -> SolidReport:
        """Validity, closedness, volume, tolerance, kinds of faces."""
        return check_solid(self.shape)

    def faces(self, count: int = 5) -> list[FaceSamples]:
        """Every face, sampled on a count x count grid of its parameters (points inside only)."""
        return [face_samples(face, count) for face in kernel.faces(self.shape)]

    def largest_faces(self, number: int = 2, count: int = 5) -> list[FaceSamples]:
        """The faces of largest area: the two skins of a plate."""
        faces = sorted(kernel.faces(self.shape), key=measure.surface_area, reverse=True)
        return [face_samples(face, count) for face in faces[:number]]

    def gaussian(self, number: int, count: int = 5) -> float:
        """Largest Gaussian curvature of one face by size, 1/mm2; `number` as edges name faces."""
        found = gaussian_curvatures(kernel.faces(self.shape)[number], count)
        return float(np.abs(found).max(initial=0.0))

    def edges(self) -> list[ReadEdge]:
        """Every edge once."""
        return list(read_edges(self.shape))

    def edge_points(self, count: int = 33) -> Array:
        """Points (k, 3) on every edge: the ends of straight ones, `count` of others."""
        edges = read_edges(self.shape)
        return np.concatenate([e.points(2 if e.kind == "line" else count) for e in edges])

    def bounding_box(self, frame: Array | None = None) -> tuple[Array, Array]:
        """Lowest and highest corner; along the axes of a frame (4, 4), seen from its origin."""
        if frame is None:
            return measure.bounding_box(self.shape)
        back = kernel.to_location(np.linalg.inv(frame))
        return measure.bounding_box(self.shape.Moved(back))


def read_package_step(path: str | os.PathLike[str]) -> list[ReadPart]:
    """All parts of a STEP file with their names, colours, layers and places.

    Raises
    ------
    InputError
        If the file is missing, no STEP file, or holds no shape.
    """
    source = Path(path)
    if not source.is_file():
        raise InputError(str(source), "does not exist")
    kernel.be_quiet()
    text = source.read_bytes()
    if not any(word in text for word in _NOT_LAID):
        parts = _read(source, (*_REPAIRS, "FixSolidMode"))
        if all(lay(part.shape) for part in parts):
            return parts
    return _read(source, _REPAIRS)


def _read(source: Path, left: tuple[str, ...]) -> list[ReadPart]:
    """Read with some of the kernel's repairs left out."""
    document = TDocStd_Document(kernel.text("MDTV-XCAF"))
    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    reader.SetColorMode(True)
    reader.SetLayerMode(True)
    Interface_Static.SetCVal_s("xstep.cascade.unit", "MM")
    if reader.ReadFile(str(source)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise InputError(str(source), "is no STEP file that the kernel can read")
    reader.SetShapeFixParameters(_without(left))  # heard only after the file is read
    if not reader.Transfer(document):
        raise InputError(str(source), "holds no shape", "check that it was written completely")
    return list(_Tree(document).parts())


def _without(repairs: tuple[str, ...]) -> Resource_DataMapOfAsciiStringAsciiString:
    out = Resource_DataMapOfAsciiStringAsciiString()
    for name in repairs:
        out.Bind(TCollection_AsciiString(f"FixShape.{name}"), TCollection_AsciiString("0"))
    return out


class _Tree:
    def __init__(self, document: TDocStd_Document) -> None:
        self.shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
        self.colours = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
        self.layers = XCAFDoc_DocumentTool.LayerTool_s(document.Main())

    def parts(self) -> Iterator[ReadPart]:
        roots = TDF_LabelSequence()
        self.shapes.GetFreeShapes(roots)
        for root in _each(roots):
            yield from self._walk(root, (), (), TopLoc_Location(), None)

    def _walk(
        self,
        label: TDF_Label,
        above: tuple[str, ...],
        frames: tuple[Array, ...],
        place: TopLoc_Location,
        colour: Colour | None,
    ) -> Iterator[ReadPart]:
        product = TDF_Label()
        if not XCAFDoc_ShapeTool.GetReferredShape_s(label, product):
            product = label
        title = _name(product)
        name = _name(label)
        if not name or name.isdigit():  # the kernel calls a nameless occurrence by its number
            name = title
        place = place.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(label))
        frames = (*frames, kernel.to_matrix(place))
        colour = self._colour(label) or colour
        if XCAFDoc_ShapeTool.IsAssembly_s(product):
            children = TDF_LabelSequence()
            XCAFDoc_ShapeTool.GetComponents_s(product, children, False)
            for child in _each(children):
                yield from self._walk(child, (*above, name), frames, place, colour)
            return
        shape = XCAFDoc_ShapeTool.GetShape_s(product).Moved(place)
        own = colour or self._colour(product) or self._solid_colour(product)
        layers = self._layers(label) or self._layers(product) or self._solid_layers(product)
        yield ReadPart(name, title, (*above, name), shape, own, layers, frames)

    def _colour(self, label: TDF_Label) -> Colour | None:
        found = Quantity_Color()
        for kind in (XCAFDoc_ColorType.XCAFDoc_ColorSurf, XCAFDoc_ColorType.XCAFDoc_ColorGen):
            if XCAFDoc_ColorTool.GetColor_s(label, kind, found):
                return _rgb(found)
        return None

    def _solid_colour(self, product: TDF_Label) -> Colour | None:
        """A colour that another writer put on the solid or on its first face."""
        shape = XCAFDoc_ShapeTool.GetShape_s(product)
        found = Quantity_Color()
        for sub in (*kernel.solids(shape)[:1], *kernel.faces(shape)[:1]):
            for kind in (XCAFDoc_ColorType.XCAFDoc_ColorSurf, XCAFDoc_ColorType.XCAFDoc_ColorGen):
                if self.colours.GetColor(sub, kind, found):
                    return _rgb(found)
        return None

    def _layers(self, label: TDF_Label) -> tuple[str, ...]:
        found = TDF_LabelSequence()
        self.layers.GetLayers(label, found)
        return tuple(_name(layer) for layer in _each(found))

    def _solid_layers(self, product: TDF_Label) -> tuple[str, ...]:
        shape = XCAFDoc_ShapeTool.GetShape_s(product)
        found = TDF_Label()
        for solid in kernel.solids(shape)[:1]:
            if self.shapes.FindSubShape(product, solid, found):
                return self._layers(found)
        return ()


def _each(labels: TDF_LabelSequence) -> Iterator[TDF_Label]:
    """By number: the end of an iteration is an exception of the binding's, which takes 0.5 ms."""
    return (labels.Value(k) for k in range(1, labels.Length() + 1))


def _rgb(colour: Quantity_Color) -> Colour:
    values = colour.Values(Quantity_TypeOfColor.Quantity_TOC_sRGB)
    return float(values[0]), float(values[1]), float(values[2])


def _name(label: TDF_Label) -> str:
    name = TDataStd_Name()
    if not label.FindAttribute(TDataStd_Name.GetID_s(), name):
        return ""
    return name.Get().ToExtString()
