"""Surfaces that a script holds in memory, as one `DesignSurface` in millimetres."""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.arrays import as_numbers, shown
from fabgeo.cad.read import faces_of_shape
from fabgeo.cad.read_surface import mesh_surface, read_surface
from fabgeo.errors import InputError
from fabgeo.surfaces.base import DesignSurface, size_of
from fabgeo.surfaces.mesh import checked_mesh
from fabgeo.surfaces.nurbs import NurbsSurface
from fabgeo.surfaces.units import check_size, unit_of

KNOWN = (
    "a design surface, a file's path, a face, shell or solid of build123d or CadQuery, a mesh "
    "with vertices and faces (or a pair of them), or a grid of points (n, m, 3)"
)


def as_surface(given: Any, unit: str = "mm", name: str | None = None) -> DesignSurface:
    """A surface of a script as a design surface.

    Parameters
    ----------
    given : object
        A `DesignSurface` (returned as it is), a file's path, a shape of build123d, CadQuery or the
        kernel (all its faces), a mesh with `vertices` and `faces` (such as trimesh's) or a pair of
        both, 0-based, or a grid of points (n, m, 3) as an array.
    unit : {"mm", "cm", "m", "in", "ft"}
        Unit of its lengths; design surfaces are in millimetres, and files may state their own.
    name : str, optional
        How messages call it.

    Raises
    ------
    InputError
        If it is none of these, holds no usable surface, or is of no building's size.
    """
    if isinstance(given, DesignSurface) and not isinstance(given, type):
        return given
    if isinstance(given, str | Path):
        return read_surface(given, unit=None if unit == "mm" else unit)
    if name is not None and not isinstance(name, str):
        raise InputError("as_surface", f"expected text as name, found {shown(name)}")
    name = name or name_of(given)
    found = unit_of(name, 0.0, unit)
    shape = _shape_of(given)
    surface: Any
    if shape is not None:
        faces = faces_of_shape(shape, name)
        surface = NurbsSurface([replace(f, poles=f.poles * found.scale) for f in faces], name)
    else:
        vertices, corners = _mesh_of(given, name)
        mesh = checked_mesh(name, as_numbers(name, vertices) * found.scale, corners)
        surface = mesh_surface(mesh, name)
    check_size(name, size_of(surface), found)
    surface.unit = found
    return surface


def name_of(given: Any) -> str:
    """What to call a surface that a script holds: its label or name, or what it is."""
    for key in ("label", "name"):
        own = getattr(given, key, "")
        if isinstance(own, str) and own:
            return own
    return type(given).__name__


def _shape_of(given: Any) -> Any | None:
    """The kernel's shape of an object of build123d or CadQuery, or the kernel's own."""
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound, TopoDS_Shape

    if isinstance(given, TopoDS_Shape):
        return given
    if callable(getattr(given, "vals", None)):  # a CadQuery workplane
        shapes = [value.wrapped for value in given.vals() if hasattr(value, "wrapped")]
        compound, builder = TopoDS_Compound(), BRep_Builder()
        builder.MakeCompound(compound)
        for shape in shapes:
            builder.Add(compound, shape)
        return compound
    wrapped = getattr(given, "wrapped", None)
    return wrapped if isinstance(wrapped, TopoDS_Shape) else None


def _mesh_of(given: Any, name: str) -> tuple[Any, list[Any]]:
    """Vertices and faces."""
    if isinstance(given, np.ndarray) and given.ndim == 3 and given.shape[2] == 3:
        rows, columns, _ = given.shape
        at = np.arange(rows * columns).reshape(rows, columns)
        quads = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], axis=-1)
        return given.reshape(-1, 3), quads.reshape(-1, 4).tolist()
    if hasattr(given, "vertices") and hasattr(given, "faces"):
        given = (given.vertices, given.faces)
    if not isinstance(given, tuple | list) or len(given) != 2:
        raise InputError(name, "is no surface that is known", f"give {KNOWN}")
    vertices, faces = given
    if not isinstance(faces, Iterable):
        raise InputError(name, f"has no faces, found {shown(faces)}", f"give {KNOWN}")
    return vertices, list(faces)
