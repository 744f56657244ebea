"""Parts of the building as the page shows them: prisms, plates and surfaces sampled as rails."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.review.record import Family, Shown
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Plate, Prism


def shown_prism(
    prism: Prism, family: Family, normal: Array, row: str = "", count: int = 9
) -> Shown:
    """A prism's edge curves, each sampled at `count` parameters."""
    u = np.linspace(prism.knots[0], prism.knots[-1], count)
    curve = BSpline(prism.knots, np.moveaxis(prism.poles, 1, 0), 3)
    rails = np.moveaxis(np.asarray(curve(u)), 0, 1)
    return Shown(prism.mark, family, rails, normal, row)


def shown_plate(plate: Plate, family: Family, row: str = "", count: int = 9) -> Shown:
    """A plate as the solid between its two faces, thickness to both sides of the mid-surface."""
    u = np.linspace(plate.mid.u0, plate.mid.u1, count)
    edges, normals = plate.mid.edges(u), patch_normals(plate.mid, u)
    half = 0.5 * plate.thickness * normals
    rails = np.stack([edges[0] - half, edges[1] - half, edges[1] + half, edges[0] + half])
    return Shown(plate.mark, family, rails, unit(normals.mean(axis=0)), row)


def patch_normals(patch: RuledPatch, u: Array) -> Array:
    """Unit normals (k, 3) of a developable patch along its rulings at u (k,)."""
    a, b = patch.edges(u)
    da, db = patch.edges(u, 1)
    return unit(cross(0.5 * (da + db), b - a))


def facing(shown: Shown, outward: Array) -> Shown:
    """The same part with its normal turned to the side of `outward`."""
    sign = 1.0 if dot(shown.normal, outward) >= 0.0 else -1.0
    return Shown(shown.mark, shown.family, shown.rails, sign * shown.normal, shown.row)
