"""A product tree as a STEP file (AP242) through the kernel's document: names, colours, layers.

Source: ISO 10303-242; OCCT's XCAF user guide. The kernel's document is written to directly since
higher layers rename shared products, mangle non-ASCII names and copy instances.
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import itertools
import os
import re
import tempfile
from datetime import UTC, datetime
from pathlib import Path

from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color, Quantity_ColorRGBA, Quantity_TypeOfColor
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label
from OCP.TDocStd import TDocStd_Document
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Shape
from OCP.XCAFDoc import (
    XCAFDoc_ColorTool,
    XCAFDoc_ColorType,
    XCAFDoc_DocumentTool,
    XCAFDoc_LayerTool,
    XCAFDoc_ShapeTool,
)

from fabgeo.cad import kernel
from fabgeo.cad.assembly import Colour, Node
from fabgeo.cad.steporder import ordered
from fabgeo.errors import InputError


def write_step(
    path: str | os.PathLike[str],
    root: Node,
    *,
    curves_on_surfaces: bool = False,
    author: str = "",
    organisation: str = "",
) -> Path:
    """Write a product tree as AP242, millimetres.

    The file is written beside and moved into place. Two writes of the same tree are equal to
    the byte where the environment variable SOURCE_DATE_EPOCH is set.

    Parameters
    ----------
    path : path
        ``.step`` or ``.stp``; its folder must exist.
    root : Node
        The assembly (or one part).
    curves_on_surfaces : bool
        Write parameter curves too: files are about twice as large. Rims of bored holes are
        found again from their curves in space; only solids cut by boolean operations need it.
    author, organisation : str
        For the header.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the tree holds no geometry, or the file can't be written.
    """
    target = Path(path)
    document = to_document(root)
    writer = _writer(curves_on_surfaces)
    if not writer.Transfer(document, STEPControl_StepModelType.STEPControl_AsIs):
        raise InputError(f"{target.name}", "the kernel could not translate the product tree")
    header = APIHeaderSection_MakeHeader(writer.ChangeWriter().Model())
    header.SetName(kernel.ascii_text(target.name))
    header.SetTimeStamp(kernel.ascii_text(time_stamp()))
    header.SetAuthorValue(1, kernel.ascii_text(author))
    header.SetOrganizationValue(1, kernel.ascii_text(organisation))
    header.SetOriginatingSystem(kernel.ascii_text("fabgeo"))
    beside = target.with_name(f".{target.name}.part")
    status = writer.Write(str(beside))
    if status != IFSelect_ReturnStatus.IFSelect_RetDone:
        beside.unlink(missing_ok=True)
        cure = "check that its folder is writable and has room"
        raise InputError(str(target), "could not be written", cure)
    _normalise(beside)
    os.replace(beside, target)
    return target


def _writer(curves_on_surfaces: bool) -> STEPCAFControl_Writer:
    kernel.be_quiet()
    writer = STEPCAFControl_Writer()
    # These switches exist once a writer does and are process-wide: set for every write.
    Interface_Static.SetCVal_s("write.step.schema", "AP242DIS")
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    Interface_Static.SetIVal_s("write.surfacecurve.mode", int(curves_on_surfaces))
    Interface_Static.SetCVal_s("write.step.product.name", "fabgeo")
    writer.ChangeWriter().Model(True)
    writer.SetColorMode(True)
    writer.SetNameMode(True)
    writer.SetLayerMode(True)
    return writer


def step_bytes(root: Node) -> bytes:
    """The STEP file of a product tree, for `fabgeo.cad.stepjoin` (arguments as `write_step`)."""
    with tempfile.TemporaryDirectory() as folder:
        return write_step(Path(folder) / "piece.step", root).read_bytes()


def step_text(name: str) -> bytes:
    """A name as it stands between the quotes of a STEP file."""
    data = name.replace("'", "''").replace("#", _HASH).encode()
    return _NOT_ASCII.sub(lambda found: _escape(found[0]), data)


def _normalise(path: Path) -> None:
    """Number occurrences from 1, not on from the last file; order styles; escape non-ASCII."""
    count = itertools.count(1)
    data = _OCCURRENCE.sub(  # on one line each: where they wrap depends on the old number
        lambda found: _OCCURS + b"'%d'%s;" % (next(count), found[1].replace(b"\n  ", b"")),
        path.read_bytes(),
    )
    if not data.isascii():
        data = _NOT_ASCII.sub(lambda found: _escape(found[0]), data)
    path.write_bytes(ordered(data))


def _escape(letters: bytes) -> bytes:
    r"""Letters as ``\X2\...\X0\`` (``\X4\`` beyond the basic plane): ISO 10303-21, 6.4.3."""
    text = letters.decode("utf-8").replace(_HASH, "#")
    wide = max(text) > "\uffff"
    digits = "".join(f"{ord(letter):0{8 if wide else 4}X}" for letter in text)
    return f"\\X{4 if wide else 2}\\{digits}\\X0\\".encode("ascii")


_HASH = "\ue023"
"""Stands for # in names on their way to the file, where # only ever begins a reference."""

