"""Measures of a strip model, apart from the objectives of the fit, each with its worst place.

Nothing here is shared with the fit: normals, angles and distances are computed directly from the
model's curves and from the design surface's closest points.

Glossary
--------
twist
    Angle between a strip's normals at the two ends of a ruling; 0 where developable.
developability
    Distance of the diagonals of the quad spanned by a ruling and both end tangents (paper eq. 2).
regression
    Smaller over larger speed across the ruling at its two ends: 1 on a cylinder, 0 where the
    striction point reaches an edge, negative where it lies inside the strip (a fold).
sag limit
    |kappa| L^2 / 16, the least deviation possible for a chord of length L.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from fabgeo.arrays import Array, BoolArray, checked_count, cross, dot
from fabgeo.strips.frames import EdgeCurves, Frames, check_lengths, frames, normal_change
from fabgeo.strips.model import check_model
from fabgeo.surfaces.base import MOST_SAMPLES, check_surface


@dataclass(frozen=True)
class Worst:
    """A worst value and its place: strip (or edge) index and u."""

    value: float
    strip: int
    u: float


@dataclass(frozen=True)
class Measures:
    """Worst values of a model, lengths in its unit, angles in degrees.

    `deviation_count` is how many samples `deviation_rms` is of; `covered_share` is the part of the
    surface that is as near to the model as the model is to the surface. Those of an edge carry the
    edge's index as `strip`. What needs a design surface is None without one; conicality,
    circularity, geodesic and kink_across are None for a single strip.
    """

    twist_deg: Worst
    developability: Worst
    conicality: Worst | None
    circularity: Worst
    geodesic: Worst | None
    kink_across_deg: Worst | None
    kink_along_deg: Worst
    width_min: Worst
    width_max: Worst
    regression: Worst
    radius_min: Worst
    folds: tuple[Worst, ...]
    deviation_max: Worst | None = None
    deviation_rms: float | None = None
    deviation_count: int | None = None
    overhang_max: Worst | None = None
    sag_limit: Worst | None = None
    deviation_over_sag_limit: float | None = None
    surface_to_model_max: float | None = None
    surface_to_model_rms: float | None = None
    surface_to_model_at: tuple[float, float, float] | None = None
    covered_share: float | None = None
    boundary_max: float | None = None
    boundary_to_model_max: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for files."""
        return asdict(self)

    def lines(self) -> list[str]:
        """One line a measure, for people."""
        out = []
        for entry in fields(self):
            value = getattr(self, entry.name)
            if isinstance(value, Worst):
                text = f"{value.value:.6g}   (strip {value.strip}, u = {value.u:.3f})"
            elif isinstance(value, float):
                text = f"{value:.6g}"
            elif entry.name == "folds":
                text = f"{len(value)}"
            else:
                continue
            out.append(f"{entry.name:26s} {text}")
        return out


def worst(values: Array, u: Array, indices: range | None = None, least: bool = False) -> Worst:
    """The largest (or least) of values (rows, k) with its row's index and parameter."""
    row, column = np.unravel_index(
        int(np.argmin(values) if least else np.argmax(values)), values.shape
    )
    index = int(row) if indices is None else indices[int(row)]
    return Worst(float(values[row, column]), index, float(u[column]))


def angle(a: Array, b: Array) -> Array:
    """Angles between unit vectors, stable near 0 and near pi."""
    return 2.0 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))


def twist(f: Frames) -> Array:
    """Twist (strips, k) in radians."""
    return angle(f.m_first, f.m_second)


def developability(f: Frames) -> Array:
    """Distance of the diagonals (strips, k): L |det(t0, t1, e)| / |(e + t1) x (e - t0)|."""
    t0, t1 = f.sides(f.t)
    volume = np.abs(dot(cross(t0, t1), f.e))
    base = np.linalg.norm(cross(f.e + t1, f.e - t0), axis=-1)
    return f.length * volume / np.where(base > 0.0, base, 1.0)


def conicality(f: Frames) -> Array:
    """|t . (e+ - e-)| (interior edges, k)."""
    back, e_plus = f.at_edges(f.e)
    return np.abs(dot(_interior(f, f.t), e_plus + back))


def circularity(f: Frames) -> Array:
    """|(t_i + t_{i+1}) . e_i| (strips, k)."""
    t0, t1 = f.sides(f.t)
    return np.abs(dot(t0 + t1, f.e))


def geodesic(model: EdgeCurves, f: Frames) -> Array:
    """|kappa_g+ + kappa_g-| L (interior edges, k): geodesic curvatures towards both strips."""
    speed = np.linalg.norm(f.dp, axis=-1)
    bend = cross(f.dp, model.points(f.u, 2)) / np.where(speed > 0.0, speed, 1.0)[..., None] ** 3
    m_minus, m_plus = f.at_edges(f.m)
    before, after = f.at_edges(f.length)
    return np.abs(dot(_interior(f, bend), m_minus + m_plus)) * (before + after) / 2.0


