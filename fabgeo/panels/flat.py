"""The flat part: what the cutting shop gets, in millimetres in its own plane.

Glossary
--------
outline
    One closed contour of flat edges in counter-clockwise order, seen on the up-side.
bend line
    The image of a ruling with the bending radius there (infinite on a plane).
up-side
    The side seen in the drawing; for a panel the building's outer side.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from fabgeo.arrays import Array, set_frozen


@dataclass(frozen=True)
class FlatEdge:
    """A smooth piece of an outline, dense enough to be exact as a cubic Hermite curve.

    Attributes
    ----------
    name : str
        "first", "second" (edge curves), "start", "end" (end rulings).
    points : (k, 2) array
        Points along the edge in the outline's sense; k = 2 for a straight edge.
    tangents : (k, 2) array
        Unit tangents there.
    arc : (k,) array
        Arc length from the edge's first point.
    shared : str
        Mark of the part that shares this edge; "" if none.
    """

    name: str
    points: Array
    tangents: Array
    arc: Array
    shared: str = ""

    def __post_init__(self) -> None:
        sizes: dict[str, int] = {}
        set_frozen(self, "points", ("k", 2), sizes)
        set_frozen(self, "tangents", ("k", 2), sizes)
        set_frozen(self, "arc", ("k",), sizes)

    @property
    def length(self) -> float:
        """Arc length in mm."""
        return float(self.arc[-1])


@dataclass(frozen=True)
class FlatHole:
    """A round hole (slot = 0) or slot in the plane; `angle` in radians is the slot's direction."""

    centre: Array
    diameter: float
    slot: float = 0.0
    angle: float = 0.0

    def __post_init__(self) -> None:
        set_frozen(self, "centre", (2,))


@dataclass(frozen=True)
class BendLine:
    """A ruling in the plane; radius in mm, positive where the part bends towards its up-side."""

    start: Array
    end: Array
    radius: float

    def __post_init__(self) -> None:
        set_frozen(self, "start", (2,))
        set_frozen(self, "end", (2,))


@dataclass(frozen=True)
class FlatPart:
    """A flat part with everything that is cut, marked or bent on it.

    Attributes
    ----------
    mark : str
    material : str
    thickness : float
        Millimetres.
    outline : tuple of FlatEdge
        In order; each ends where the next begins.
    holes : tuple of FlatHole
    bends : tuple of BendLine
    area : float
        Net area in mm2, holes taken off.
    grain : str
        "free", "along" (the part's x axis lies along the grain; 0 and 180 degrees only) or
        "steps" (multiples of 90 degrees).
    certificate : mapping
        Measured errors of the unfolding: edge_length_error_mm, area_error_rel, angle_error_deg,
        stretch_max, refold_error_mm.
    refold : (k, 2, 5) array
        For k rulings and both of their ends: x, y in the plane and x, y, z in space.
    contour : (n, 3) array, optional
        The outline as it is cut, once fitted: x, y and the bulge towards the next vertex.
    contour_tolerance : float
        mm, how far the contour may be from the outline.
    """

    mark: str
    material: str
    thickness: float
    outline: tuple[FlatEdge, ...]
    holes: tuple[FlatHole, ...] = ()
    bends: tuple[BendLine, ...] = ()
    area: float = 0.0
    grain: str = "steps"
    certificate: Mapping[str, float] = field(default_factory=dict)
    refold: Array | None = None
    contour: Array | None = None
    contour_tolerance: float = 0.0

    def __post_init__(self) -> None:
        if self.contour is not None:
            set_frozen(self, "contour", ("n", 3))
