"""Exact conical models that structures are built on."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import cross, unit
from fabgeo.strips import exact
from fabgeo.strips.circular import conical_curves
from fabgeo.strips.model import StripModel
from fabgeo.strips.ruled import RuledPatch

ANGLES = np.linspace(0.0, 1.2, 9)
PROFILE = np.stack([6000 * np.cos(ANGLES), 6000 * np.sin(ANGLES)], axis=1)


def generic(refine: int = 4) -> StripModel:
    """A conical model without symmetry: over the Moebius image of a moulding surface."""
    moulding = exact.moulding(9000.0, 900.0, PROFILE)
    circular = exact.inverted(moulding, np.array([-6000.0, 2000.0, -5000.0]), 17000.0)
    made = conical_curves(circular)
    return exact.ExactModel(made.curves, made.edges, 12, kind="conical").interpolant(refine)


def twist_deg(mid: RuledPatch) -> float:
    u = mid.parameters(8)
    a, b = mid.edges(u)
    normals = [unit(cross(d, b - a)) for d in mid.edges(u, 1)]
    return float(np.degrees(np.arcsin(np.linalg.norm(cross(*normals), axis=-1).max())))
