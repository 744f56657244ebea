"""Sections from the curves of a DXF file: one section a polyline, spline, circle or ellipse."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.surfaces.sections import Sections, checked_sections

CURVES = ("LWPOLYLINE", "POLYLINE", "SPLINE", "CIRCLE", "ELLIPSE", "ARC")
FLATNESS = 1e-4  # of a curve's size: how far the chords between its points may be off it
# $INSUNITS codes that lengths can sensibly have.
UNITS = {1: "in", 2: "ft", 4: "mm", 5: "cm", 6: "m"}


def read_dxf_sections(
    path: str | Path, layer: str | None = None, closed: bool | None = None
) -> tuple[Sections, str | None]:
    """Planar sections of a DXF file in its own unit, and that unit if the file says it.

    Parameters
    ----------
    layer : str, optional
        Only curves on this layer.

    Raises
    ------
    InputError
        If the file can't be read, holds no curve, or the curves are no sections.
    """
    from ezdxf.filemanagement import readfile

    path = Path(path)
    try:
        document = readfile(path)
        entities = list(document.modelspace())
        number = int(document.header.get("$INSUNITS", 0))
    except Exception as error:  # whatever a foreign reader raises over foreign bytes
        raise InputError(path.name, f"can't be read as DXF: {error}", "export it again") from error
    curves: list[Array] = []
    names: list[str] = []
    for entity in entities:
        if entity.dxftype() in CURVES and layer in (None, entity.dxf.layer):
            curves.append(_points(path.name, entity))
            names.append(f"{entity.dxf.layer} {entity.dxf.handle}")
    if not curves:
        where = f" on layer {layer!r}" if layer is not None else ""
        raise InputError(
            path.name,
            f"holds no polyline, spline, circle or ellipse{where}",
            "draw each section as one curve in model space",
        )
    unit = UNITS.get(number)
    return checked_sections(path.name, curves, names, closed), unit


def _points(name: str, entity: Any) -> Array:
    """Points on a curve: the corners of a polyline, else a fine flattening of the exact curve."""
    from ezdxf import path as dxf_path

    try:
        path = dxf_path.make_path(entity)
        length = float(dxf_path.bbox([path]).size.magnitude)
        if entity.dxftype() in ("SPLINE", "CIRCLE", "ELLIPSE", "ARC"):
            vertices = list(entity.flattening(FLATNESS * length))
        elif path.has_curves:
            vertices = list(path.flattening(FLATNESS * length))
        else:
            vertices = list(path.control_vertices())
    except (ValueError, TypeError, ArithmeticError) as error:
        raise InputError(name, f"a curve can't be read: {error}") from error
    return np.array([[p.x, p.y, p.z] for p in vertices])
