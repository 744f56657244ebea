"""Ruled prisms by formula: volume, centre of gravity, orientation, and the thick plate.

Glossary
--------
bilinear end
    A prism's sections u = const are quads between four edge curves; the solid is their sweep
    x(u, v, w), bilinear in v and w.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.errors import GeometryError
from fabgeo.strips.interpolated import interpolated
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Plate, Prism

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True)
class PrismProperties:
    """Volume (mm3), centre of gravity (3,), least of |det J| over its mean, with its sign."""

    volume: float
    centre: Array
    orientation: float


def ruled_normals(patch: RuledPatch, u: Array) -> Array:
    """Unit normals m (k, 3) of a developable patch along its rulings at u, on the side t x e."""
    a, b = patch.edges(u)
    da, db = patch.edges(u, 1)
    across: Array = unit(da) + unit(db)
    chord: Array = b - a
    return unit(cross(across, chord))


def plate_prism(plate: Plate, tolerance: float = 1e-3) -> Prism:
    """The plate as a solid: both faces at half the thickness from the mid-surface along m(u).

    The edge curves run a - t/2 m, b - t/2 m, b + t/2 m, a + t/2 m: face 0 is the lower skin, face
    2 the upper one. Rulings stay parallel; the offset is exact up to `tolerance` (mm).

    Raises
    ------
    GeometryError
        If the plate folds: its bending radius is smaller than half its thickness.
    """
    mid, half = plate.mid, plate.thickness / 2.0

    begin, end = _runs(plate)

    def skin(u: Array, sign: float) -> tuple[Array, Array]:
        """Both edges of the upper (+1) or lower (-1) skin; bevels move its ends."""
        length = mid.u1 - mid.u0
        at = u + sign * (begin * (mid.u1 - u) - end * (u - mid.u0)) / length
        a, b = mid.edges(at)
        h = sign * half * ruled_normals(mid, at)
        return a + h, b + h

    def curves(u: Array) -> Array:
        (a, b), (c, d) = skin(u, -1.0), skin(u, 1.0)
        return np.stack([a, b, d, c])

    made = interpolated(curves, mid.knots, tolerance, plate.mark)
    prism = Prism(plate.mark, made.knots, made.poles)
    refuse_folded(prism)
    return prism


def _runs(plate: Plate) -> tuple[float, float]:
    """Half the runs of the bevels at both ends as steps of the parameter."""
    mid = plate.mid
    out = []
    for run, u in zip(plate.bevel, (mid.u0, mid.u1), strict=True):
        at = np.array([u])
        a, b = mid.edges(at)
        side = cross(unit(b - a), ruled_normals(mid, at))
        speed = float(np.mean([np.abs(dot(d, side)) for d in mid.edges(at, 1)]))
        out.append(run / 2.0 / speed)
    return out[0], out[1]


def prism_properties(prism: Prism) -> PrismProperties:
    """Volume and centre of gravity of a prism by Gauss quadrature of its Jacobian.

    A prism of four curves is integrated as the trilinear-in-section solid; one of N curves by its
    section polygon's area vector (exact for planar sections).
    """
    if len(prism.poles) == 4:
        volume, centre, least = _quad_properties(prism)
    else:
        volume, centre, least = _polygon_properties(prism)
    return PrismProperties(abs(volume), centre, least)


def prism_volume(prism: Prism) -> float:
    """Volume in mm3, by numerical integration."""
    return prism_properties(prism).volume


def refuse_folded(prism: Prism) -> None:
    """Raise a GeometryError naming the part if det J changes its sign within the prism."""
    least = prism_properties(prism).orientation
    if least <= 0.0:
        raise GeometryError(
            prism.mark,
            f"folds over (the least Jacobian is {least:.3g} of its mean)",
            "reduce the thickness or the distance below the smallest radius, or cut there",
        )


def _sites(prism: Prism) -> tuple[Array, Array]:
    spans = np.unique(prism.knots)
    half = np.diff(spans)[:, None] / 2.0
    u = spans[:-1, None] + half * (_NODES + 1.0)
    return u.ravel(), (half * _WEIGHTS).ravel()


def _curves(prism: Prism, u: Array) -> tuple[Array, Array]:
    """Points and u-derivatives (N, k, 3) of the edge curves."""
    poles = np.ascontiguousarray(prism.poles.swapaxes(0, 1))
    curve = BSpline.construct_fast(prism.knots, poles, 3)
    p, dp = (np.asarray(curve(u, k), dtype=np.float64).swapaxes(0, 1) for k in (0, 1))
    return p, dp


# Bilinear weights of the four curves, and their derivatives in v and w, at 5 x 5 Gauss points.
_S, _SW = (_NODES + 1.0) / 2.0, _WEIGHTS / 2.0
_V, _W = (x.ravel() for x in np.meshgrid(_S, _S, indexing="ij"))
_SHAPE = np.stack([(1 - _V) * (1 - _W), _V * (1 - _W), _V * _W, (1 - _V) * _W])
_ALONG_V = np.stack([-(1 - _W), 1 - _W, _W, -_W])
_ALONG_W = np.stack([-(1 - _V), -_V, _V, 1 - _V])
_SECTION = np.outer(_SW, _SW).ravel()


def _quad_properties(prism: Prism) -> tuple[float, Array, float]:
    u, weight = _sites(prism)
    spans = np.unique(prism.knots)
    corners = np.concatenate([spans, (spans[1:] + spans[:-1]) / 2.0])
    points, rates = _curves(prism, np.concatenate([u, corners]))
    p, dp = (np.moveaxis(x[:, : len(u)], 0, 2) for x in (points, rates))  # (k, 3, curves)
    x, xu, xv, xw = (
        np.moveaxis(a @ b, 1, 2)
        for a, b in ((p, _SHAPE), (dp, _SHAPE), (p, _ALONG_V), (p, _ALONG_W))
    )
    det = dot(cross(xu, xv), xw)
    measure = det * weight[:, None] * _SECTION
    volume = float(measure.sum())
    centre = np.sum(measure[..., None] * x, axis=(0, 1)) / volume
    ends = _corner_determinants(points[:, len(u) :], rates[:, len(u) :])
    sign = np.sign(volume)
    return volume, centre, float(min((sign * det).min(), (sign * ends).min()) / np.abs(det).mean())


def _corner_determinants(p: Array, dp: Array) -> Array:
    """Jacobians along the four edge curves themselves."""
    xv = np.stack([p[1] - p[0], p[1] - p[0], p[2] - p[3], p[2] - p[3]])
    xw = np.stack([p[3] - p[0], p[2] - p[1], p[2] - p[1], p[3] - p[0]])
    return dot(cross(dp, xv), xw)


def _polygon_properties(prism: Prism) -> tuple[float, Array, float]:
    """Sum of the wedges between the section's centroid and its sides."""
    u, weight = _sites(prism)
    p, dp = _curves(prism, u)
    o, do = p.mean(axis=0), dp.mean(axis=0)
    q, dq = np.roll(p, -1, axis=0), np.roll(dp, -1, axis=0)
    total, moment, slices = 0.0, np.zeros(3), []
    for a, wa in zip(_S, _SW, strict=True):  # x = o + a (p - o) + a b (q - p): a triangle's map
        for b, wb in zip(_S, _SW, strict=True):
            side = p - o + b * (q - p)
            x = o + a * side
            xu = do + a * (dp - do + b * (dq - dp))
            det = dot(cross(xu, side), a * (q - p))
            measure = det * weight * wa * wb
            total += float(measure.sum())
            moment += np.einsum("nk,nkd->d", measure, x)
            slices.append(det.sum(axis=0) * wa * wb)
    section = np.sum(slices, axis=0)
    sign = np.sign(total)
    return total, moment / total, float((sign * section).min() / np.abs(section).mean())
