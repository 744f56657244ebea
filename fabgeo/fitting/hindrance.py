"""Which property of a surface keeps every start off it, and where: said where none holds."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array
from fabgeo.surfaces.base import DesignSurface, size_of
from fabgeo.surfaces.umbilics import umbilics

FLAT = 0.05  # curvature times the surface's size up to which it is called flat
BENT = 2.0  # the same from which on strips have to follow it
PART = 0.03  # of the surface's area: smaller parts hinder no net
SAMPLES = 800


def hindrance(surface: DesignSurface) -> str:
    """In words, with places; empty where nothing of the kind is found."""
    at, size = surface.sample(SAMPLES), size_of(surface)
    kappa, _ = at.principal()
    most, gauss = np.abs(kappa[:, 0]) * size, kappa[:, 0] * kappa[:, 1] * size**2
    flat, sharpest = most < FLAT, int(np.argmax(most))
    bent = f"bends with a radius of {size / max(most[sharpest], 1e-300):.4g} near "
    bent += _place(at.point[sharpest])
    if flat.mean() > PART and (most > BENT).mean() > PART:
        return (
            f"it is flat on {100.0 * flat.mean():.0f} % of its area, as near "
            f"{_place(_middle(at.point[flat]))}, and {bent}: where a flat part ends rulings have "
            "to follow its border; divide the surface there"
        )
    dome, saddle = gauss > FLAT**2, gauss < -(FLAT**2)
    if dome.mean() > PART and saddle.mean() > PART:
        return (
            f"it is dome-like near {_place(_middle(at.point[dome]))} and saddle-like near "
            f"{_place(_middle(at.point[saddle]))}, and {bent}: rulings have to take the one "
            "straight direction of the line between them; divide the surface there"
        )
    found = umbilics(surface)
    return (
        f"{found[0]}, about which principal directions turn; it {bent}" if found else f"it {bent}"
    )


def _middle(points: Array) -> Array:
    """The point that is nearest to the mean of all."""
    return points[np.argmin(np.linalg.norm(points - points.mean(axis=0), axis=1))]


def _place(point: Array) -> str:
    return "({:.4g}, {:.4g}, {:.4g})".format(*point)
