"""Offsets of conical and circular models at constant distance, measured and never folded.

A conical model's offset p + d n has rulings and tangent planes at distance d; a circular model's
has vertices at distance d (paper section 2). Offset curves are no splines: they are interpolated
on the model's knots, which are halved until the error is within the tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabgeo import spline
from fabgeo.arrays import Array, checked_number, cross, dot
from fabgeo.errors import GeometryError
from fabgeo.strips.axes import Axes, axes
from fabgeo.strips.frames import frames
from fabgeo.strips.model import StripModel, check_model

ROUNDS = 8  # of halving knot spans at most; beside a model's knots the error falls slowly


@dataclass(frozen=True)
class OffsetErrors:
    """Measured errors of an offset model, worst over the model.

    Attributes
    ----------
    curve : float
        Distance of the interpolated edge curves from p + d n, mm.
    ruling, plane : float
        Error of the distance d between corresponding rulings and between tangent planes, mm
        (conical); of a circular model these are not constant and the figures are nan.
    vertex : float
        Error of the distance d between corresponding vertices, mm (circular; nan if conical).
    angle_deg : float
        Largest angle between corresponding rulings and planes.
    """

    curve: float
    ruling: float
    plane: float
    vertex: float
    angle_deg: float


@dataclass(frozen=True)
class Offset:
    """An offset pair on common knots.

    Attributes
    ----------
    base, model : StripModel
        The given model, its knots halved where needed, and its offset.
    distance : float
        Signed: positive on the side of t x e.
    factor : int
        Parameters of `base` are `factor` times those of the given model.
    axes : Axes
        The normals followed, as functions of the given model's u.
    errors : OffsetErrors
    """

    base: StripModel
    model: StripModel
    distance: float
    factor: int
    axes: Axes
    errors: OffsetErrors


def offset(model: StripModel, distance: float, tolerance: float = 1e-3) -> Offset:
    """The model's offset at a signed distance.

    Raises
    ------
    InputError
        If one of the arguments is something else.
    GeometryError
        If the model is neither conical nor circular, or the offset folds over: the message names
        the strip, u and the largest distance that is possible.
    """
    check_model("offset", model)
    checked_number("offset distance", distance)
    checked_number("offset tolerance", tolerance, above=0.0)
    field = axes(model)
    refuse_fold(model, field, distance)
    base, factor, error = model, 1, np.inf
    for _ in range(ROUNDS):
        u = np.arange(base.segments + (0 if base.closed_u else 1), dtype=np.float64)
        targets = base.points(u) + distance * field(u / factor)
        made = base.with_control(spline.interpolate(targets, base.closed_u))
        error = _curve_error(base, made, field, distance, factor)
        if error <= tolerance:
            break
        base, factor = base.refined(), 2 * factor
    else:
        raise GeometryError(
            f"offset by {distance:g} mm",
            f"its curves can't be interpolated to {tolerance:g} mm (found {error:.3g})",
            "give a larger tolerance or a smaller distance",
        )
    errors = _errors(base, made, field.kind, distance, error)
    return Offset(base, made, distance, factor, field, errors)


def _curve_error(
    base: StripModel, made: StripModel, field: Axes, distance: float, factor: int
) -> float:
    u = base.parameters(4)
    target = base.points(u) + distance * field(u / factor)
    return float(np.linalg.norm(made.points(u) - target, axis=-1).max())


def _errors(
    base: StripModel, made: StripModel, kind: str, distance: float, curve: float
) -> OffsetErrors:
    u = base.parameters(5)
    f, g = frames(base, u), frames(made, u)
    step = g.p - f.p
    turn = np.maximum(
        np.linalg.norm(cross(f.e, g.e), axis=-1), np.linalg.norm(cross(f.m, g.m), axis=-1)
    )
    angle = float(np.degrees(np.arcsin(np.minimum(turn, 1.0))).max())
    d = abs(distance)
    if kind == "circular":
        vertex = float(np.abs(np.linalg.norm(step, axis=-1) - d).max())
        return OffsetErrors(curve, np.nan, np.nan, vertex, angle)
    ruling = plane = 0.0
    for side in f.sides(step):
        across = side - dot(side, f.e)[..., None] * f.e
        ruling = max(ruling, float(np.abs(np.linalg.norm(across, axis=-1) - d).max()))
        plane = max(plane, float(np.abs(dot(side, f.m) - distance).max()))
    return OffsetErrors(curve, ruling, plane, np.nan, angle)


def largest_distance(model: StripModel, field: Axes, sign: float) -> tuple[float, int, float]:
    """How far the model can be offset to one side before it folds: distance, strip and u there.

    The offset folds where the edge's speed 1 + d nu (n' = nu p') or the ruling's length
    L + d (n_{i+1} - n_i) . e becomes zero: the smallest radius on that side.
    """
    u = model.parameters(8)
    f = frames(model, u)
    n = field(u)
    h = 1e-4
    low, high = u - h, u + h
    if not model.closed_u:
        low, high = np.maximum(low, 0.0), np.minimum(high, model.segments)
    dn = (field(high) - field(low)) / (high - low)[:, None]
    best = (np.inf, 0, 0.0)
    for dp, change in zip(f.sides(f.dp), f.sides(dn), strict=True):
        side = cross(f.m, f.e)
        rate = sign * dot(change, side) / dot(dp, side)
        best = min(best, _smallest(rate, u))
    n0, n1 = f.sides(n)
    rate = sign * dot(n1 - n0, f.e) / f.length
    return min(best, _smallest(rate, u))


def _smallest(rate: Array, u: Array) -> tuple[float, int, float]:
    """Smallest distance d > 0 with 1 + d rate = 0 over strips and u."""
    at = np.unravel_index(int(np.argmin(rate)), rate.shape)
    worst = float(rate[at])
    return (-1.0 / worst if worst < 0.0 else np.inf), int(at[0]), float(u[at[1]])


def refuse_fold(model: StripModel, field: Axes, distance: float) -> None:
    """Raise a GeometryError if the offset at `distance` folds over anywhere."""
    limit, strip, u = largest_distance(model, field, float(np.sign(distance) or 1.0))
    if abs(distance) >= limit:
        raise GeometryError(
            f"offset by {distance:g} mm, strip {strip} at u = {u:.3g}",
            f"folds over: the smallest radius on that side is {limit:.6g} mm",
            f"offset by less than {limit:.6g} mm or to the other side",
        )
