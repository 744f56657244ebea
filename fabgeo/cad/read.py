"""Faces of STEP and IGES files as plain B-spline data, in millimetres.

The kernel converts every surface to B-splines exactly (planes, cylinders, spheres, tori become
rational ones) and hands over the trimming curves in parameters. Nothing is sewn or healed beyond
what the kernel's own translation does.
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.surfaces.nurbs import NurbsFace

CURVE_SAMPLES = 48  # per polynomial piece of a trimming curve
MOST_SAMPLES = 2000
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
    from OCP.IGESCAFControl import IGESCAFControl_Reader
    from OCP.STEPCAFControl import STEPCAFControl_Reader

    path = Path(path)
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

    checked_file(path)
    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Alarm)
    Interface_Static.SetCVal_s("xstep.cascade.unit", "MM")
    if reader.ReadFile(str(path)) != IFSelect_RetDone:
        raise InputError(path.name, f"is not a readable {kind} file", "export it again")
    document = TDocStd_Document(TCollection_ExtendedString("XmlXCAF"))
    reader.Transfer(document)
    found = _faces_of(document, reader)
    if not found:
        raise InputError(
            path.name,
            f"the {kind} file holds no face",
            "export surfaces or solids, not curves, points or meshes",
        )
    names = [name or f"face {i}" for i, (_, name, _) in enumerate(found)]
    picked = range(len(found)) if chosen is None else chosen_faces(path.name, names, chosen)
    return [_nurbs_face(path.name, found[i][0], names[i], found[i][2]) for i in picked]


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
        found.append(_nurbs_face(name, face, f"face {len(found)}", None))
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


def _nurbs_face(where: str, face: Any, name: str, colour: Any) -> NurbsFace:
    from OCP.BRep import BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
    from OCP.Geom import Geom_BSplineSurface
    from OCP.GeomConvert import GeomConvert
    from OCP.TopoDS import TopoDS

    converted = BRepBuilderAPI_NurbsConvert(face, True)
    if not converted.IsDone():
        raise InputError(where, f"{name} can't be converted to a B-spline", "export it again")
    spline_face = TopoDS.Face_s(converted.Shape())
    surface = BRep_Tool.Surface_s(spline_face)
    if not isinstance(surface, Geom_BSplineSurface):
        surface = GeomConvert.SurfaceToBSplineSurface_s(surface)
    surface = surface.Copy()
    _open_knots(surface)
    poles, weights = _poles(surface)
    return NurbsFace(
        poles=poles,
        weights=weights,
        knots_u=_flat(surface.NbUKnots(), surface.UKnot, surface.UMultiplicity),
        knots_v=_flat(surface.NbVKnots(), surface.VKnot, surface.VMultiplicity),
        degree_u=surface.UDegree(),
        degree_v=surface.VDegree(),
        trims=tuple(_loops(spline_face)),
        name=name,
        colour=colour,
    )


def _open_knots(surface: Any) -> None:
    """Give a periodic surface ordinary end knots."""
    if surface.IsUPeriodic():
        surface.SetUNotPeriodic()
    if surface.IsVPeriodic():
        surface.SetVNotPeriodic()


def _poles(surface: Any) -> tuple[Array, Array | None]:
    rows, columns = surface.NbUPoles(), surface.NbVPoles()
    poles = np.empty((rows, columns, 3))
    weights = np.ones((rows, columns))
    rational = surface.IsURational() or surface.IsVRational()
    for i in range(rows):
        for j in range(columns):
            p = surface.Pole(i + 1, j + 1)
            poles[i, j] = p.X(), p.Y(), p.Z()
            if rational:
                weights[i, j] = surface.Weight(i + 1, j + 1)
    return poles, weights if rational else None


def _flat(count: int, knot: Any, multiplicity: Any) -> Array:
    values = [knot(i) for i in range(1, count + 1)]
    return np.repeat(values, [multiplicity(i) for i in range(1, count + 1)])


def _loops(face: Any) -> list[Array]:
    """Trimming loops as polylines (k, 2) in the face's parameters."""
    from OCP.BRepTools import BRepTools_WireExplorer
    from OCP.TopAbs import TopAbs_WIRE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    loops = []
    wires = TopExp_Explorer(face, TopAbs_WIRE)
    while wires.More():
        explorer = BRepTools_WireExplorer(TopoDS.Wire_s(wires.Current()), face)
        points: list[Array] = []
        while explorer.More():
            points.append(_edge_points(explorer.Current(), face))
            explorer.Next()
        if points:
            loop = _thinned(np.concatenate([p[:-1] for p in points]))
            if len(loop) >= 3:
                loops.append(loop)
        wires.Next()
    return loops


def _thinned(loop: Array) -> Array:
    """The loop without points that lie within 1e-6 of its size on a straight line."""
    import shapely

    size = float(np.linalg.norm(np.ptp(loop, axis=0)))
    line = shapely.LineString(np.concatenate([loop, loop[:1]]))
    return np.asarray(shapely.simplify(line, 1e-6 * size).coords)[:-1]


def _edge_points(edge: Any, face: Any) -> Array:
    """Points (k, 2) of an edge's curve in the face's parameters, in the edge's direction."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve2d
    from OCP.GeomAbs import GeomAbs_BezierCurve, GeomAbs_BSplineCurve, GeomAbs_Line
    from OCP.TopAbs import TopAbs_REVERSED

    curve = BRepAdaptor_Curve2d(edge, face)
    first, last = curve.FirstParameter(), curve.LastParameter()
    kind = curve.GetType()
    pieces = 1
    if kind == GeomAbs_BSplineCurve:
        pieces = curve.NbKnots() - 1
    straight = kind == GeomAbs_Line or (
        kind in (GeomAbs_BSplineCurve, GeomAbs_BezierCurve) and curve.Degree() == 1 and pieces == 1
    )
    count = 2 if straight else min(max(CURVE_SAMPLES * pieces, 512), MOST_SAMPLES) + 1
    values = [curve.Value(t) for t in np.linspace(first, last, count)]
    points = np.array([[p.X(), p.Y()] for p in values])
    return points[::-1] if edge.Orientation() == TopAbs_REVERSED else points
