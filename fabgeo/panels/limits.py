"""What a project tolerates and what the classes cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, BoolArray
from fabgeo.errors import InputError
from fabgeo.panels.pool import CLASSES, Pool


@dataclass(frozen=True)
class Tolerances:
    """Limits of the panels as made against the fitted model and against each other.

    Attributes
    ----------
    deviation_mm : float
        Distance of any point of a fitted panel from the shape that replaces it.
    kink_deg : float
        What replacement adds to the fitted model's own kink between two panels.
    gap_mm : float
        Distance between two made panels along their joint.
    flange_mm : float or None
        Change of the distance between panel and beam flange; None: as the deviation.
    ends_mm : float
        How far a made panel's ends may leave the fitted ones along the strip: ends run along
        rulings, and both panels of a joint follow.
    """

    deviation_mm: float = 1.0
    kink_deg: float = 1.0
    gap_mm: float = 2.0
    flange_mm: float | None = None
    ends_mm: float = 30.0

    def __post_init__(self) -> None:
        for name in ("deviation_mm", "kink_deg", "gap_mm", "flange_mm", "ends_mm"):
            value = getattr(self, name)
            if value is not None and not value > 0.0:
                raise InputError(f"tolerances.{name}", f"expected > 0, found {value}")

    @property
    def kink(self) -> float:
        """Kink limit in radians."""
        return float(np.radians(self.kink_deg))

    @property
    def flange(self) -> float:
        """Limit of the flange distance in mm."""
        return self.deviation_mm if self.flange_mm is None else self.flange_mm

    def holds(self, gap: Array, kink: Array) -> BoolArray:
        """Whether gaps (mm) and added kinks (radians) are within the limits."""
        return (gap <= self.gap_mm) & (kink <= self.kink)


@dataclass(frozen=True)
class Costs:
    """Relative cost of a panel by class."""

    flat: float = 1.0
    cylinder: float = 2.0
    cone: float = 3.0
    developable: float = 5.0

    def __post_init__(self) -> None:
        if min(self.by_kind) < 0.0:
            raise InputError("costs", f"expected no negative cost, found {self}")

    @property
    def by_kind(self) -> Array:
        """Costs in the order of CLASSES."""
        return np.array([getattr(self, name) for name in CLASSES])

    def of(self, pool: Pool) -> Array:
        """Cost of every candidate, (c,)."""
        return self.by_kind[pool.kind]
