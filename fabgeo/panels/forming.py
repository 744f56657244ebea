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
        Bent glass: standards cover cylinders; other bent shapes are flagged.
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
    as is what is tighter than the rolls reach. Glass that does not spring is bent hot, in a mould.
    """
    if cls == "flat":
        return "flat", ""
    if radius_min >= sheet.springing_radius:
        return "spring", ""
    if sheet.glass:
        springs = f"it springs to {sheet.springing_radius:.0f} mm"
        return "press", f"radius {radius_min:.0f} mm is bent hot: {springs}"
    if radius_min < sheet.rolls:
        return "press", f"radius {radius_min:.0f} mm is below the rolls' {sheet.rolls:.0f} mm"
    return ("roll" if cls in ("cylinder", "cone") else "press"), ""


def beyond_standards(cls: str, sheet: Sheet) -> str:
    """What is to be said of bent glass that its standards do not cover; else nothing."""
    covered = not sheet.glass or cls in ("flat", "cylinder")
    return "" if covered else "bent-glass standards cover cylinders, not this shape"
