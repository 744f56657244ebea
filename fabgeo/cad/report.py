"""What the kernel says of a solid, as plain numbers that need no kernel."""

from __future__ import annotations

from dataclasses import dataclass

from fabgeo.arrays import Array


@dataclass(frozen=True)
class SolidReport:
    """What the kernel says of one shape.

    Attributes
    ----------
    solids : int
        Number of solids.
    valid : bool
        By BRepCheck (which knows nothing of folds: see `fabgeo.cad.sound`).
    closed : bool
        Every edge is used by two faces, once in each sense.
    volume : float
        mm3, positive for a solid that is oriented outwards.
    centre : (3,) array
        Centre of mass.
    tolerance : float
        The largest tolerance of faces, edges and vertices in mm.
    surfaces : dict
        Number of faces of each kind: plane, cylinder, cone, bspline, ...
    """

    solids: int
    valid: bool
    closed: bool
    volume: float
    centre: Array
    tolerance: float
    surfaces: dict[str, int]

    @property
    def sound(self) -> bool:
        """One valid, closed solid of positive volume."""
        return self.solids == 1 and self.valid and self.closed and self.volume > 0.0
