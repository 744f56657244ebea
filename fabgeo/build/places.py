"""Where on the model a figure is at its worst, and what the surface is like there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fabgeo.arrays import unit
from fabgeo.build.geometry import Design
from fabgeo.strips.measures import Measures, Worst, measure

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
    found = measure(design.model, design.surface)
    return {key: _told(design, at, CURES[key]) for key in wanted if (at := _worst(found, key))}


def _worst(found: Measures, key: str) -> Worst | None:
    if key == "twist_max_deg":
        return found.twist_deg
    return found.conicality if key == "conical_residual" else found.deviation_max


def _told(design: Design, at: Worst, cure: str) -> str:
    points = design.model.points(np.array([at.u]))[:, 0]  # of all edges
    first, second = points[at.strip], points[(at.strip + 1) % len(points)]
    middle = (first + second)[None] / 2.0
    surface = design.surface.closest(middle)
    along = abs(float(surface.normal_curvature(unit(second - first)[None])[0]))
    least = abs(float(surface.principal()[0][0, 0]))
    where = ", ".join(f"{x:.0f}" for x in middle[0])
    return (
        f"strip {at.strip}, u = {at.u:.2f} around ({where}), where the surface's radius is "
        f"{_radius(along)} along the rulings and {_radius(least)} at least; {cure}"
    )


def _radius(curvature: float) -> str:
    return f"{1e-3 / curvature:.3g} m" if curvature > FLAT else "none"
