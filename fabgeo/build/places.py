"""Where on the model a figure is at its worst, and what the surface is like there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fabgeo.arrays import unit
from fabgeo.build.fitted import Fitted
from fabgeo.build.geometry import Design
from fabgeo.strips.measures import Measures, Worst, measure
from fabgeo.surfaces.base import DesignSurface

if TYPE_CHECKING:
    from collections.abc import Iterable

FLAT = 1e-9  # 1/mm: a ruling that lies on the surface
CURES = {
    "deviation_max_mm": "more strips, or more segments along them",
    "deviation_over_sag_limit": "more segments along the strips, or another start",
    "twist_max_deg": "more segments along the strips, or another start",
    "conical_residual": "more segments along the strips, or another start",
}


def places(design: Design, keys: Iterable[str]) -> dict[str, str]:
    """A text for each of the model's figures: strip, u, point, radii of the surface, and a cure."""
    wanted = [key for key in keys if key in CURES]
    if not wanted:
        return {}
    found = [(own, measure(own.model, design.surface)) for own in design.models]
    out = {}
    for key in wanted:
        own, measures = max(found, key=lambda one: _value(one[1], key))
        at = _worst(measures, key)
        if at is not None:
            out[key] = _told(design.surface, own, at, CURES[key])
    return out


def _worst(found: Measures, key: str) -> Worst | None:
    if key == "twist_max_deg":
        return found.twist_deg
    return found.conicality if key == "conical_residual" else found.deviation_max


def _value(found: Measures, key: str) -> float:
    """What the figure is on one of several models."""
    if key == "deviation_over_sag_limit":
        return found.deviation_over_sag_limit or 0.0
    at = _worst(found, key)
    return 0.0 if at is None else at.value


def _told(surface: DesignSurface, own: Fitted, at: Worst, cure: str) -> str:
    points = own.model.points(np.array([at.u]))[:, 0]  # of all edges
    first, second = points[at.strip], points[(at.strip + 1) % len(points)]
    middle = (first + second)[None] / 2.0
    there = surface.closest(middle)
    along = abs(float(there.normal_curvature(unit(second - first)[None])[0]))
    least = abs(float(there.principal()[0][0, 0]))
    where = ", ".join(f"{x:.0f}" for x in middle[0])
    return (
        f"strip {own.number(at.strip)}, u = {at.u:.2f} around ({where}), where the surface's "
        f"radius is {_radius(along)} along the rulings and {_radius(least)} at least; {cure}"
    )


def _radius(curvature: float) -> str:
    return f"{1e-3 / curvature:.3g} m" if curvature > FLAT else "none"
