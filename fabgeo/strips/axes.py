"""Cone axes of conical models and vertex normals of circular ones (paper section 2).

Glossary
--------
axis n_i(u)
    Direction of the cone that touches both strips along their rulings at p_i(u), scaled so that
    n . m = 1 for both strips: the offset p + d n has rulings and planes at distance d.
lean a
    n = m + a e: how far the axis leans along the ruling.
mismatch
    |(m+ + a e+) - (m- + a e-)|: zero if and only if the edge is conical there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.errors import GeometryError
from fabgeo.strips.frames import (
    EdgeCurves,
    Frames,
    around,
    check_lengths,
    frames,
    normal_change,
)
from fabgeo.strips.integrate import antiderivative

type Field = Callable[[Array], Array]


@dataclass(frozen=True)
class Axes:
    """Normals that a model's offsets and beams follow, as functions of u.

    Attributes
    ----------
    kind : str
        "conical" (n . m = 1, constant distance of rulings and planes) or "circular" (|n| = 1,
        constant distance of vertices).
    normals : callable
        u (k,) -> (edges, k, 3).
    single : callable
        Edge index -> the normal of that edge alone, u (k,) -> (k, 3).
    mismatch : float
        Largest disagreement of the two strips at an edge about n; 0 for an exact model.
    """

    kind: str
    normals: Field
    single: Callable[[int], Field]
    mismatch: float

    def __call__(self, u: Array) -> Array:
        """Normals (edges, k, 3) at u (k,)."""
        return self.normals(np.atleast_1d(np.asarray(u, dtype=np.float64)))


def lean(f: Frames) -> tuple[Array, Array]:
    """Lean a (edges, k) of the axis at every edge, and the mismatch there.

    a = (m+ - m-) . (e- - e+) / |e- - e+|^2; zero at the first and last edge of an open model.
    """
    m_minus, m_plus = f.at_edges(f.m)
    back, e_plus = f.at_edges(f.e)
    apart = -back - e_plus  # e- - e+
    a = np.zeros(f.p.shape[:2])
    mismatch = np.zeros(f.p.shape[:2])
    if len(f.interior):
        inner = dot(m_plus - m_minus, apart) / dot(apart, apart)
        rows = np.fromiter(f.interior, dtype=np.int64)
        a[rows] = inner
        gap = m_plus - m_minus - inner[..., None] * apart
        mismatch[rows] = np.linalg.norm(gap, axis=-1)
    return a, mismatch


def conical_axes(model: EdgeCurves) -> Axes:
    """Cone axes of a conical model (checked in maths.md, 'Cone axis').

    At an interior edge n = (m+ + m-)/2 + a (e+ + e-)/2. At the first and the last edge there is
    one strip: there the lean solves a' = (p'.e / p'.f) (m'.f + a e'.f), f = m x e, which is the
    condition that n' is parallel to p' (so that the axis strip is developable); its one free
    constant is chosen so that the axis mirrors that of the neighbouring edge.
    """
    ends = {} if model.closed_i else {s: _end_axis(model, s) for s in (0, -1)}

    def inner(f: Frames) -> Array:
        a, _ = lean(f)
        m_minus, m_plus = f.at_edges(f.m)
        back, e_plus = f.at_edges(f.e)
        a = a[np.fromiter(f.interior, dtype=np.int64)]
        return (m_plus + m_minus + a[..., None] * (e_plus - back)) / 2.0

    def normals(u: Array) -> Array:
        f = frames(model, u)
        n = np.empty_like(f.p)
        if len(f.interior):
            n[np.fromiter(f.interior, dtype=np.int64)] = inner(f)
        for side, field in ends.items():
            n[side] = field(u)
        return n

    def single(i: int) -> Field:
        if not model.closed_i and i % model.edges in (0, model.edges - 1):
            return ends[0 if i % model.edges == 0 else -1]
        near, _ = around(model, i - 1, i + 1)
        return lambda u: inner(frames(near, u))[0]

    _, mismatch = lean(frames(model, model.parameters(8)))
    return Axes("conical", normals, single, float(mismatch.max()))


def _end_axis(model: EdgeCurves, side: int) -> Field:
    """Axis at the first (side 0) or last (side -1) edge of an open model, u (k,) -> (k, 3)."""
    last = model.edges - 1
    near = around(model, 0, 2)[0] if side == 0 else around(model, last - 2, last)[0]

    def rates(u: Array) -> Array:
        f = frames(near, u)
        change = normal_change(near, f)
        dm = (change.m_first if side == 0 else change.m_second)[side]
        e, m, dp = f.e[side], f.m[side], f.dp[side]
        across = cross(m, e)
        slope = dot(dp, e) / dot(dp, across)
        return slope * np.stack([dot(dm, across), dot(change.e[side], across)])

    growth = antiderivative(lambda u: rates(u)[1], model.segments)
    source = antiderivative(lambda u: rates(u)[0] * np.exp(-growth(u)), model.segments)
    u = model.parameters(4)
    f = frames(near, u)
    target = np.zeros(len(u))
    if f.interior:  # the mirrored axis of the strip's other edge: n = m + a e-, e- pointing back
        target = lean(f)[0][1] if side == 0 else -lean(f)[0][-2]
    weight, free = np.exp(growth(u)), source(u)
    constant = float(dot(target - weight * free, weight) / dot(weight, weight))
    if model.closed_u:
        end = np.array([float(model.segments)])
        factor = float(np.exp(growth(end))[0])
        if abs(1.0 - factor) > 1e-6:  # the one solution that closes
            constant = factor * float(source(end)[0]) / (1.0 - factor)

    def axis(u: Array) -> Array:
        f = frames(near, u)
        a = np.exp(growth(u)) * (constant + source(u))
        return f.m[side] + a[:, None] * f.e[side]

    return axis


def circular_normals(model: EdgeCurves) -> Axes:
    """Unit normals of a circular model: rotation-minimising along edges, mirrored across strips.

    With g = unit(p' x x), x a smooth field across the edge, n = cos(phi) g + sin(phi) (t x g) has
    n' parallel to p' if and only if phi' = -g' . (t x g). The one free angle of the model is
    chosen so that n leans as little as possible from the strips' normals.
    """
    middle = model.edges // 2
    below = middle - 1 if middle > 0 else middle
    above = (middle + 1) % model.edges if model.closed_i else min(middle + 1, model.edges - 1)

    def reference(u: Array) -> tuple[Array, Array, Array]:
        p, dp, ddp = (model.points(u, k) for k in range(3))
        x, dx = p[above] - p[below], dp[above] - dp[below]
        w = cross(dp[middle], x)
        dw = cross(ddp[middle], x) + cross(dp[middle], dx)
        g = unit(w)
        side = cross(unit(dp[middle]), g)
        return g, side, -dot(dw, side) / np.linalg.norm(w, axis=-1)

    turn = antiderivative(lambda u: reference(u)[2], model.segments)

    def raw(u: Array, phi0: float) -> Array:
        g, side, _ = reference(u)
        phi = turn(u) + phi0
        n = np.empty((model.edges, len(u), 3))
        n[middle] = np.cos(phi)[:, None] * g + np.sin(phi)[:, None] * side
        f = frames(model, u)
        for i in range(middle, model.edges - 1):
            n[i + 1] = mirrored(n[i], f.e[i])
        for i in range(middle, 0, -1):
            n[i - 1] = mirrored(n[i], f.e[i - 1])
        return n

    u = model.parameters(4)
    c, s = raw(u, 0.0), raw(u, np.pi / 2.0)
    f = frames(model, u)
    vertex = _vertex_normals(f)
    phi0 = float(np.arctan2(dot(s, vertex).sum(), dot(c, vertex).sum()))
    n = raw(u, phi0)
    off = np.abs(dot(n, f.t)).max()
    if model.closed_i:
        off = max(off, float(np.abs(mirrored(n[-1], f.e[-1]) - n[0]).max()))
    if model.closed_u:
        ends = raw(np.array([0.0, float(model.segments)]), phi0)
        off = max(off, float(np.abs(ends[:, 1] - ends[:, 0]).max()))

    def single(i: int) -> Field:
        return lambda u: raw(u, phi0)[i]

    return Axes("circular", lambda u: raw(u, phi0), single, float(off))


def mirrored(n: Array, e: Array) -> Array:
    """Normals carried across a strip: n - 2 (n . e) e."""
    return n - 2.0 * dot(n, e)[..., None] * e


def _vertex_normals(f: Frames) -> Array:
    """Mean of the adjacent strips' normals at every edge (edges, k, 3)."""
    total = np.zeros_like(f.p)
    if f.closed_i:
        return unit(f.m + np.roll(f.m, 1, axis=0))
    total[:-1] += f.m
    total[1:] += f.m
    return unit(total)


# Two strips may disagree about an axis by this much (radians) before offsets are refused.
MISMATCH_LIMIT = 2e-3


def axes(model: EdgeCurves) -> Axes:
    """The normals that the model's kind admits: cone axes, else circular normals.

    What counts is the measured property, not the label: a general model that happens to be
    conical (cylinder strips, surfaces of revolution) is served too.

    Raises
    ------
    GeometryError
        If the model is neither conical nor circular, or a strip has no normal somewhere.
    """
    check_lengths("strip model", frames(model, model.parameters(4)))
    kind = getattr(model, "kind", "general")
    makers = [conical_axes, circular_normals]
    if kind == "circular":
        makers.reverse()
    found = []
    for make in makers:
        made = make(model)
        if made.mismatch <= MISMATCH_LIMIT:
            return made
        found.append(f"{made.kind} {made.mismatch:.2g} rad")
    raise GeometryError(
        f"{kind} strip model",
        "offsets, cells and beams need a conical or a circular model; the strips disagree about "
        f"their common axis by {', '.join(found)} (limit {MISMATCH_LIMIT:g})",
        "divide the surface, or ask for panels only"
        if kind in ("conical", "circular")
        else 'fit the model with kind = "conical", or ask for panels only',
    )