_OCCURS = b"NEXT_ASSEMBLY_USAGE_OCCURRENCE("
_OCCURRENCE = re.compile(rb"NEXT_ASSEMBLY_USAGE_OCCURRENCE\('\d+'([^;]*);")
_NOT_ASCII = re.compile(rb"[\x80-\xff]+")


def time_stamp() -> str:
    """Now, or the moment of SOURCE_DATE_EPOCH, in ISO 8601 UTC."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
    moment = datetime.fromtimestamp(int(epoch), UTC) if epoch else datetime.now(UTC)
    return moment.strftime("%Y-%m-%dT%H:%M:%S")


def to_document(root: Node) -> TDocStd_Document:
    """The tree as a document of the kernel.

    Raises
    ------
    InputError
        If the tree holds no geometry.
    """
    if next(root.parts(), None) is None:
        raise InputError(f"assembly {root.name!r}", "holds no part", "leave the file out")
    document = TDocStd_Document(kernel.text("MDTV-XCAF"))
    filler = _Document(document)
    filler.add(root)
    filler.shapes.UpdateAssemblies()
    return document


class _Document:
    """A document while it is filled: its tools, and the label of every product made so far."""

    def __init__(self, document: TDocStd_Document) -> None:
        self.shapes: XCAFDoc_ShapeTool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
        self.colours: XCAFDoc_ColorTool = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
        self.layers: XCAFDoc_LayerTool = XCAFDoc_DocumentTool.LayerTool_s(document.Main())
        self.products: dict[int, TDF_Label] = {}
        self.shapes.SetAutoNaming_s(False)

    def add(self, node: Node) -> TDF_Label:
        """Label of the node's product: made at identity, so that layers and sharing survive."""
        node = node.instance_of or node
        known = self.products.get(id(node))
        if known is not None:
            return known
        label = self.shapes.NewShape()
        if node.shape is not None:
            self.shapes.SetShape(label, self._own(node.shape))
        for child in node.children:
            self._place(label, child)
        self._dress(label, node.name, node.colour, node.layer)
        self.products[id(node)] = label
        return label

    def _own(self, shape: TopoDS_Shape) -> TopoDS_Shape:
        """The shape itself, or a copy if another product has it: names would be mixed up."""
        if self.shapes.FindShape(shape, False).IsNull():
            return shape
        return BRepBuilderAPI_Copy(shape).Shape()

    def _place(self, parent: TDF_Label, child: Node) -> None:
        product = self.add(child)
        place = TopLoc_Location() if child.location is None else kernel.to_location(child.location)
        component = self.shapes.AddComponent(parent, product, place)
        own = child.colour if child.instance_of is not None else None
        layer = child.layer if child.instance_of is not None else ""
        self._dress(component, child.name, own, layer)

    def _dress(self, label: TDF_Label, name: str, colour: Colour | None, layer: str) -> None:
        TDataStd_Name.Set_s(label, kernel.text(name.replace("#", _HASH)))
        if colour is not None:
            rgba = Quantity_ColorRGBA()
            rgba.SetRGB(_srgb(colour))
            self.colours.SetColor(label, rgba, XCAFDoc_ColorType.XCAFDoc_ColorGen)
        if layer:
            self.layers.SetLayer(label, kernel.text(layer.replace("#", _HASH)))


def _srgb(colour: Colour) -> Quantity_Color:
    return Quantity_Color(*colour, Quantity_TypeOfColor.Quantity_TOC_sRGB)
