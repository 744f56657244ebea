"""Start from a regular quad mesh's own rows and columns (a PQ mesh, a principal net)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.fitting.starts.draw import model_of_net
from fabgeo.fitting.starts.net import Net, model_through
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import DesignSurface
from fabgeo.surfaces.trace_extension import Extended


def mesh_start(
    surface: DesignSurface,
    strips: int | None,
    segments: int | None,
    direction: str | None = None,
    seed: Any = None,
    *,
    around: bool = False,
    **options: Any,
) -> tuple[StripModel, list[str]]:
    """Edges through the vertices of the mesh's rows ("u" exchanges rows and columns).

    With the mesh's own numbers of strips and segments (the default) its vertices are edge points
    exactly; with others the net is resampled and projected.

    Parameters
    ----------
    around : bool
        Whether a row of quads more on every open side overhangs the boundary.
    """
    net = mesh_net(surface)
    notes = ["a row of quads more on every open side"] if around else []
    if around:
        net = _widened(_widened(net).turned).turned
    if direction == "u":
        net = net.turned
    rows, columns, _ = net.points.shape
    own = rows - (not net.closed_s), columns - (not net.closed_t)
    if (strips or own[0], segments or own[1]) == own and "sag" not in options:
        model = model_through(net.points, net.closed_t, net.closed_s)
        return model, [f"the mesh's own {own[0]} x {own[1]} quads, vertices kept", *notes]
    options.setdefault("conjugate", False)
    reach = Extended(surface) if around else surface
    model, more = model_of_net(net, reach, strips or own[0], segments or own[1], **options)
    return model, [f"the mesh's {own[0]} x {own[1]} quads, resampled", *notes, *more]


def _widened(net: Net) -> Net:
    """With a row more at either side, on the parabolas through the three outer ones."""
    p = net.points
    if net.closed_s or len(p) < 3:
        return net
    before, after = (3.0 * a - 3.0 * b + c for a, b, c in (p[:3], p[:-4:-1]))
    return Net(np.concatenate([before[None], p, after[None]]), False, net.closed_t)


def mesh_net(surface: Any) -> Net:
    """The grid of a surface made of a regular quad mesh.

    Raises
    ------
    InputError
        If the surface has no grid of rows and columns.
    """
    grid = getattr(surface, "grid", None)
    if grid is None:
        raise InputError(
            surface.name,
            f"is no regular quad mesh with rows and columns{_hole(surface.loops)}",
            "choose another start, e.g. 'iso' or 'principal'",
        )
    closed_rows, closed_columns = getattr(surface, "grid_closed", (False, False))
    return Net(grid, closed_rows, closed_columns)


def _hole(loops: Sequence[Array]) -> str:
    """Where the smallest of several boundary loops lies, in words."""
    if len(loops) < 2:
        return ""
    small = min(loops, key=lambda loop: float(np.linalg.norm(np.ptp(loop, axis=0))))
    x, y, z = small.mean(axis=0)
    return f": it has {len(loops)} boundary loops, the smallest around ({x:.4g}, {y:.4g}, {z:.4g})"
