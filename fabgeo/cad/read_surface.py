"""Any design surface file as one `DesignSurface` in millimetres."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.arrays import Array, checked_number, checked_path, shown
from fabgeo.errors import InputError
from fabgeo.surfaces import meshfile
from fabgeo.surfaces.base import size_of
from fabgeo.surfaces.loft import SectionSurface
from fabgeo.surfaces.mesh import Mesh
from fabgeo.surfaces.meshsurface import MeshSurface
from fabgeo.surfaces.nurbs import NurbsFace, NurbsSurface
from fabgeo.surfaces.quadgrid import GridSurface, quad_grid
from fabgeo.surfaces.sectionfile import read_sections
from fabgeo.surfaces.sections import Sections
from fabgeo.surfaces.units import MILLIMETRES, STATED, Unit, check_size, unit_of

STEP = (".step", ".stp", ".p21")
IGES = (".iges", ".igs")
SECTIONS = (".csv", ".json")
SUFFIXES = (*STEP, *IGES, ".3dm", *meshfile.SUFFIXES, *SECTIONS, ".dxf")


type FileSurface = NurbsSurface | GridSurface | MeshSurface | SectionSurface


def read_surface(
    path: str | Path,
    unit: str | None = None,
    faces: Sequence[int | str] | None = None,
    piece: int | str | None = None,
    layer: str | None = None,
    closed: bool | None = None,
    scale: float = 1.0,
) -> FileSurface:
    """The design surface that a file holds, in millimetres.

    STEP and IGES faces, 3dm (extra ``rhino``) breps, surfaces and meshes; OBJ, OFF, STL, PLY, 3MF
    meshes; sections as CSV, JSON or DXF curves. The result has an attribute `unit` (`Unit`) beside
    those of its class.

    Parameters
    ----------
    path : str or Path
    unit : {"mm", "cm", "m", "in", "ft"}, optional
        The file's unit. STEP, IGES and 3dm files carry theirs, and a given one must agree; a given
        one overrules that of a DXF file; of other files it is guessed from the size if not given.
    faces : sequence of int or str, optional
        Which faces of a STEP, IGES or 3dm file, by index or name.
    piece : int or "largest", optional
        Which connected piece of a mesh.
    layer : str, optional
        Only the curves of this layer of a DXF file.
    closed : bool, optional
        Whether sections are closed curves.
    scale : float
        What its lengths, in its unit, are times: 50 for a model at 1:50.

    Raises
    ------
    InputError
        If the file can't be read or makes no surface of a building's size.
    MissingExtraError
        For 3dm files without the extra ``rhino``.
    """
    path = checked_path("read_surface", path)
    scale = checked_number(f"{path.name}: scale", scale, above=0.0)
    suffix = path.suffix.lower()
    if unit is not None and (not isinstance(unit, str) or unit not in MILLIMETRES):
        raise InputError(path.name, f"unknown unit {unit!r}", f"use {', '.join(MILLIMETRES)}")
    if suffix not in SUFFIXES:
        raise InputError(
            path.name, f"no reader for {suffix or 'a file without suffix'!r} files",
            f"known are {', '.join(SUFFIXES)}",
        )  # fmt: skip
    if faces is not None and not _are_faces(faces):
        problem = f"expected numbers or names of faces, found {shown(faces)}"
        raise InputError(path.name, problem, "give a list")
    if not os.path.isfile(path):  # a path's own test fails where its name is too long
        raise InputError(str(path)[:200], "there is no such file", "check the path")
    if suffix in STEP or suffix in IGES or suffix == ".3dm":
        surface, found = _cad(path, unit, faces, piece, scale)
    elif suffix in meshfile.SUFFIXES:
        mesh = meshfile.read_mesh(path, piece)
        found = unit_of(path.name, scale * _diagonal(mesh.vertices), unit)
        surface = mesh_surface(scaled_mesh(mesh, scale * found.scale), path.name)
    else:
        surface, found = _sections(path, unit, layer, closed, scale)
    check_size(path.name, size_of(surface), found)
    surface.unit = found
    return surface


def _are_faces(faces: Any) -> bool:
    return (
        isinstance(faces, Sequence)
        and not isinstance(faces, str)
        and all(isinstance(face, int | str) and not isinstance(face, bool) for face in faces)
    )


def mesh_surface(mesh: Mesh, name: str) -> GridSurface | MeshSurface:
    """The smooth surface over a mesh: bicubic where it is a regular grid of quads."""
    grid = quad_grid(mesh)
    if grid is None:
        return MeshSurface(mesh, name)
    points = mesh.vertices[grid.index]
    return GridSurface(points, grid.closed_rows, grid.closed_columns, name, mesh)


def scaled_mesh(mesh: Mesh, scale: float) -> Mesh:
    """The mesh with vertices times `scale`."""
    return replace(mesh, vertices=mesh.vertices * scale)


def _cad(
    path: Path,
    unit: str | None,
    faces: Sequence[int | str] | None,
    piece: int | str | None,
    scale: float,
) -> tuple[FileSurface, Unit]:
    """Surfaces of files that carry their unit; a given unit is only compared."""
    if path.suffix.lower() == ".3dm":
        from fabgeo.cad.read_3dm import read_3dm

        content = read_3dm(path, faces, piece)
        own = content.unit
        surface: FileSurface = (
            NurbsSurface(_scaled_faces(content.faces, scale), path.name)
            if content.mesh is None
            else mesh_surface(scaled_mesh(content.mesh, scale), path.name)
        )
    else:
        from fabgeo.cad.read import read_with_unit

        found, own = read_with_unit(path, faces)
        surface = NurbsSurface(_scaled_faces(found, scale), path.name)
    if unit is not None and own in MILLIMETRES and unit != own:
        raise InputError(
            path.name,
            f"is said to be in {unit}, but the file itself says {own}",
            "drop the unit, or correct it in the CAD program",
        )
    return surface, Unit(own, MILLIMETRES.get(own, 1.0), STATED)


def _sections(
    path: Path, unit: str | None, layer: str | None, closed: bool | None, scale: float
) -> tuple[FileSurface, Unit]:
    stated: str | None = None
    if path.suffix.lower() == ".dxf":
        from fabgeo.cad.read_dxf import read_dxf_sections

        sections, stated = read_dxf_sections(path, layer, closed)
    else:
        sections = read_sections(path, closed)
    if unit is None and stated is not None:
        found = Unit(stated, MILLIMETRES[stated], STATED)
    else:
        found = unit_of(path.name, scale * _diagonal(np.concatenate(sections.points)), unit)
    return SectionSurface(_scaled_sections(sections, scale * found.scale), path.name), found


def _scaled_faces(faces: Sequence[NurbsFace], scale: float) -> list[NurbsFace]:
    return [replace(face, poles=face.poles * scale) for face in faces]


def _scaled_sections(sections: Sections, scale: float) -> Sections:
    points = tuple(p * scale for p in sections.points)
    return replace(sections, points=points, heights=sections.heights * scale)


def _diagonal(points: Array) -> float:
    """Diagonal of the bounding box."""
    return float(np.linalg.norm(np.ptp(points, axis=0)))
