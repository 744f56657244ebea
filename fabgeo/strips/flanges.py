"""Axis strips and the strips orthogonal to them: where webs and flanges lie (paper section 3).

Glossary
--------
axis strip N_i
    p_i + s n_i, developable on conical and circular models since n' is parallel to p'.
trajectory
    c = p + s n/|n| with s' = -p' . n/|n|: runs orthogonally to the axes, so that the strip c + v b,
    b = t x n / |t x n|, is developable and orthogonal to N_i. Parallel trajectories keep a constant
    depth between them.
envelope
    The other orthogonal strip: along c = p + d n, the envelope of the planes spanned by t and b;
    its rulings w x w', w = b x t, degenerate where the normal curvature vanishes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.errors import GeometryError
from fabgeo.strips.axes import Axes, Field
from fabgeo.strips.frames import EdgeCurves, around
from fabgeo.strips.integrate import antiderivative

# An envelope's ruling must make at least this angle with the edge tangent.
ENVELOPE_LEAST_DEG = 30.0


@dataclass(frozen=True)
class AxisStrip:
    """The axis strip of one edge, and what follows it.

    Attributes
    ----------
    edge : int
    curve : callable
        (u, derivative) -> p or its derivatives (k, 3).
    normal : callable
        u -> n (k, 3); not of unit length on a conical model.
    segments : int
    """

    edge: int
    curve: Callable[[Array, int], Array]
    normal: Field
    segments: int

    def frame(self, u: Array) -> tuple[Array, Array, Array]:
        """Unit tangent t, unit axis n/|n|, and b = t x n / |t x n|, each (k, 3)."""
        t, n = unit(self.curve(u, 1)), unit(self.normal(u))
        return t, n, unit(cross(t, n))

    def at(self, u: Array, s: Array | float) -> Array:
        """Points p + s n/|n| (k, 3)."""
        return self.curve(u, 0) + np.asarray(s)[..., None] * unit(self.normal(u))

    def offset(self, u: Array, d: float) -> Array:
        """Points p + d n (k, 3) of the offset edge."""
        return self.curve(u, 0) + d * self.normal(u)


def axis_strip(model: EdgeCurves, field: Axes, edge: int) -> AxisStrip:
    """The axis strip of an edge."""
    near, _ = around(model, edge, edge)
    return AxisStrip(edge, lambda u, d: near.points(u, d)[0], field.single(edge), model.segments)


def trajectory(strip: AxisStrip) -> Field:
    """s(u) of the orthogonal trajectory through the edge at u = 0; add a constant for others."""

    def rate(u: Array) -> Array:
        return -dot(strip.curve(u, 1), unit(strip.normal(u)))

    return antiderivative(rate, strip.segments)


def envelope(strip: AxisStrip, distance: float, u: Array, where: str) -> tuple[Array, Array]:
    """Points c = p + d n and rulings r (k, 3) of the envelope strip, scaled so that r . b = 1.

    Raises
    ------
    GeometryError
        Where the ruling comes within 30 degrees of the edge tangent (the normal curvature nearly
        vanishes): the message names the edge and u.
    """
    h = 1e-3
    steps = np.array([-2.0, -1.0, 1.0, 2.0]) * h
    weights = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * h)

    def plane_normal(u: Array) -> Array:
        t, _, b = strip.frame(u)
        return cross(b, t)

    w = plane_normal(u)
    around_u = plane_normal((u[:, None] + steps).ravel()).reshape(len(u), 4, 3)
    dw: Array = np.einsum("kqd,q->kd", around_u, weights)
    _, _, b = strip.frame(u)
    r = cross(w, dw)
    length = np.linalg.norm(r, axis=-1)
    along_b = dot(r, b)
    sine = np.abs(along_b) / np.where(length > 0.0, length, 1.0)
    at = int(np.argmin(sine))
    turns = np.any(along_b > 0.0) and np.any(along_b < 0.0)
    if turns or sine[at] < np.sin(np.radians(ENVELOPE_LEAST_DEG)):
        if turns:
            at = int(np.argmin(np.abs(along_b)))
        raise GeometryError(
            f"{where}: flange by envelope, edge {strip.edge} at u = {u[at]:.3g}",
            "degenerates: the edge's normal curvature vanishes or its rulings turn along the edge",
            "use orthogonal trajectories",
        )
    scaled: Array = r / along_b[:, None]
    return strip.offset(u, distance), scaled
