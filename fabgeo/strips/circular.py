"""Conical and circular models into each other (paper section 2; checked in maths.md).

Glossary
--------
q_i
    Edge curves of the circular model; p_i those of the conical one. q_i lies on the rulings of
    the conical strip i, between p_i and p_{i+1}; p_i is the apex of the cone over the circle of
    the circular strip between q_{i-1} and q_i.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fabgeo import spline
from fabgeo.arrays import Array, cross, dot
from fabgeo.errors import GeometryError
from fabgeo.strips.axes import Axes, circular_normals
from fabgeo.strips.frames import EdgeCurves, frames
from fabgeo.strips.integrate import antiderivative
from fabgeo.strips.model import Kind, StripModel

FINEST = 1.0 / 16.0  # of a knot span: the shortest on which a converted model is interpolated


@dataclass(frozen=True)
class Converted:
    """Edge curves of the converted model: u (k,) -> (edges, k, 3)."""

    curves: Callable[[Array], Array]
    edges: int


def circular_curves(model: EdgeCurves) -> Converted:
    """Edge curves of a circular model on the rulings of a conical one.

    q_i = p_i + s_i e_i with s_i' = -p_i' . e_i, and s_{i+1} = L_i - s_i; the model's one free
    constant keeps the curves near the strips' middles. A conical model of n strips gives n edges.
    """
    signs = (-1.0) ** np.arange(model.strips)  # of s_0 in s_i

    def drift(u: Array) -> Array:
        """s_0' by every strip's own condition, in the mean: a model that is fitted has defects."""
        f = frames(model, u)
        d0, d1 = f.sides(f.dp)
        own, growth = -dot(d0, f.e), dot(d1 - d0, f.e)  # s_i' wanted, L_i'
        plain, wanted = np.zeros(len(u)), []
        for i, sign in enumerate(signs):
            wanted.append(sign * (own[i] - plain))
            plain = growth[i] - plain
        return np.mean(wanted, axis=0)

    walk = antiderivative(drift, model.segments)

    def steps(u: Array, s0: float) -> tuple[Array, Array, Array]:
        f = frames(model, u)
        s = np.empty(f.length.shape)
        s[0] = s0 + walk(u)
        for i in range(1, len(s)):
            s[i] = f.length[i - 1] - s[i - 1]
        return f.p, f.e, s

    u = model.parameters(4)
    length = frames(model, u).length
    _, _, plain = steps(u, 0.0)
    constant = float(np.mean((length / 2.0 - plain) * signs[:, None]))
    _, _, s = steps(u, constant)
    if np.any(s <= 0.0) or np.any(s >= length):
        strip, column = np.argwhere((s <= 0.0) | (s >= length))[0]
        raise GeometryError(
            f"strip {strip} at u = {u[column]:.3g}",
            "the circular model's edge would leave the conical strip there",
            "cut the model shorter along u, or use wider strips",
        )

    def curves(u: Array) -> Array:
        p, e, s = steps(u, constant)
        return p[: len(s)] + s[..., None] * e

    return Converted(curves, model.strips)


def conical_curves(model: EdgeCurves, normals: Axes | None = None) -> Converted:
    """Edge curves of the conical model over a circular one.

    With g = n_i x t_i and r = q_i - q_{i-1}: p_i = q_i + s g, s = -|r|^2 / (2 g . r). A circular
    model of n + 1 edges gives n.
    """
    found = circular_normals(model) if normals is None else normals

    def curves(u: Array) -> Array:
        f = frames(model, u)
        g = cross(found(u), f.t)
        q0, q1 = f.sides(f.p)
        _, g1 = f.sides(g)
        r = q1 - q0
        return q1 + (-dot(r, r) / (2.0 * dot(g1, r)))[..., None] * g1

    return Converted(curves, model.strips)


def to_circular(model: StripModel, tolerance: float = 1e-3) -> StripModel:
    """The circular model on the rulings of a conical one.

    Its edges are no splines: they are interpolated on the model's knots, which are halved until
    the error is within the tolerance (in the model's unit; mm in a project), or a sixteenth of
    what they were. `info["converted"]` says which: the kind it came from, the error between the
    knots, the tolerance, and whether it is within.

    Raises
    ------
    GeometryError
        If an edge would leave its strip.
    """
    return _interpolated(model, circular_curves(model), "circular", tolerance)


def to_conical(model: StripModel, tolerance: float = 1e-3) -> StripModel:
    """The conical model over a circular one, interpolated like that of `to_circular`."""
    return _interpolated(model, conical_curves(model), "conical", tolerance)


def _interpolated(model: StripModel, made: Converted, kind: Kind, tolerance: float) -> StripModel:
    if made.edges < (3 if model.closed_i else 2):
        raise GeometryError(
            f"{model.kind} model of {model.strips} strips",
            "its converted model has one edge less and no strip",
            "convert a model of two strips or more",
        )
    step = 1.0
    while True:
        u = np.arange(model.segments / step + (0 if model.closed_u else 1)) * step
        control = spline.interpolate(made.curves(u), model.closed_u)
        found = StripModel(control, model.closed_u, model.closed_i, kind)
        between = (u[:-1] + u[1:]) / 2.0
        gap = found.points(between / step) - made.curves(between)
        error = float(np.linalg.norm(gap, axis=-1).max())
        if error <= tolerance or step <= FINEST:
            told = {
                "from": model.kind,
                "error": error,
                "tolerance": tolerance,
                "within": error <= tolerance,
            }
            return found.with_control(control, info={"converted": told})
        step /= 2.0
