"""Surfaces of a STEP text as functions, by textbook formulas: no kernel.

Glossary
--------
surface
    Gives points and both derivatives at parameters (k, 2), and the parameters of given points.
moment
    ``H(u, v) = integral from v0 to v of (x - c) . (x_u x x_v) dv``: three times the volume between
    the surface and a point c is minus the integral of H du around a face's boundary (Green).

Source: ISO 10303-42 for the meaning of each entity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from fabgeo.arrays import Array, cross, dot
from fabgeo.cad.part21 import Entities
from fabgeo.cad.textcurves import bases, frame_of, point_of
from fabgeo.errors import InputError

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


class Surface(Protocol):
    """A surface in space."""

    def at(self, uv: Array) -> tuple[Array, Array, Array]:
        """Points and derivatives by u and v, each (k, 3)."""
        ...

    def parameters(self, points: Array) -> Array:
        """Parameters (k, 2) of the nearest points."""
        ...

    def moment(self, uv: Array, about: Array) -> Array:
        """H (k,), see the module."""
        ...


@dataclass(frozen=True)
class Plane:
    """``x = origin + u x + v y``."""

    frame: Array

    def at(self, uv: Array) -> tuple[Array, Array, Array]:
        """Points and derivatives."""
        x, y, origin = self.frame[:3, 0], self.frame[:3, 1], self.frame[:3, 3]
        shape = (len(uv), 3)
        return (
            origin + uv @ self.frame[:3, :2].T,
            np.broadcast_to(x, shape),
            np.broadcast_to(y, shape),
        )

    def parameters(self, points: Array) -> Array:
        """Parameters of the feet."""
        return (points - self.frame[:3, 3]) @ self.frame[:3, :2]

    def moment(self, uv: Array, about: Array) -> Array:
        """H: the distance of `about` times v."""
        return uv[:, 1] * float((self.frame[:3, 3] - about) @ self.frame[:3, 2])


@dataclass(frozen=True)
class Cone:
    """``x = origin + (r + v tan a) (cos u x + sin u y) + v z`` with the half angle a (radians).

    A cylinder has a = 0; `slope` is tan a.
    """

    frame: Array
    radius: float
    slope: float

    def at(self, uv: Array) -> tuple[Array, Array, Array]:
        """Points and derivatives."""
        x, y, z, origin = (self.frame[:3, k] for k in range(4))
        c, s = np.cos(uv[:, :1]), np.sin(uv[:, :1])
        out, round_ = c * x + s * y, c * y - s * x
        r = self.radius + self.slope * uv[:, 1:]
        return origin + r * out + uv[:, 1:] * z, r * round_, self.slope * out + z

    def parameters(self, points: Array) -> Array:
        """Angle, and the height of the foot on the generating line."""
        local = (points - self.frame[:3, 3]) @ self.frame[:3, :3]
        off = np.hypot(local[:, 0], local[:, 1]) - self.radius
        v = (local[:, 2] + self.slope * off) / (1.0 + self.slope**2)
        return np.stack([np.arctan2(local[:, 1], local[:, 0]), v], axis=1)

    def moment(self, uv: Array, about: Array) -> Array:
        """H from v = 0, by Gauss (the integrand is a polynomial in v)."""
        return gauss_moment(self, uv, about, np.zeros(1))


@dataclass(frozen=True)
class SplineSurface:
    """A B-spline surface, rational where its weights differ; poles (m, n, 3)."""

    degrees: tuple[int, int]
    knots: tuple[Array, Array]
    poles: Array
    weights: Array

    def at(self, uv: Array) -> tuple[Array, Array, Array]:
        """Points and derivatives."""
        bu, du = (bases(self.knots[0], self.degrees[0], uv[:, 0], d) for d in (0, 1))
        bv, dv = (bases(self.knots[1], self.degrees[1], uv[:, 1], d) for d in (0, 1))
        weighted = np.concatenate(
            [self.poles * self.weights[..., None], self.weights[..., None]], 2
        )
        over_v = [np.einsum("kn,mnd->kmd", b, weighted) for b in (bv, dv)]
        h = np.einsum("km,kmd->kd", bu, over_v[0])
        hu = np.einsum("km,kmd->kd", du, over_v[0])
        hv = np.einsum("km,kmd->kd", bu, over_v[1])
        w = h[:, 3:]
        x = h[:, :3] / w
        return x, (hu[:, :3] - hu[:, 3:] * x) / w, (hv[:, :3] - hv[:, 3:] * x) / w

    def parameters(self, points: Array) -> Array:
        """Parameters of the feet: nearest of a grid, then Gauss-Newton within the range."""
        low = np.array([k[0] for k in self.knots])
        high = np.array([k[-1] for k in self.knots])
        axes = [
            np.linspace(a, b, 1 + max(2, 3 * (len(np.unique(k)) - 1)))
            for a, b, k in zip(low, high, self.knots, strict=True)
        ]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 2)
        nodes, _, _ = self.at(grid)
        square = (nodes**2).sum(axis=1) - 2.0 * points @ nodes.T
        uv = grid[np.argmin(square, axis=1)]
        for _ in range(40):
            x, xu, xv = self.at(uv)
            gap = points - x
            a, b, c = dot(xu, xu), dot(xu, xv), dot(xv, xv)
            f, g = dot(gap, xu), dot(gap, xv)
            det = np.maximum(a * c - b * b, 1e-300)
            step = np.stack([(c * f - b * g) / det, (a * g - b * f) / det], axis=1)
            new = np.clip(uv + step, low, high)
            change = np.abs((new - uv) / (high - low)).max()
            uv = new
            if change < 1e-12:
                break
        return uv

    def moment(self, uv: Array, about: Array) -> Array:
        """H from the first v, by Gauss over each knot span."""
        return gauss_moment(self, uv, about, np.unique(self.knots[1])[:-1])


def gauss_moment(surface: Surface, uv: Array, about: Array, spans: Array) -> Array:
    """H with v0 = spans[0], integrated span by span (the last one open)."""
    total = np.zeros(len(uv))
    tops = np.append(spans[1:], np.inf)
    for low, high in zip(spans.tolist(), tops.tolist(), strict=True):
        end = np.clip(uv[:, 1], low, high) if np.isfinite(high) or len(spans) > 1 else uv[:, 1]
        half = (end - low) / 2.0
        v = low + half[:, None] * (_NODES + 1.0)
        u = np.broadcast_to(uv[:, :1], v.shape)
        x, xu, xv = surface.at(np.stack([u, v], -1).reshape(-1, 2))
        density = dot(x - about, cross(xu, xv)).reshape(v.shape)
        total += (density @ _WEIGHTS) * half
    return total


def surface_of(file: Entities, number: int) -> Surface:
    """The surface of an entity; raises like `curve_of`."""
    parts = file.parts(number)
    kind, a = next(iter(parts.items()))
    if kind == "PLANE":
        return Plane(frame_of(file, a[1]))
    if kind == "CYLINDRICAL_SURFACE":
        return Cone(frame_of(file, a[1]), a[2], 0.0)
    if kind == "CONICAL_SURFACE":
        return Cone(frame_of(file, a[1]), a[2], float(np.tan(a[3])))
    if "B_SPLINE_SURFACE_WITH_KNOTS" in parts:
        return _spline_surface(file, parts)
    raise InputError(f"{file.where}, #{number}", f"is a {file.kind(number)}, which is not known")


def _spline_surface(file: Entities, parts: dict[str, list[Any]]) -> SplineSurface:
    own = parts["B_SPLINE_SURFACE_WITH_KNOTS"]
    head = parts["B_SPLINE_SURFACE"] if "B_SPLINE_SURFACE" in parts else own[1:]
    poles = np.array([[point_of(file, p) for p in row] for row in head[2]])
    weights = parts.get("RATIONAL_B_SPLINE_SURFACE", [np.ones(poles.shape[:2])])[0]
    knots = (
        np.repeat(np.array(own[-3], dtype=float), own[-5]),
        np.repeat(np.array(own[-2], dtype=float), own[-4]),
    )
    return SplineSurface((head[0], head[1]), knots, poles, np.array(weights, dtype=np.float64))
