"""Plates with thickness and holes as solids.

Glossary
--------
drill
    Cut round holes and slots straight through a plate, all in one boolean operation, and prove
    by the volume taken off that each one went through.
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
from OCP.TopoDS import TopoDS_Shape, TopoDS_Solid

from fabgeo.arrays import unit
from fabgeo.cad import kernel
from fabgeo.cad.measure import is_closed, is_valid, max_tolerance, volume
from fabgeo.cad.primitives import rounded_bar, shape_list
from fabgeo.cad.solids import prism_solid
from fabgeo.errors import PartError
from fabgeo.structures.parts import Hole, Plate
from fabgeo.structures.prisms import plate_prism

MAX_TOLERANCE = 1e-3
"""No written solid has a larger tolerance than this (mm)."""


def plate_solid(plate: Plate, tolerance: float = 1e-3, holes: bool = True) -> TopoDS_Solid:
    """The solid of a plate, its holes cut.

    Parameters
    ----------
    plate : Plate
    tolerance : float
        Of the skins' distance from their true place (mm).
    holes : bool
        Cut the holes.

    Raises
    ------
    PartError, GeometryError
        If the plate folds, or a hole can't be cut.
    """
    return prism_solid(plate_prism(plate, tolerance), holes=plate.holes if holes else ())


def drill(
    solid: TopoDS_Solid,
    holes: Sequence[Hole],
    thickness: float,
    mark: str = "plate",
    limit: float = MAX_TOLERANCE,
) -> TopoDS_Solid:
    """Cut holes through any plate-like solid by a boolean operation.

    `plate_solid` bores its holes exactly instead; on curved faces this one leaves tolerances of
    up to several micrometres.

    Parameters
    ----------
    solid : TopoDS_Solid
        The plate without holes.
    holes : sequence of Hole
        Centres on the mid-surface; they must lie inside the plate and apart from each other.
    thickness : float
        Of the plate, mm.
    mark : str
        Its name in messages.
    limit : float
        Largest tolerance of the result, mm.

    Raises
    ------
    PartError
        If the result is not one valid closed solid within the limit, or the volume taken off
        tells that a hole misses the plate or breaks out of its edge.
    """
    if not holes:
        return solid
    before, _ = volume(solid)
    cut = BRepAlgoAPI_Cut()
    cut.SetArguments(shape_list([solid]))
    cut.SetTools(shape_list([_cutter(hole, thickness) for hole in holes]))
    cut.SetRunParallel(False)
    cut.Build()
    found = kernel.solids(cut.Shape()) if cut.IsDone() else []
    if len(found) != 1 or not is_valid(found[0]) or not is_closed(found[0]):
        raise PartError(
            mark,
            f"cutting {len(holes)} holes leaves {len(found)} solids or an invalid one",
            "keep holes inside the plate and apart from each other",
        )
    tolerance = max_tolerance(found[0])
    if tolerance > limit:
        raise PartError(
            mark,
            f"its holes can be cut only with a tolerance of {tolerance:.2g} mm, expected "
            f"{MAX_TOLERANCE:g} mm or less",
            "move a hole away from edges and knots",
        )
    after, _ = volume(found[0])
    _refuse_missed(mark, holes, thickness, before - after)
    return found[0]


def _refuse_missed(mark: str, holes: Sequence[Hole], thickness: float, removed: float) -> None:
    sections = [np.pi / 4.0 * h.diameter**2 + h.slot * h.diameter for h in holes]
    expected = thickness * sum(sections)
    # A hole that is lost or cut in half changes the sum by at least half the smallest hole.
    allowed = 0.02 * expected + 0.3 * thickness * min(sections)
    if abs(removed - expected) > allowed:
        raise PartError(
            mark,
            f"its {len(holes)} holes take off {removed:.0f} mm3, expected {expected:.0f}: one "
            "misses the plate, breaks out of its edge or meets another",
            "keep the edge distance, drill square to the plate",
        )


def _cutter(hole: Hole, thickness: float) -> TopoDS_Shape:
    """A cylinder or a rounded bar through the plate, on the hole's axis."""
    axis = unit(hole.axis)
    reach = thickness + hole.diameter
    bottom = hole.centre - reach * axis
    along = hole.direction - (hole.direction @ axis) * axis
    if np.linalg.norm(along) < 1e-9:
        along = np.eye(3)[np.argmin(np.abs(axis))]
        along = along - (along @ axis) * axis
    along = unit(along)
    if hole.slot == 0.0:
        frame = kernel.axes(bottom, axis, along).Ax2()
        return BRepPrimAPI_MakeCylinder(frame, hole.diameter / 2.0, 2.0 * reach).Shape()
    return rounded_bar(bottom, axis, along, hole.diameter, hole.slot, 2.0 * reach)
