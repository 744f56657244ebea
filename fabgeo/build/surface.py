"""The first stage: the design surface that a project names, in millimetres."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fabgeo.arrays import checked_path, shown
from fabgeo.errors import InputError
from fabgeo.project import Project, Surface, parse_project, read_project
from fabgeo.surfaces.base import DesignSurface, size_of
from fabgeo.surfaces.units import SMALLEST, check_size, unit_of

if TYPE_CHECKING:
    from fabgeo.surfaces.inspection import Inspection

SEEN = 4000  # points by which a surface is known again


def project_of(
    given: Project | Mapping[str, Any] | Path | str, surface: object | None, base: Path | None
) -> tuple[Project, Path]:
    """The project that is given in whatever way, and the folder that its paths are relative to.

    Raises
    ------
    InputError
        If it is no project, or something is wrong with it.
    """
    if not isinstance(given, Project | Mapping | Path | str):
        raise InputError(
            "project",
            f"expected a Project, its tables or the path of its file, found {shown(given)}",
        )
    base = None if base is None else checked_path("base", base)
    if isinstance(given, Path | str):
        given, base = read_project(given), base or Path(given).parent
    if surface is not None:
        given = with_surface(given, surface)
    elif not isinstance(given, Project):
        given = parse_project(given)
    return given, base or Path()


def surface_of(project: Project, base: Path) -> DesignSurface:
    """The design surface of a project.

    Parameters
    ----------
    project : Project
    base : Path
        Folder that the project's paths are relative to.

    Raises
    ------
    InputError
        If the file is missing or holds no usable surface, or the formula is wrong.
    """
    asked = project.surface
    if asked.given is not None:
        raise InputError(
            "surface.given",
            f"{asked.given!r} is a surface that a script holds",
            "build it from Python with surface=, or name a file",
        )
    if asked.file is None:
        return _formula(asked, project.name)
    from fabgeo.cad.read_surface import read_surface

    path = base / asked.file
    if not os.path.isfile(path):  # False, too, for what can be no path
        cure = "surface.file is relative to the project file"
        raise InputError(str(path)[:200], "no such file", cure)
    options: dict[str, Any] = {} if asked.faces is None else {"faces": asked.faces}
    surface = read_surface(path, unit=asked.unit, scale=asked.scale, **options)
    size = size_of(surface)
    if surface.unit is not None and size < SMALLEST:  # the file's own unit makes it no building
        raise InputError(
            path.name,
            f"the file says its unit is {surface.unit.name}: the surface's diagonal is "
            f"{size:.4g} mm; expected {SMALLEST:g} mm at least",
            "set surface.scale, such as 50.0 for a model at 1:50",
        )
    return surface


def with_surface(project: Project | Mapping[str, Any], given: object) -> Project:
    """The project with a surface that a script holds in place of its [surface]."""
    from fabgeo.cad.given import name_of

    own = Surface(given=name_of(given), unit="mm")
    if isinstance(project, Project):
        return project.model_copy(update={"surface": own})
    return parse_project({**project, "surface": own.model_dump(exclude_defaults=True)})


def _formula(asked: Surface, name: str) -> DesignSurface:
    from fabgeo.surfaces.formula import FormulaSurface

    if None in (asked.x, asked.y, asked.z, asked.u, asked.v, asked.unit):
        raise InputError("[surface]", "a formula needs x, y, z, u, v and unit")
    unit = unit_of(name, 0.0, asked.unit)
    surface = FormulaSurface(
        str(asked.x),
        str(asked.y),
        str(asked.z),
        asked.u or (0.0, 1.0),
        asked.v or (0.0, 1.0),
        define=asked.define,
        closed_u=asked.closed_u,
        closed_v=asked.closed_v,
        scale=asked.scale * unit.scale,
        name=name,
    )
    check_size("surface.unit", size_of(surface), unit)
    surface.unit = unit
    return surface


def inspect_file(path: Path, unit: str | None = None) -> Inspection:
    """What a surface file, or the surface of a project file, holds.

    Raises
    ------
    InputError
        If the file cannot be read as a surface.
    """
    from fabgeo.cad.read_surface import read_surface
    from fabgeo.surfaces.inspect import inspect

    path = checked_path("inspect", path)
    if path.suffix.lower() == ".toml":
        surface = surface_of(read_project(path), path.parent)
    else:
        surface = read_surface(path, unit=unit)
    return inspect(surface)


def seen(surface: DesignSurface) -> tuple[Any, ...]:
    """Points of a surface by which it is known again, and its boundary."""
    at = surface.sample(SEEN)
    return at.point, at.normal, at.shape, surface.loops
