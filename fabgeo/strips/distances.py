"""Distances between a strip model and a design surface, both ways, and along the boundary."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import KDTree

from fabgeo.arrays import Array, IntArray, dot
from fabgeo.strips.frames import EdgeCurves, Frames, frames, two_sides
from fabgeo.strips.measures import worst
from fabgeo.surfaces.base import DesignSurface

ACROSS = 9  # sample points on a ruling, both ends included
EXACT = 1e-6  # of the surface's size: rulings that sag less are straight on it
OVERHANG = 0.1  # mean rulings beyond the boundary from which a sample is overhang, to be cut off


def distances(model: EdgeCurves, surface: DesignSurface, f: Frames, samples: int) -> dict[str, Any]:
    """The entries of `Measures` that need a design surface.

    The deviation is the distance from the surface along its normal. Where a sample lies beside
    the surface, its distance past the boundary is the overhang instead; what overhangs by more
    than `OVERHANG` is cut off later and counts neither in deviations nor in the sag limit. Where
    rulings lie on the surface, the deviation is compared with `EXACT` of its size in place of it.
    """
    x = _across(f)
    feet = surface.closest(x.reshape(-1, 3))
    apart = x.reshape(-1, 3) - feet.point
    height = dot(apart, feet.normal)
    beside = np.where(
        feet.on_boundary, np.linalg.norm(apart - height[:, None] * feet.normal, axis=-1), 0.0
    )
    deviation = np.where(feet.on_boundary, np.abs(height), np.linalg.norm(apart, axis=-1))
    shape = x.shape[:3]
    deviation, beside = deviation.reshape(shape), beside.reshape(shape)
    e = np.broadcast_to(f.e[:, None], x.shape).reshape(-1, 3)
    kappa = np.abs(feet.normal_curvature(e)).reshape(shape)
    counts = beside <= OVERHANG * f.length.mean()
    if counts.any():
        deviation, kappa = np.where(counts, deviation, 0.0), np.where(counts, kappa, 0.0)
    sag = kappa.max(axis=1) * f.length**2 / 16.0
    limit, most = worst(sag, f.u), worst(deviation.max(axis=1), f.u)
    bound = max(limit.value, EXACT * float(np.linalg.norm(np.ptp(surface.bounds, axis=0))))
    points = surface.sample(samples).point
    back = _back(model, f, x, points)
    return {
        "deviation_max": most,
        "deviation_rms": float(np.sqrt(np.sum(deviation**2) / max(int(counts.sum()), 1))),
        "deviation_count": int(counts.sum()),
        "overhang_max": worst(beside.max(axis=1), f.u),
        "sag_limit": limit,
        "deviation_over_sag_limit": most.value / bound if bound > 0.0 else None,
        "surface_to_model_max": float(back.max()),
        "surface_to_model_rms": float(np.sqrt(np.mean(back**2))),
        "surface_to_model_at": tuple(points[int(np.argmax(back))].tolist()),
        "covered_share": float(np.mean(back <= max(most.value, limit.value))),
        **_boundary(model, f, surface),
    }


def distances_from(model: EdgeCurves, points: Array, per_segment: int = 8) -> Array:
    """Distances (k,) of points (k, 3) from a model, as `distances` takes those of a surface."""
    f = frames(model, model.parameters(per_segment))
    return _back(model, f, _across(f), points)


def _across(f: Frames) -> Array:
    """Points (strips, v, k, 3) on the rulings."""
    v = np.linspace(0.0, 1.0, ACROSS)
    p0, p1 = f.sides(f.p)
    return p0[:, None] + v[:, None, None] * (p1 - p0)[:, None]


def _back(model: EdgeCurves, f: Frames, x: Array, points: Array) -> Array:
    """Distances of points from the model, which has points x on its rulings."""
    strips, across, k = x.shape[:3]
    _, nearest = KDTree(x.reshape(-1, 3)).query(points)
    strip, rest = np.divmod(nearest, across * k)
    row, column = np.divmod(rest, k)
    start = f.u[column]
    found, _, v = project(model, points, strip, start, row / (across - 1.0))
    for end, step in ((0.0, -1), (1.0, 1)):  # feet on an edge: the strip beyond may be nearer
        beyond = strip + step
        beyond = beyond % strips if model.closed_i else beyond
        at = np.flatnonzero((v == end) & (beyond >= 0) & (beyond < strips))
        if len(at):
            other, _, _ = project(model, points[at], beyond[at], start[at], 1.0 - v[at])
            found[at] = np.minimum(found[at], other)
    return found


def project(
    model: EdgeCurves, points: Array, strip: IntArray, u: Array, v: Array
) -> tuple[Array, Array, Array]:
    """Distances of points (k, 3) from given strips, and u, v there, by Gauss-Newton from u, v."""
    rows = np.arange(len(points))

    def strip_points(u: Array, derivative: int) -> tuple[Array, Array]:
        p0, p1 = two_sides(model.points(u, derivative), model.closed_i)
        return p0[strip, rows], p1[strip, rows]

    best, best_u, best_v = np.full(len(points), np.inf), u, v
    for _ in range(6):
        a, b = strip_points(u, 0)
        da, db = strip_points(u, 1)
        x = a + v[:, None] * (b - a)
        apart = points - x
        distance: Array = np.linalg.norm(apart, axis=-1)
        closer = distance < best
        best_u, best_v = np.where(closer, u, best_u), np.where(closer, v, best_v)
        best = np.where(closer, distance, best)
        xu, xv = da + v[:, None] * (db - da), b - a
        g11, g12, g22 = dot(xu, xu), dot(xu, xv), dot(xv, xv)
        r1, r2 = dot(apart, xu), dot(apart, xv)
        det = np.maximum(g11 * g22 - g12**2, 1e-300)
        u = u + np.clip((g22 * r1 - g12 * r2) / det, -0.5, 0.5)
        if not model.closed_u:
            u = np.clip(u, 0.0, model.segments)
        v = np.clip(v + (g11 * r2 - g12 * r1) / det, 0.0, 1.0)
    return best, best_u, best_v


def _boundary(model: EdgeCurves, f: Frames, surface: DesignSurface) -> dict[str, float | None]:
    """Distances between the model's boundary and the surface's, both ways."""
    outline = _outline(model, f)
    if outline is None or not surface.loops:
        return {"boundary_max": None, "boundary_to_model_max": None}
    there = min_distances(outline, surface.loops)
    samples = np.concatenate([_thinned(loop) for loop in surface.loops])
    back = min_distances(samples, _outline_loops(model, f))
    return {"boundary_max": float(there.max()), "boundary_to_model_max": float(back.max())}


def _outline(model: EdgeCurves, f: Frames) -> Array | None:
    loops = _outline_loops(model, f)
    return np.concatenate(loops) if loops else None


def _outline_loops(model: EdgeCurves, f: Frames) -> list[Array]:
    """The model's free boundary as open polylines: end rulings and outer edges."""
    out = []
    if not model.closed_i:
        out += [f.p[0], f.p[-1]]
        if model.closed_u:
            out = [np.concatenate([line, line[:1]]) for line in out]
    if not model.closed_u:
        ends = [f.p[:, 0], f.p[:, -1]]
        if model.closed_i:
            ends = [np.concatenate([line, line[:1]]) for line in ends]
        out += [_dense(line) for line in ends]
    return out


def _dense(polygon: Array, pieces: int = 8) -> Array:
    s = np.arange(pieces) / pieces
    inner = polygon[:-1, None] + s[:, None] * np.diff(polygon, axis=0)[:, None]
    return np.concatenate([inner.reshape(-1, 3), polygon[-1:]])


def _thinned(loop: Array, most: int = 2000) -> Array:
    return loop[:: max(1, len(loop) // most)]


def min_distances(points: Array, polylines: list[Array] | tuple[Array, ...]) -> Array:
    """Distances of points (k, 3) from polylines: nearest vertices' adjacent segments."""
    start = np.concatenate([line[:-1] for line in polylines])
    step = np.concatenate([np.diff(line, axis=0) for line in polylines])
    nearest = 8 if len(start) >= 8 else len(start)
    _, index = KDTree(start + step / 2.0).query(points, k=nearest)
    index = np.asarray(index).reshape(len(points), nearest)
    a, d = start[index], step[index]
    s = dot(points[:, None] - a, d) / np.maximum(dot(d, d), 1e-300)
    foot = a + np.clip(s, 0.0, 1.0)[..., None] * d
    return np.linalg.norm(points[:, None] - foot, axis=-1).min(axis=1)
