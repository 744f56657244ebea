"""Exact strip models in closed form: what formulas are verified on.

Each is evaluated exactly for any u; derivatives are eighth-order central differences of the closed
form (relative error about 1e-12). `interpolant` gives the cubic spline model through its points,
which approaches the exact one with the fourth power of the knot spacing.

Glossary
--------
moulding surface
    Swept by a profile whose plane rolls along a base curve: its curves of equal profile point are
    parallel curves, so all edge tangents at one u are parallel. Circular and conical.
support function h
    Plane base curve h N + h' T, N = (cos psi, sin psi), T = N'; its speed is h + h''.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fabgeo import spline
from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.errors import InputError
from fabgeo.strips.model import Kind, StripModel

_STEP = 0.02
_OFFSETS = np.array([-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0])
_STENCILS = (
    np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]) / _STEP,
    np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
    / _STEP**2,
)


@dataclass(frozen=True)
class ExactModel:
    """Edge curves given by a function of u.

    Attributes
    ----------
    curves : callable
        u (k,) -> points (edges, k, 3), analytic also a little beyond [0, segments].
    edges, segments : int
    closed_u, closed_i : bool
    kind : str
    name : str
    """

    curves: Callable[[Array], Array]
    edges: int
    segments: int
    closed_u: bool = False
    closed_i: bool = False
    kind: Kind = "general"
    name: str = "exact"

    @property
    def strips(self) -> int:
        """Number of strips."""
        return self.edges if self.closed_i else self.edges - 1

    def points(self, u: Array, derivative: int = 0) -> Array:
        """Points or u-derivatives (edges, k, 3), derivative 0 to 2."""
        u = np.atleast_1d(np.asarray(u, dtype=np.float64))
        if derivative == 0:
            return self.curves(u)
        if derivative > 2:
            raise InputError(self.name, f"has derivatives up to 2, asked for {derivative}")
        near = self.curves((u[:, None] + _STEP * _OFFSETS).ravel())
        near = near.reshape(self.edges, len(u), len(_OFFSETS), 3)
        return np.einsum("ikqd,q->ikd", near, _STENCILS[derivative - 1])

    def parameters(self, per_segment: int = 4) -> Array:
        """Evenly spaced parameters, `per_segment` to a unit of u."""
        u = np.linspace(0.0, self.segments, self.segments * per_segment + 1)
        return u[:-1] if self.closed_u else u

    def interpolant(self, refine: int = 1) -> StripModel:
        """The cubic spline model through the points at u = 0, 1/refine, 2/refine, ..."""
        count = self.segments * refine
        u = np.arange(count + (0 if self.closed_u else 1)) / refine
        control = spline.interpolate(self.curves(u), self.closed_u)
        return StripModel(
            control, self.closed_u, self.closed_i, self.kind, {"start": {"method": self.name}}
        )


def cylinder(radius: float, height: float, angles: Array, segments: int = 6) -> ExactModel:
    """Edges on a circular cylinder: generators are the edges, strips are plane."""
    circle = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))], axis=-1) * radius
    axis = np.array([0.0, 0.0, height])

    def curves(u: Array) -> Array:
        return circle[:, None] + (u / segments)[:, None] * axis

    return ExactModel(curves, len(angles), segments, kind="conical", name="cylinder")


def cone(
    half_angle: float, distances: Array, opening: float = 1.2, segments: int = 12
) -> ExactModel:
    """Circles on a right circular cone at given distances from its apex; rulings its generators."""
    r, z = np.asarray(distances) * np.sin(half_angle), np.asarray(distances) * np.cos(half_angle)
    return revolution(r, z, opening, segments)


def revolution(
    radii: Array, heights: Array, opening: float = 1.2, segments: int = 12
) -> ExactModel:
    """Parallel circles of a surface of revolution: strips are cones. Conical and circular."""
    radii, heights = np.asarray(radii, dtype=np.float64), np.asarray(heights, dtype=np.float64)
    whole = abs(opening - 2.0 * np.pi) < 1e-12

    def curves(u: Array) -> Array:
        angle = opening * u / segments
        ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(len(u))], axis=-1)
        return radii[:, None, None] * ring + heights[:, None, None] * np.array([0.0, 0.0, 1.0])

    return ExactModel(
        curves, len(radii), segments, closed_u=whole, kind="conical", name="revolution"
    )


def meridians(
    radius: float, tube: float, angles: Array, low: float, high: float, segments: int = 12
) -> ExactModel:
    """Meridians of a torus (radius of its middle circle, of its tube): strips are cylinders."""

    def curves(u: Array) -> Array:
        psi = low + (high - low) * u / segments
        r = radius + tube * np.cos(psi)
        flat = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))], axis=-1)
        up = np.array([0.0, 0.0, tube])
        return flat[:, None] * r[:, None] + np.sin(psi)[:, None] * up

    return ExactModel(curves, len(angles), segments, kind="conical", name="meridians")


def moulding(
    radius: float,
    wave: float,
    profile: Array,
    opening: float = 1.2,
    segments: int = 12,
    frequency: float = 2.0,
) -> ExactModel:
    """A moulding surface over the base curve with support function radius + wave cos(f psi).

    Parameters
    ----------
    profile : (edges, 2) array
        Profile points: along N and upwards.
    """
    profile = np.asarray(profile, dtype=np.float64)

    def curves(u: Array) -> Array:
        psi = opening * (u / segments - 0.5)
        h = radius + wave * np.cos(frequency * psi)
        dh = -wave * frequency * np.sin(frequency * psi)
        n = np.stack([np.cos(psi), np.sin(psi), np.zeros(len(u))], axis=-1)
        t = np.stack([-np.sin(psi), np.cos(psi), np.zeros(len(u))], axis=-1)
        base = h[:, None] * n + dh[:, None] * t
        up = np.array([0.0, 0.0, 1.0])
        return base + profile[:, :1, None] * n + profile[:, 1:, None] * up

    return ExactModel(curves, len(profile), segments, kind="conical", name="moulding")


def inverted(model: ExactModel, centre: Array, radius: float) -> ExactModel:
    """The image under the inversion in a sphere: circular models stay circular (Moebius)."""
    centre = np.asarray(centre, dtype=np.float64)

    def curves(u: Array) -> Array:
        x = model.curves(u) - centre
        return centre + radius**2 * x / dot(x, x)[..., None]

    return ExactModel(
        curves, model.edges, model.segments, model.closed_u, model.closed_i, "circular",
        f"inverted {model.name}",
    )  # fmt: skip


def dupin_cyclide(edges: int = 9, segments: int = 12) -> ExactModel:
    """Curvature lines of a Dupin cyclide: an inverted torus, in millimetres of about 10 m."""
    angles = np.linspace(0.0, 1.2, edges)
    torus = meridians(9000.0, 4000.0, angles, -0.7, 0.8, segments)
    made = inverted(torus, np.array([-9000.0, 3000.0, 5000.0]), 18000.0)
    return ExactModel(made.curves, edges, segments, kind="circular", name="dupin cyclide")


def tangent_developable(
    pitch: float, radius: float, length: float, width: float, segments: int = 12
) -> ExactModel:
    """One strip of the tangent surface of a helix, between `length` and `length + width`."""
    speed = float(np.hypot(radius, pitch))

    def curves(u: Array) -> Array:
        a = 1.5 * u / segments
        c = np.stack([radius * np.cos(a), radius * np.sin(a), pitch * a], axis=-1)
        t = np.stack([-radius * np.sin(a), radius * np.cos(a), np.full(len(u), pitch)], axis=-1)
        return np.stack([c + s / speed * t for s in (length, length + width)])

    return ExactModel(curves, 2, segments, name="tangent developable")


def spherical_geodesics(radius: float, width: float, edges: int, segments: int = 12) -> ExactModel:
    """Great circles of a sphere through two poles: a geodesic model of cylinder strips."""
    angles = width / radius * (np.arange(edges, dtype=np.float64) - (edges - 1) / 2.0)
    made = meridians(0.0, radius, angles, -0.9, 0.9, segments)
    return ExactModel(made.curves, edges, segments, kind="geodesic", name="great circles")


def strip_normals(model: ExactModel, u: Array) -> Array:
    """Unit normals of the strips (strips, k, 3) of an open exact model, from both end tangents."""
    p, t = model.points(u), unit(model.points(u, 1))
    return unit(cross(t[:-1] + t[1:], p[1:] - p[:-1]))
