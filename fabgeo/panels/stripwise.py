"""What programmes of strips are made of: groups of panels, and options about placements."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from fabgeo.arrays import Array, BoolArray, IntArray
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.certify import deviation
from fabgeo.panels.firstorder import Boundaries, Option, option_of
from fabgeo.panels.groups import strips_of
from fabgeo.panels.pool import CLASSES
from fabgeo.panels.programme import Group, Rim
from fabgeo.panels.search import Search

_CYLINDER = CLASSES.index("cylinder")


class Stripwise:
    """The strips of a search, and what their panels can be made as.

    Parameters
    ----------
    search : Search

    Attributes
    ----------
    groups : list of (n,) int arrays
        The strips' panels.
    """

    def __init__(self, search: Search) -> None:
        self.search = search
        self.boundaries = Boundaries(search.joints, search.tolerances)
        self.groups = strips_of(len(search.samples), search.joints)

    @property
    def costs(self) -> Array:
        """What the strips cost as chosen, (g,)."""
        cost = self.search.costs.of(self.search.pool)[self.search.current]
        return self.summed(cost)

    def summed(self, values: Array) -> Array:
        """Sums (g,) over strips of numbers of panels (p,)."""
        return np.array([values[group].sum() for group in self.groups])

    @cached_property
    def options(self) -> list[Option]:
        """Every class about its closest placements, cylinders of any radius."""
        own = self.search.own
        return [self.option(k, base, own.possible[:, k]) for k, base in enumerate(own.fits)]

    @cached_property
    def offered(self) -> list[Option]:
        """The same, cylinders of the nearest radius that is offered."""
        search = self.search
        if not len(search.radii):
            return self.options
        everyone = np.arange(len(search.samples))
        base = search.rolled(everyone, search.own.fits[_CYLINDER])[0]
        able = deviation(search.samples, base)[0] <= search.tolerances.deviation_mm
        rolled = self.option(_CYLINDER, base, able, rolled=True)
        return [rolled if k == _CYLINDER else option for k, option in enumerate(self.options)]

    def option(self, kind: int, base: Carriers, able: BoolArray, rolled: bool = False) -> Option:
        """A class about placements; `rolled`: cylinders keep their radius."""
        name, base = CLASSES[kind], base.as_class(CLASSES[kind])
        moves = "rolled" if rolled else name
        return option_of(kind, moves, base, able, self.search.samples, self.boundaries)

    def alone(self, panels: IntArray) -> Group:
        """Panels without regard to others."""
        here = np.isin(self.search.joints.panels, panels)
        return Group(panels, np.flatnonzero(here.all(axis=1)))

    def beside(self, panels: IntArray) -> Group:
        """Panels beside their neighbours as chosen."""
        search = self.search
        here = np.isin(search.joints.panels, panels)
        rims = []
        for side in (0, 1):
            joint = np.flatnonzero(here[:, side] & ~here[:, 1 - side])
            chosen = search.current[search.joints.panels[joint, 1 - side]]
            beyond = self.boundaries.features(
                1 - side, joint, search.pool.carriers[chosen], search.pool.replaced[chosen]
            )
            rims += [Rim(int(j), side, f) for j, f in zip(joint, beyond, strict=True)]
        return Group(panels, np.flatnonzero(here.all(axis=1)), tuple(rims))
