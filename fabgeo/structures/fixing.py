"""The parameters of a point fixing between panel and outer flange (paper Fig. 9).

Glossary
--------
frame
    Origin where the fixing's axis meets the flange's outer face; z along the panel's normal from
    the flange to the panel, x along the panel's edge.
stand-off
    Clear distance from the flange's outer face to the panel's near face along the axis.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields

import numpy as np

from fabgeo.arrays import checked_number, shown
from fabgeo.errors import InputError
from fabgeo.structures.parts import Beam, Connector, Plate

POSITIVE = ("spacing", "end_distance", "stand_off", "step")


@dataclass(frozen=True)
class LocalHole:
    """A hole in the fixing's frame; `angle` (radians, from x) is a slot's direction."""

    x: float = 0.0
    y: float = 0.0
    diameter: float = 14.0
    slot: float = 0.0
    angle: float = 0.0

    def __post_init__(self) -> None:
        for name in ("x", "y", "angle"):
            checked_number(f"LocalHole.{name}", getattr(self, name))
        checked_number("LocalHole.diameter", self.diameter, above=0.0)
        checked_number("LocalHole.slot", self.slot, least=0.0)


@dataclass(frozen=True)
class Fixing:
    """Parameters of a point fixing; its product geometry is drawn by the CAD room. All mm.

    Attributes
    ----------
    name : str
        Beginning of the product key.
    spacing, end_distance : float
        Largest distance of fixings along a panel's edge, and from its ends.
    edge_distance : float
        Distance of the axis from the panel's edge, square to it.
    stand_off, reach : float
        Nominal stand-off, and how far the real one may leave it.
    step : float
        Real stand-offs are rounded down to this step: equal ones are one product.
    rod, base_bolt : float
        Nominal sizes (12: M12) of the rod through the panel and of the two bolts in the flange.
    base_length, base_width, base_thickness, base_pitch : float
        Base plate on the flange, length along x; distance of its bolts along x.
    disc_diameter, disc_thickness : float
        Clamping disc on the panel's outer face.
    panel_holes, flange_holes : tuple of LocalHole
    maker : callable, optional
        The user's own bracket: the CAD room calls it with the fixing (its stand-off set) and
        takes the build123d part that it returns.
    """

    name: str = "FX"
    spacing: float = 600.0
    end_distance: float = 120.0
    edge_distance: float = 60.0
    stand_off: float = 25.0
    reach: float = 15.0
    step: float = 1.0
    rod: float = 12.0
    base_bolt: float = 10.0
    base_length: float = 120.0
    base_width: float = 60.0
    base_thickness: float = 8.0
    base_pitch: float = 80.0
    disc_diameter: float = 60.0
    disc_thickness: float = 6.0
    panel_holes: tuple[LocalHole, ...] = (LocalHole(diameter=13.5),)
    flange_holes: tuple[LocalHole, ...] = (
        LocalHole(x=-40.0, diameter=11.0, slot=10.0, angle=np.pi / 2.0),
        LocalHole(x=40.0, diameter=11.0, slot=10.0, angle=np.pi / 2.0),
    )
    maker: Callable[..., object] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InputError("Fixing.name", f"expected a name, found {shown(self.name)}")
        for entry in fields(self):
            value, where = getattr(self, entry.name), f"fixing {self.name}: {entry.name}"
            if entry.name in POSITIVE:
                checked_number(where, value, above=0.0)
            elif isinstance(entry.default, float):
                checked_number(where, value, least=0.0)
            elif entry.name.endswith("_holes"):
                holes = isinstance(value, tuple | list)
                if not holes or not all(isinstance(hole, LocalHole) for hole in value):
                    raise InputError(where, f"expected a tuple of LocalHole, found {shown(value)}")
                object.__setattr__(self, entry.name, tuple(value))
        if self.maker is not None and not callable(self.maker):
            problem = f"expected a function, found {shown(self.maker)}"
            raise InputError(f"fixing {self.name}: maker", problem)

    @property
    def limits(self) -> tuple[float, float]:
        """Least and largest stand-off: the base plate and a nut on it must find room."""
        least = self.base_thickness + 0.9 * self.rod
        return max(self.stand_off - self.reach, least), self.stand_off + self.reach

    @property
    def product(self) -> str:
        """Key of the product: name and stand-off."""
        return f"{self.name}-{self.stand_off:g}"


@dataclass(frozen=True)
class Fixings:
    """Placed fixings and the plates that they pierce.

    Attributes
    ----------
    connectors : list of Connector
    products : mapping
        Product key -> fixing with its real stand-off.
    panels : list of Plate
        The given panels, now with holes.
    beams : list of Beam
        The given beams, now with holes in their outer flanges.
    refused : mapping
        ``panel mark, edge`` -> why no fixing could be placed there.
    """

    connectors: list[Connector]
    products: Mapping[str, Fixing]
    panels: list[Plate]
    beams: list[Beam]
    refused: Mapping[str, str] = field(default_factory=dict)
