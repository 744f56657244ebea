"""The parts a building is made of, as pure geometry in millimetres.

Glossary
--------
prism
    A closed polygon of N edge curves that share a parameter: a solid of N ruled faces and two
    planar ends. Cells, thick panels, web and flange plates are prisms with N = 4.
plate
    A ruled patch with thickness, laid evenly to both sides of its mid-surface.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from fabgeo.arrays import Array, set_frozen
from fabgeo.errors import InputError
from fabgeo.strips.model import Patch
from fabgeo.strips.ruled import RuledPatch

type Role = Literal["panel", "web", "flange_inner", "flange_outer", "wall", "end_plate"]


@dataclass(frozen=True)
class Prism:
    """A solid between N edge curves in cyclic order.

    Attributes
    ----------
    mark : str
        The part's mark; the STEP product's name.
    knots : (k + 4,) array
        Clamped cubic knots common to all edge curves.
    poles : (N, k, 3) array
        Their control points; face j is ruled between curve j and curve j + 1 (modulo N).
    """

    mark: str
    knots: Array
    poles: Array

    def __post_init__(self) -> None:
        set_frozen(self, "knots", ("n",))
        set_frozen(self, "poles", ("N", "k", 3))
        if len(self.knots) != self.poles.shape[1] + 4:
            raise InputError(self.mark, f"expected {self.poles.shape[1] + 4} knots")


@dataclass(frozen=True)
class Hole:
    """A round hole, or a slot where `slot` > 0, straight through a plate.

    Attributes
    ----------
    centre : (3,) array
        On the plate's mid-surface.
    axis : (3,) array
        Unit direction of the bolt.
    diameter : float
        Millimetres; the width of a slot.
    slot : float
        Distance of the slot's two centres; 0 for a round hole.
    direction : (3,) array
        Unit direction of the slot (any unit vector for a round hole).
    """

    centre: Array
    axis: Array
    diameter: float
    slot: float = 0.0
    direction: Array = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))

    def __post_init__(self) -> None:
        for name in ("centre", "axis", "direction"):
            set_frozen(self, name, (3,))
        if not (self.diameter > 0.0 and self.slot >= 0.0):
            raise InputError("Hole", f"expected diameter > 0, slot >= 0, found {self}")


@dataclass(frozen=True)
class Plate:
    """A plate that is cut flat and bent: panel, web, flange, wall.

    Attributes
    ----------
    mark, parent : str
        Its own mark and the mark of what it belongs to (a beam segment, a cell, itself).
    role : str
        "panel", "web", "flange_inner", "flange_outer", "wall" or "end_plate".
    mid : RuledPatch
        Mid-surface, net (joints already taken off), a developable ruled patch.
    thickness : float
        Millimetres.
    material : str
        Key of the project's material.
    holes : tuple of Hole
    shared : mapping
        What each edge is shared with: keys "first" and "second" (edge curves a and b), "start"
        and "end" (end rulings); values are marks of the neighbour plate. A missing key: nothing.
    bevel : (float, float)
        Run (mm) of the weld preparation at "start" and "end": the lower skin runs on by half of
        it, the upper one stops short by half of it, and the mid-surface keeps its length.
    """

    mark: str
    parent: str
    role: Role
    mid: RuledPatch
    thickness: float
    material: str
    holes: tuple[Hole, ...] = ()
    shared: Mapping[str, str] = field(default_factory=dict)
    bevel: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Cell:
    """A box of the box shell: four developable faces and two planar walls."""

    mark: str
    patch: Patch
    prism: Prism


@dataclass(frozen=True)
class Beam:
    """One transportable segment of a curved beam along an edge: separate plates.

    Attributes
    ----------
    mark : str
        ``B-03-1``.
    edge : int
        Edge index i.
    u0, u1 : float
        Parameter interval of the segment.
    plates : tuple of Plate
        Web, flanges and end plates.
    info : mapping
        Length along the edge, depth range, camber and the like: plain numbers in mm.
    """

    mark: str
    edge: int
    u0: float
    u1: float
    plates: tuple[Plate, ...]
    info: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Connector:
    """A placed instance of a panel fixing.

    Attributes
    ----------
    mark : str
        ``K-03-07-2``.
    product : str
        Key of the connector product; equal keys are one STEP product.
    frame : (4, 4) array
        Placement of the product: columns x, y, z (bolt axis, outwards) and origin, in mm.
    panel, beam : str
        Marks of the panel and of the beam segment that it joins.
    """

    mark: str
    product: str
    frame: Array
    panel: str
    beam: str

    def __post_init__(self) -> None:
        set_frozen(self, "frame", (4, 4))
