"""How a panel gets its shape: laid flat, sprung, rolled or pressed.

Glossary
--------
springing radius
    Smallest radius to which a sheet bends elastically: E t / (2 f_y). A panel no tighter than
    that is forced onto its beams by its fixings alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from fabgeo.errors import InputError

type Forming = Literal["flat", "spring", "roll", "press"]


@dataclass(frozen=True)
class Sheet:
    """What forming needs to know about a panel's material and the shop.

    Attributes
    ----------
    thickness : float
        mm.
    young, strength : float
        Young's modulus and yield strength (glass: design strength), MPa.
    rolls : float
        The least radius that the shop's rolls reach, mm.
    glass : bool
        Bent glass: standards cover cylinders; a cone is flagged.
    """

    thickness: float = 3.0
    young: float = 70000.0
    strength: float = 130.0
    rolls: float = 150.0
    glass: bool = False

    def __post_init__(self) -> None:
        for name in ("thickness", "young", "strength"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"Sheet.{name}", f"expected > 0, found {getattr(self, name)}")

    @property
    def springing_radius(self) -> float:
        """Smallest elastic bending radius E t / (2 f_y), mm."""
        return self.young * self.thickness / (2.0 * self.strength)


def forming_of(cls: str, radius_min: float, sheet: Sheet) -> tuple[Forming, str]:
    """Forming route of a panel class with its smallest radius, and what is to be said about it.

    Cylinders and cones go through the rolls; a general developable is pressed along its rulings,
    as is what is tighter than the rolls reach.
    """
    if cls == "flat":
        return "flat", ""
    note = (
        "bent-glass standards cover cylinders, not this shape"
        if (sheet.glass and cls != "cylinder")
        else ""
    )
    if radius_min >= sheet.springing_radius:
        return "spring", note
    if cls in ("cylinder", "cone") and radius_min >= sheet.rolls:
        return "roll", note
    if radius_min < sheet.rolls:
        tight = f"radius {radius_min:.0f} mm is below the rolls' {sheet.rolls:.0f} mm"
        note = f"{note}; {tight}" if note else tight
    return "press", note
