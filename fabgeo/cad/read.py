"""Faces of STEP and IGES files as plain B-spline data, in millimetres.

The kernel converts every surface to B-splines exactly (planes, cylinders, spheres, tori become
rational ones) and hands over the trimming curves in parameters. Nothing is sewn or healed beyond
what the kernel's own translation does. It works in a process of its own: damaged files kill it.
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fabgeo.cad.failures import refuse_failures
from fabgeo.cad.isolated import CURE, read_isolated
from fabgeo.cad.nurbsface import nurbs_face
from fabgeo.errors import InputError
from fabgeo.surfaces.nurbs import NurbsFace

LARGEST_FILE = 1 << 30
UNIT_WORDS = {
    "millimetre": "mm",
    "centimetre": "cm",
    "metre": "m",
    "inch": "in",
    "foot": "ft",
}


def read_step(path: str | Path, faces: Sequence[int | str] | None = None) -> list[NurbsFace]:
    """Faces of a STEP file; its own unit is converted to millimetres.

    Parameters
    ----------
    path : str or Path
    faces : sequence of int or str, optional
        Which faces: by index (0, 1, ... in file order) or by name; default all.

    Raises
    ------
    InputError
        If the file can't be read, holds no face, or a chosen face isn't there.
    """
    return read_with_unit(path, faces)[0]


def read_iges(path: str | Path, faces: Sequence[int | str] | None = None) -> list[NurbsFace]:
    """Faces of an IGES file (see `read_step`)."""
    return read_with_unit(path, faces)[0]


def read_with_unit(
    path: str | Path, faces: Sequence[int | str] | None = None
) -> tuple[list[NurbsFace], str]:
    """Faces of a STEP or IGES file in millimetres, and the unit the file is written in."""
    path = checked_file(Path(path))
    return read_isolated(path, _read_with_unit, path, faces)


def _read_with_unit(path: Path, faces: Sequence[int | str] | None) -> tuple[list[NurbsFace], str]:
    from OCP.IGESCAFControl import IGESCAFControl_Reader
    from OCP.STEPCAFControl import STEPCAFControl_Reader

    iges = path.suffix.lower() in (".iges", ".igs")
    reader = IGESCAFControl_Reader() if iges else STEPCAFControl_Reader()
    reader.SetColorMode(True)
    reader.SetNameMode(True)
    found = _read(path, reader, "IGES" if iges else "STEP", faces)
    return found, "its own unit" if iges else _step_unit(reader)


def _step_unit(reader: Any) -> str:
    """The unit of length that most of a STEP file's shapes are written in."""
    from OCP.TColStd import TColStd_SequenceOfAsciiString

    lengths, angles, solid_angles = (TColStd_SequenceOfAsciiString() for _ in range(3))
    reader.ChangeReader().FileUnits(lengths, angles, solid_angles)
    names = [lengths.Value(k).ToCString().lower() for k in range(1, lengths.Length() + 1)]
    if not names:
        return "its own unit"
    word = max(names, key=names.count)
    return str(UNIT_WORDS.get(word, word))


def checked_file(path: Path) -> Path:
    """The path, if it is a readable file of bearable size."""
    if not path.is_file():
        raise InputError(str(path), "there is no such file", "check the path")
    size = path.stat().st_size
    if size == 0:
        raise InputError(path.name, "the file is empty")
    if size > LARGEST_FILE:
        raise InputError(path.name, f"the file is larger than {LARGEST_FILE >> 20} MiB")
    return path


def _read(
    path: Path, reader: Any, kind: str, chosen: Sequence[int | str] | None
) -> list[NurbsFace]:
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.Interface import Interface_Static
    from OCP.Message import Message, Message_Alarm
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDocStd import TDocStd_Document

    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Alarm)
    Interface_Static.SetCVal_s("xstep.cascade.unit", "MM")
    if reader.ReadFile(str(path)) != IFSelect_RetDone:
        raise InputError(path.name, f"is not a readable {kind} file", CURE)
    document = TDocStd_Document(TCollection_ExtendedString("XmlXCAF"))
    reader.Transfer(document)
    basic = reader.ChangeReader() if kind == "STEP" else reader
    found = _faces_of(document, reader)
    if not found:
        raise InputError(
            path.name,
            f"the {kind} file holds no face",
            "export surfaces or solids, not curves, points or meshes",
        )
    refuse_failures(path.name, kind, basic.WS())
    names = [name or f"face {i}" for i, (_, name, _) in enumerate(found)]
    picked = range(len(found)) if chosen is None else chosen_faces(path.name, names, chosen)
    return [nurbs_face(path.name, found[i][0], names[i], found[i][2]) for i in picked]


def faces_of_shape(shape: Any, name: str) -> list[NurbsFace]:
    """All faces of a shape of the kernel, in millimetres as it is.

    Raises
    ------
    InputError
        If it holds none.
    """
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    found, explorer = [], TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        face = TopoDS.Face_s(explorer.Current())
        found.append(nurbs_face(name, face, f"face {len(found)}", None))
        explorer.Next()
    if not found:
        raise InputError(name, "the shape holds no face", "give a face, shell or solid")
    return found


def chosen_faces(where: str, names: Sequence[str], chosen: Sequence[int | str]) -> list[int]:
    """Indices of faces chosen by index or name, in the order given."""
    indices: list[int] = []
    for choice in chosen:
        if isinstance(choice, str):
            hits = [i for i, name in enumerate(names) if name == choice]
        else:
            hits = [choice] if 0 <= choice < len(names) else []
        if not hits:
            known = ", ".join(dict.fromkeys(names[:12]))
            raise InputError(
                where,
                f"has no face {choice!r}; it holds {len(names)}: {known}",
                "choose faces by index 0, 1, ... or by these names",
            )
        indices += [i for i in hits if i not in indices]
    return indices


def _faces_of(document: Any, reader: Any) -> list[tuple[Any, str, Any]]:
    """(face, name, colour) of everything in the document, in file order."""
    from OCP.Quantity import Quantity_Color
    from OCP.TDF import TDF_LabelSequence
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS
    from OCP.XCAFDoc import XCAFDoc_ColorSurf, XCAFDoc_DocumentTool

    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colours = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    labels = TDF_LabelSequence()
    shapes.GetFreeShapes(labels)
    found = []
    for k in range(1, labels.Length() + 1):
        shape = shapes.GetShape_s(labels.Value(k))
        explorer = TopExp_Explorer(shape, TopAbs_FACE)
        while explorer.More():
            face = TopoDS.Face_s(explorer.Current())
            colour = Quantity_Color()
            has = colours.GetColor(face, XCAFDoc_ColorSurf, colour)
            rgb = (colour.Red(), colour.Green(), colour.Blue()) if has else None
            found.append((face, _entity_name(reader, face), rgb))
            explorer.Next()
    return found


def _entity_name(reader: Any, face: Any) -> str:
    """The name of the STEP entity that a face came from, or an empty string."""
    if not hasattr(reader, "ChangeReader"):
        return ""
    entity = reader.ChangeReader().WS().TransferReader().EntityFromShapeResult(face, 1)
    name = entity.Name() if entity is not None and hasattr(entity, "Name") else None
    text = name.ToCString() if name is not None else ""
    return "" if text.upper() in ("", "NONE") else text
