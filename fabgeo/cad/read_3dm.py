"""Surfaces and meshes of Rhino 3dm files (extra ``rhino``), in millimetres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.cad.isolated import CURE, read_isolated
from fabgeo.cad.read import checked_file, chosen_faces
from fabgeo.errors import InputError, MissingExtraError
from fabgeo.surfaces.bspline import BSplineChart
from fabgeo.surfaces.mesh import Mesh, checked_mesh
from fabgeo.surfaces.nurbs import NurbsFace, NurbsSurface

UNITS = {"Millimeters": "mm", "Centimeters": "cm", "Meters": "m", "Inches": "in", "Feet": "ft"}
SCALES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8}
TRIM_SAMPLES = 512


@dataclass(frozen=True)
class Content:
    """What a 3dm file holds: faces, or one mesh if it has no faces; lengths in millimetres."""

    faces: list[NurbsFace]
    mesh: Mesh | None
    unit: str


def read_3dm(
    path: str | Path,
    faces: Sequence[int | str] | None = None,
    piece: int | str | None = None,
) -> Content:
    """Breps, surfaces, extrusions and meshes of a Rhino file.

    Parameters
    ----------
    faces : sequence of int or str, optional
        Which faces, by index in file order or by the object's name.
    piece : int or "largest", optional
        Which piece of a mesh.

    Raises
    ------
    InputError
        If the file can't be read, its unit is unknown, or it holds neither faces nor meshes.
    MissingExtraError
        Without rhino3dm.
    """
    path = checked_file(Path(path))
    if find_spec("rhino3dm") is None:
        raise MissingExtraError(path.name, "rhino")
    return read_isolated(path, _read, path, faces, piece)


def _read(path: Path, faces: Sequence[int | str] | None, piece: int | str | None) -> Content:
    import rhino3dm

    model = rhino3dm.File3dm.Read(str(path))
    if model is None:
        raise InputError(path.name, "can't be read as a Rhino file", CURE)
    word = str(model.Settings.ModelUnitSystem).rsplit(".", 1)[-1]
    if word not in UNITS:
        raise InputError(
            path.name, f"its unit {word} isn't known", f"set it to one of {', '.join(UNITS)}"
        )
    unit = UNITS[word]
    found: list[NurbsFace] = []
    meshes: list[tuple[Array, list[list[int]]]] = []
    objects: Any = model.Objects
    for item in objects:
        name = item.Attributes.Name or ""
        geometry = item.Geometry
        if isinstance(geometry, rhino3dm.Mesh):
            meshes.append(_mesh(geometry, SCALES[unit]))
            continue
        found += _faces(geometry, name, SCALES[unit], rhino3dm)
    return _content(path.name, found, meshes, unit, faces, piece)


def _content(
    name: str,
    found: list[NurbsFace],
    meshes: list[tuple[Array, list[list[int]]]],
    unit: str,
    chosen: Sequence[int | str] | None,
    piece: int | str | None,
) -> Content:
    if found:
        names = [face.name or f"face {i}" for i, face in enumerate(found)]
        picked = range(len(found)) if chosen is None else chosen_faces(name, names, chosen)
        return Content([found[i] for i in picked], None, unit)
    if not meshes:
        raise InputError(
            name, "the file holds neither a surface nor a mesh", "export surfaces, not curves"
        )
    start = np.cumsum([0, *(len(v) for v, _ in meshes)])
    vertices = np.concatenate([v for v, _ in meshes])
    faces = [[int(i + s) for i in f] for s, (_, fs) in zip(start, meshes, strict=False) for f in fs]
    return Content([], checked_mesh(name, vertices, faces, piece), unit)


def _mesh(mesh: Any, scale: float) -> tuple[Array, list[list[int]]]:
    vertices = np.array([[v.X, v.Y, v.Z] for v in mesh.Vertices]).reshape(-1, 3) * scale
    faces = []
    for k in range(len(mesh.Faces)):
        a, b, c, d = mesh.Faces[k]
        faces.append([a, b, c] if c == d else [a, b, c, d])
    return vertices, faces


def _faces(geometry: Any, name: str, scale: float, rhino3dm: Any) -> list[NurbsFace]:
    """Faces of a brep, extrusion or surface; [] for anything else."""
    if isinstance(geometry, rhino3dm.Extrusion):
        geometry = geometry.ToBrep(True)
    if isinstance(geometry, rhino3dm.Brep):
        return [_brep_face(geometry, k, name, scale) for k in range(len(geometry.Faces))]
    if isinstance(geometry, rhino3dm.Surface):
        return [_face(geometry, name, scale)]
    return []


def _face(surface: Any, name: str, scale: float) -> NurbsFace:
    spline = surface.ToNurbsSurface()
    points = spline.Points
    rows, columns = points.CountU, points.CountV
    poles, weights = np.empty((rows, columns, 3)), np.ones((rows, columns))
    for i in range(rows):
        for j in range(columns):
            at = points[i, j]  # homogeneous: x w, y w, z w, w
            weights[i, j] = at.W
            poles[i, j] = np.array([at.X, at.Y, at.Z]) / at.W
    return NurbsFace(
        poles=poles * scale,
        weights=weights if spline.IsRational else None,
        knots_u=_knots(spline.KnotsU),
        knots_v=_knots(spline.KnotsV),
        degree_u=spline.OrderU - 1,
        degree_v=spline.OrderV - 1,
        name=name,
    )


def _knots(knots: Any) -> Array:
    """Rhino leaves out the first and the last knot of the usual vector."""
    inner = [float(knots[i]) for i in range(len(knots))]
    return np.array([inner[0], *inner, inner[-1]])


def _brep_face(brep: Any, k: int, name: str, scale: float) -> NurbsFace:
    """One face with its trims.

    The library hands over no trimming curves in parameters, but the edges in space: they are
    brought to parameters by their closest points on the untrimmed face.
    """
    face = _face(brep.Faces[k].UnderlyingSurface(), name, scale)
    if brep.IsSurface:
        return face
    chart = face.chart()
    surface = NurbsSurface([face], name or "face")
    loops = []
    for i in range(len(brep.Faces[k].Loops)):
        trims = brep.Faces[k].Loops[i].Trims
        lines = [_edge(brep, trims[j], scale) for j in range(len(trims))]
        line = np.concatenate([points for points in lines if len(points)])
        _, uv = surface.parameters(line)
        if not _on_sides(chart, uv):
            if any(_jumps(chart.domain[axis], uv[:, axis]) for axis in (0, 1)):
                raise InputError(
                    name or f"face {k}",
                    "is trimmed across the seam of a closed surface",
                    "split the surface at its seam in Rhino, or export STEP",
                )
            loops.append(uv)
        elif len(brep.Faces[k].Loops) > 1:
            loops.append(_rectangle(chart.domain))
    return replace(face, trims=tuple(loops))


def _edge(brep: Any, trim: Any, scale: float) -> Array:
    """Points along a trim's edge in the loop's direction, without the last; none at a pole."""
    if trim.EdgeIndex < 0:
        return np.empty((0, 3))
    edge = brep.Edges[trim.EdgeIndex]
    straight = edge.IsLinear(1e-9)
    t = np.linspace(edge.Domain.T0, edge.Domain.T1, 9 if straight else TRIM_SAMPLES + 1)
    points = np.array([[p.X, p.Y, p.Z] for p in (edge.PointAt(float(x)) for x in t)]) * scale
    return (points[::-1] if trim.IsReversed else points)[:-1]


def _on_sides(chart: BSplineChart, uv: Array) -> bool:
    """Whether all parameters lie on the sides of the rectangle: the face isn't really trimmed."""
    domain = chart.domain
    reach = 1e-5 * (domain[:, 1] - domain[:, 0])
    return bool((np.abs(uv[:, :, None] - domain) < reach[:, None]).any(axis=(1, 2)).all())


def _jumps(domain: Array, value: Array) -> bool:
    """Whether parameters along a loop jump by more than half the domain."""
    step = np.abs(np.diff(value, append=value[:1]))
    return bool(step.max() > 0.5 * (domain[1] - domain[0]) and len(value) > 8)


def _rectangle(domain: Array) -> Array:
    (u0, u1), (v0, v1) = domain
    return np.array([[u0, v0], [u1, v0], [u1, v1], [u0, v1]])
