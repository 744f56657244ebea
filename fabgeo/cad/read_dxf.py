"""Sections from the curves of a DXF file: one section a polyline, spline, circle or ellipse."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.surfaces.sections import Sections, checked_sections

CURVES = ("LWPOLYLINE", "POLYLINE", "SPLINE", "CIRCLE", "ELLIPSE", "ARC")
PIECES = 96  # straight pieces of a curved section: the smooth curve is fitted to their ends
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
    import ezdxf

    path = Path(path)
    try:
        document = ezdxf.readfile(path)
    except (OSError, ezdxf.DXFError, UnicodeDecodeError, ValueError) as error:
        raise InputError(path.name, f"can't be read as DXF: {error}", "export it again") from error
    curves: list[Array] = []
    names: list[str] = []
    for entity in document.modelspace():
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
    unit = UNITS.get(int(document.header.get("$INSUNITS", 0)))
    return checked_sections(path.name, curves, names, closed), unit


def _points(name: str, entity: object) -> Array:
    from ezdxf import path as dxf_path

    try:
        path = dxf_path.make_path(entity)  # type: ignore[call-overload]
        curved = path.has_curves
        if curved:
            length = float(dxf_path.bbox([path]).size.magnitude)
            vertices = list(path.flattening(1e-5 * length, segments=8))
        else:
            vertices = list(path.control_vertices())
    except (ValueError, TypeError, ArithmeticError) as error:
        raise InputError(name, f"a curve can't be read: {error}") from error
    points = np.array([[p.x, p.y, p.z] for p in vertices])
    if curved and len(points) > 2:
        points = _respaced(points, PIECES)
    return points


def _respaced(points: Array, pieces: int) -> Array:
    """Points at equal steps along a dense polyline."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0.0, length[-1], pieces + 1)
    return np.stack([np.interp(at, length, points[:, k]) for k in range(3)], axis=1)
