"""Folds, found by orientation: a fold-over has small residuals and a turned-over normal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.fitting.objectives.base import State
from fabgeo.fitting.samples import Sites


@dataclass(frozen=True)
class Fold:
    """Where a strip folds over: `strip` index, parameter `u`, number of sites concerned."""

    strip: int
    u: float
    count: int

    def __str__(self) -> str:
        return f"strip {self.strip} folds over at u = {self.u:.2f}"


def orientation(state: State, sites: Sites) -> Array:
    """Cosines between strip normals and a consistent surface normal: (strips, elements, q).

    The lower of both ends of the ruling; negative where the strip lies face down. The sign of the
    surface's normals is chosen so that most of the model lies face up.
    """
    d0, d1 = state.around(sites, 2, 1)
    p0, p1 = state.around(sites, 2)
    e = unit(p1 - p0)
    normal = state.feet(sites)[1].normal
    first = dot(unit(cross(unit(d0), e)), normal)
    second = dot(unit(cross(unit(d1), e)), normal)
    sign = 1.0 if np.sum(first + second) >= 0.0 else -1.0
    return np.minimum(sign * first, sign * second)


def regular(state: State, sites: Sites) -> Array:
    """Cosines between the normals at both ends of a ruling: (strips, elements, q).

    Negative where edges run against each other: a fold, whatever the surface.
    """
    d0, d1 = state.around(sites, 2, 1)
    p0, p1 = state.around(sites, 2)
    e = unit(p1 - p0)
    return dot(unit(cross(unit(d0), e)), unit(cross(unit(d1), e)))


def find_fold(state: State, sites: Sites, dense: Sites, least: float = 0.0) -> Fold | None:
    """The worst fold of a model, or None: by the surface at `sites`, by itself at `dense` ones.

    With `least` above 0, a strip that is about to fold at a dense site is one as well.
    """
    places = (sites, orientation(state, sites), 0.0), (dense, regular(state, dense), least)
    for where, cosines, bound in places:
        if np.any(cosines <= bound):
            strip, element, q = np.unravel_index(int(np.argmin(cosines)), cosines.shape)
            return Fold(int(strip), float(where.u[element, q]), int(np.sum(cosines <= bound)))
    return None