def kink_across(f: Frames) -> Array:
    """Angle between neighbouring strips' normals (interior edges, k), radians."""
    m_minus = f.at_edges(f.m_second)[0]
    return angle(m_minus, f.at_edges(f.m_first)[1])


def _interior(f: Frames, values: Array) -> Array:
    return values if f.closed_i else values[1:-1]


def kink_along(model: EdgeCurves) -> Worst:
    """Largest angle between an edge's tangents on both sides of a knot, degrees."""
    first = 0 if model.closed_u else 1
    knots = np.arange(first, model.segments, dtype=np.float64)
    if len(knots) == 0:
        return Worst(0.0, 0, 0.0)
    tiny = 1e-9
    before, after = frames(model, knots - tiny), frames(model, knots + tiny)
    return worst(np.degrees(angle(before.t, after.t)), knots)


def across_speeds(f: Frames) -> tuple[Array, Array]:
    """Speeds of both ends across the ruling in the strip's orientation (strips, k) each."""
    d0, d1 = f.sides(f.dp)
    return dot(cross(d0, f.e), f.m), dot(cross(d1, f.e), f.m)


def regression(f: Frames) -> Array:
    """Smaller over larger speed across the ruling (strips, k); negative where it folds."""
    a, b = across_speeds(f)
    large = np.maximum(np.abs(a), np.abs(b))
    return np.minimum(a, b) / np.where(large > 0.0, large, 1.0)


def bending_radius(model: EdgeCurves, f: Frames) -> tuple[Array, Array]:
    """Signed radii (strips, k) at both ends: positive where the strip bends towards its normal."""
    change = normal_change(model, f)
    side = cross(f.e, f.m)
    out = []
    for d, dm in zip(f.sides(f.dp), (change.m_first, change.m_second), strict=True):
        turn = -dot(dm, side)
        speed = dot(d, side)
        out.append(speed / np.where(turn != 0.0, turn, 1e-300))
    return out[0], out[1]


def folds(f: Frames) -> tuple[Worst, ...]:
    """Places where a strip folds: the worst one of every strip that does (value: regression).

    Found by orientation: a strip's two ends must run the same way around its normal, and its
    normal must lie on the side of its neighbours' normals; where it is turned over against all of
    them the value is -1.
    """
    ratio = regression(f)
    ratio = np.where(_turned(f), np.minimum(ratio, -1.0), ratio)
    worst_at = np.argmin(ratio, axis=1)
    return tuple(
        Worst(float(ratio[strip, k]), strip, float(f.u[k]))
        for strip, k in enumerate(worst_at)
        if ratio[strip, k] <= 0.0
    )


def _turned(f: Frames) -> BoolArray:
    """Where a strip's normal opposes all its neighbours' (strips, k).

    An end strip's one neighbour must itself agree with the next, else that one is turned.
    """
    before, after = f.at_edges(f.m)
    against = dot(before, after) < 0.0
    if f.closed_i:
        return against & np.roll(against, -1, axis=0)
    turned = np.zeros(f.length.shape, dtype=bool)
    if len(against) == 0:
        return turned
    turned[1:-1] = against[:-1] & against[1:]
    others = against[[1, -2]] if len(against) > 1 else np.zeros_like(against[[0, -1]])
    turned[[0, -1]] = against[[0, -1]] & ~others
    return turned


def measure(
    model: EdgeCurves, surface: Any = None, per_segment: int = 8, samples: int = 4000
) -> Measures:
    """All measures of a model, and its distances to a design surface where one is given.

    Parameters
    ----------
    model : EdgeCurves
    surface : DesignSurface, optional
    per_segment : int
        Parameters a knot span at which everything is measured.
    samples : int
        Points on the surface for its distance to the model.

    Raises
    ------
    InputError
        If one of them is something else.
    GeometryError
        If a ruling or an edge's tangent has no length: nothing can be measured there.
    """
    check_model("measure", model)
    if surface is not None:
        check_surface("measure", surface)
    checked_count("samples", samples, 1, MOST_SAMPLES)
    u = model.parameters(per_segment)
    f = frames(model, u)
    check_lengths("measure", f)
    inner = f.interior
    first, second = bending_radius(model, f)
    radius = np.minimum(np.abs(first), np.abs(second))
    values: dict[str, Any] = {
        "twist_deg": worst(np.degrees(twist(f)), u),
        "developability": worst(developability(f), u),
        "circularity": worst(circularity(f), u),
        "kink_along_deg": kink_along(model),
        "width_min": worst(f.length, u, least=True),
        "width_max": worst(f.length, u),
        "regression": worst(regression(f), u, least=True),
        "radius_min": worst(radius, u, least=True),
        "folds": folds(f),
    }
    for name, value in (
        ("conicality", lambda: conicality(f)),
        ("geodesic", lambda: geodesic(model, f)),
        ("kink_across_deg", lambda: np.degrees(kink_across(f))),
    ):
        values[name] = worst(value(), u, inner) if len(inner) else None
    if surface is not None:
        from fabgeo.strips.distances import distances

        values.update(distances(model, surface, f, samples))
    return Measures(**values)
