"""Prisms in closed form: nets on surfaces of revolution, whose conical offsets are exact."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import make_interp_spline

from fabgeo.spline import clamped_knots, greville
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Hole, Plate, Prism

PROFILE = (np.array([5000.0, 5100.0, 5400.0, 5300.0]), np.array([0.0, 1500.0, 1400.0, -100.0]))


def circles(radii, heights, start=0.1, end=0.4, spans=2):
    """Knots and cubics (N, k, 3) through arcs about z at Greville points."""
    knots = clamped_knots(start, end, spans)
    g = greville(knots)
    ring = np.stack([np.cos(g), np.sin(g), np.ones_like(g)], axis=1)
    points = np.stack([ring * [r, r, h] for r, h in zip(radii, heights, strict=True)])
    return knots, np.array([make_interp_spline(g, p, k=3, t=knots).c for p in points])


def revolution(mark="C-00-00", profile=PROFILE, start=0.1, end=0.4, spans=2) -> Prism:
    knots, poles = circles(*profile, start, end, spans)
    return Prism(mark, knots, poles)


def revolution_volume(profile=PROFILE, angle=0.3) -> float:
    """Guldin: area of the profile times the path of its centroid (exact circles)."""
    r, z = profile
    q, w = np.roll(r, -1), np.roll(z, -1)
    cross = r * w - q * z
    return abs(angle * np.sum((r + q) * cross) / 6.0)


def quadrature_volume(prism: Prism) -> float:
    """Volume by the divergence theorem over ruled faces and end polygons, by Gauss."""
    from scipy.interpolate import BSpline

    nodes, weights = np.polynomial.legendre.leggauss(6)
    spans = np.unique(prism.knots)
    half = np.diff(spans)[:, None] / 2
    u = (spans[:-1, None] + half * (nodes + 1)).ravel()
    du = (half * weights).ravel()
    curve = BSpline(prism.knots, np.moveaxis(prism.poles, 1, 0), 3)
    c, d = np.asarray(curve(u)), np.asarray(curve(u, 1))
    o = c.mean(axis=(0, 1))
    total = 0.0
    for j in range(len(prism.poles)):
        k = (j + 1) % len(prism.poles)
        for s, ds in zip((nodes + 1) / 2, weights / 2, strict=True):
            x = (1 - s) * c[:, j] + s * c[:, k] - o
            xu = (1 - s) * d[:, j] + s * d[:, k]
            total += ds * np.sum(np.einsum("kd,kd->k", x, np.cross(xu, c[:, k] - c[:, j])) * du)
    for ring, sign in ((prism.poles[:, 0] - o, 1.0), (prism.poles[:, -1] - o, -1.0)):
        if len(ring) == 4:  # bilinear patch, exact by 2 x 2 Gauss
            g = np.array([-1, 1]) / np.sqrt(3) / 2 + 0.5
            for a in g:
                for b in g:
                    xa = (1 - b) * (ring[1] - ring[0]) + b * (ring[2] - ring[3])
                    xb = (1 - a) * (ring[3] - ring[0]) + a * (ring[2] - ring[1])
                    x = (1 - a) * (1 - b) * ring[0] + a * (1 - b) * ring[1]
                    x = x + a * b * ring[2] + (1 - a) * b * ring[3]
                    total += sign * 0.25 * (x @ np.cross(xa, xb))
        else:
            tri = np.cross(ring[1:-1] - ring[0], ring[2:] - ring[0]).sum(axis=0) / 2
            total += sign * (ring[0] @ tri)
    return abs(total) / 3.0


def plate(mark="P-00-00", holes=(), thickness=8.0, profile=PROFILE, spans=2) -> Plate:
    knots, poles = circles(profile[0][:2], profile[1][:2], spans=spans)
    return Plate(
        mark, mark, "panel", RuledPatch(knots, poles), thickness, "steel", holes=tuple(holes)
    )


def square_hole(mid: RuledPatch, u: float, v: float, diameter=20.0, slot=0.0) -> Hole:
    """A hole whose axis is the plate's normal there."""
    a, b = mid.edges(np.array([u]))
    da, _ = mid.edges(np.array([u]), 1)
    normal = np.cross(da[0], b[0] - a[0])
    normal = normal / np.linalg.norm(normal)
    along = (b[0] - a[0]) / np.linalg.norm(b[0] - a[0])
    return Hole(mid.points(np.array([u]), np.array([v]))[0], normal, diameter, slot, along)
