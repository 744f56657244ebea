"""Largest distance of whole patches from carriers, with a bound for what lies between samples.

Along a fitted ruling, a straight line, the signed distance is a convex function (the inside of a
cylinder or cone is convex; concave where k < 0): it stays below its chord and above its end
tangents, so two rows of samples bound whole rulings. Across the rulings a function differs from
its linear interpolant by at most ``dt^2/8 max|f_tt|``. Here ``f_tt = d'.x_tt + kappa (c.x_t)^2``
is exact at samples, with the distance's only curvature kappa along c, and changes between them no
faster than the third derivatives allow: those of the splines, and those of the distance, at most
3 kappa^2 in any direction and along a carrier's own ruling only kappa over the apex distance.
"""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array, dot
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.samples import Samples


def deviation(samples: Samples, carriers: Carriers, rows: int = 5) -> tuple[Array, Array]:
    """Largest distance found and a bound that no point of the patch exceeds, (p,) each."""
    count = len(samples)
    points = samples.points(np.linspace(0.0, 1.0, rows)).reshape(count, -1, 3)
    found = np.abs(carriers.distance(points)).max(axis=1)
    dt = 1.0 / (len(samples.t) - 1)
    return found, _on_rulings(samples, carriers) + dt**2 / 8.0 * _second(samples, carriers, rows)


def _on_rulings(samples: Samples, carriers: Carriers) -> Array:
    """Bound (p,) of the distance over the sampled rulings, whole."""
    count, s = len(samples), len(samples.t)
    ruling = samples.edges[0, :, :, 1] - samples.edges[0, :, :, 0]
    f, slope = [], []
    for side in (0, 1):
        end = samples.edges[0, :, :, side]
        f.append(carriers.distance(end))
        slope.append(dot(carriers.normal(end), ruling))
    # End tangents f0 + v s0 and f1 - (1 - v) s1 meet at v; convex functions lie above both.
    bulge = slope[1] - slope[0]
    v = np.where(np.abs(bulge) > 1e-300, (f[0] - f[1] + slope[1]) / np.where(bulge, bulge, 1.0), 0)
    tip = f[0] + np.clip(v, 0.0, 1.0) * slope[0]
    return np.abs(np.stack([f[0], f[1], tip])).reshape(3, count, s).max(axis=(0, 2))


def _second(samples: Samples, carriers: Carriers, rows: int) -> Array:
    """Bound (p,) of the distance's second derivative by t over the patch."""
    v = np.linspace(0.0, 1.0, rows)
    count, s = len(samples), len(samples.t)
    x, x_t, x_tt = (samples.points(v, order) for order in range(3))
    flat, shape = x.reshape(count, -1, 3), (count, s, rows)
    kappa, along = (a.reshape(shape + a.shape[2:]) for a in carriers.curvature(flat))
    normal = carriers.normal(flat).reshape(*shape, 3)
    f_tt = dot(normal, x_tt) + kappa * dot(along, x_t) ** 2
    vector, vector_t, vector_tt = samples.edges[:3, :, :, 1] - samples.edges[:3, :, :, 0]
    unit = (vector / np.linalg.norm(vector, axis=-1, keepdims=True))[:, :, None]
    off = np.hypot(dot(unit, normal), dot(unit, along))  # sine to the carrier's own ruling

    def most(array: Array) -> Array:
        return np.abs(array).reshape(count, -1).max(axis=1)

    def norm(array: Array) -> Array:
        return most(np.linalg.norm(array, axis=-1))

    # Bounds over the patch: a value may exceed its samples by what it changes over half a step.
    dt, dv = 1.0 / (s - 1), 1.0 / (rows - 1)
    third = samples.third
    second = norm(x_tt) + dt / 2.0 * third
    first = norm(x_t) + dt / 2.0 * second
    length_tt = norm(vector_tt) + dt * third
    length_t = norm(vector_t) + dt / 2.0 * length_tt
    length = norm(vector) + dt / 2.0 * length_t
    # 1/kappa is a distance times at most one: it changes no faster than the point moves.
    reach = np.hypot(first * dt, length * dv) / 2.0
    top = most(kappa) / np.maximum(1.0 - most(kappa) * reach, 1e-3)
    apex = np.abs(carriers.g) / np.maximum(np.abs(carriers.k), 1e-300) * top  # 1 / apex distance
    off_most = most(off) + dt / 2.0 * (apex * first + length_t / length)
    f_ttt = third + 3.0 * top * second * first + 3.0 * top**2 * first**3
    f_ttv = length_tt * 1.0 + top * (second * length * off_most + 2.0 * length_t * first)
    f_ttv = f_ttv + (3.0 * top**2 * off_most + top * apex) * first**2 * length
    return most(f_tt) + dt / 2.0 * f_ttt + dv / 2.0 * f_ttv
