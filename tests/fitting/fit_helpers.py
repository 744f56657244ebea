"""Small surfaces in closed form and iso-parameter starts on them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fabgeo import spline
from fabgeo.arrays import Array, unit
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import SurfacePoints


@dataclass
class Graph:
    """z = f(x, y) over a rectangle, with its gradient and second derivatives."""

    f: Callable[[Array, Array], Array]
    gradient: Callable[[Array, Array], tuple[Array, Array]]
    second: Callable[[Array, Array], tuple[Array, Array, Array]]
    half: tuple[float, float] = (5000.0, 5000.0)
    name: str = "graph"

    @property
    def bounds(self) -> Array:
        p = self.sample(400).point
        return np.array([p.min(0), p.max(0)])

    @property
    def loops(self) -> tuple[Array, ...]:
        a, b = self.half
        t = np.linspace(-1.0, 1.0, 401)[:-1]
        o = np.ones_like(t)
        x = np.concatenate([a * t, a * o, -a * t, -a * o])
        y = np.concatenate([-b * o, b * t, b * o, -b * t])
        return (self.lift(x, y),)

    def lift(self, x: Array, y: Array) -> Array:
        return np.stack([x, y, self.f(x, y)], axis=-1)

    def closest(self, points: Array) -> SurfacePoints:
        q = np.array(points[:, :2], dtype=float)
        for _ in range(40):
            x, y = q.T
            z = self.f(x, y) - points[:, 2]
            fx, fy = self.gradient(x, y)
            fxx, fxy, fyy = self.second(x, y)
            gx, gy = x - points[:, 0] + z * fx, y - points[:, 1] + z * fy
            a, b, c = 1 + fx * fx + z * fxx, fx * fy + z * fxy, 1 + fy * fy + z * fyy
            det = a * c - b * b
            step = np.stack([(c * gx - b * gy) / det, (a * gy - b * gx) / det], axis=-1)
            q -= step
            if np.abs(step).max() < 1e-9:
                break
        return self.at(q[:, 0], q[:, 1])

    def at(self, x: Array, y: Array) -> SurfacePoints:
        fx, fy = self.gradient(x, y)
        fxx, fxy, fyy = self.second(x, y)
        w = np.sqrt(1 + fx * fx + fy * fy)
        n = np.stack([-fx, -fy, np.ones_like(fx)], axis=-1) / w[:, None]
        # S = P H P / w with H the Hessian of z - f in space, P the tangential projection.
        h = np.zeros((len(x), 3, 3))
        h[:, 0, 0], h[:, 1, 1] = fxx, fyy
        h[:, 0, 1] = h[:, 1, 0] = fxy
        p = np.eye(3) - n[:, :, None] * n[:, None, :]
        return SurfacePoints(
            self.lift(x, y), n, p @ h @ p / w[:, None, None], np.zeros(len(x), bool)
        )

    def sample(self, count: int) -> SurfacePoints:
        k = max(int(np.sqrt(count)), 2)
        x, y = np.meshgrid(
            np.linspace(-1, 1, k) * self.half[0], np.linspace(-1, 1, k) * self.half[1]
        )
        return self.at(x.ravel(), y.ravel())


def quadric(a: float, b: float, half: tuple[float, float] = (5000.0, 5000.0)) -> Graph:
    """z = (a x^2 + b y^2) / 2."""
    return Graph(
        lambda x, y: (a * x * x + b * y * y) / 2,
        lambda x, y: (a * x, b * y),
        lambda x, y: (a + 0 * x, 0 * x, b + 0 * x),
        half,
    )


def iso_start(surface: Graph, strips: int, segments: int, swap: bool = False) -> StripModel:
    """Edges y = const (x = const if swapped) at even spacing over the rectangle."""
    s, t = np.linspace(-1, 1, strips + 1), np.linspace(-1, 1, segments + 1)
    across, along = np.meshgrid(s, t, indexing="ij")
    x, y = (across, along) if swap else (along, across)
    points = surface.lift(x * surface.half[0], y * surface.half[1])
    return StripModel(spline.interpolate(points))


@dataclass
class SphereZone:
    """The part |z| <= height of a sphere: closest points are radial, a tube in topology."""

    radius: float = 8000.0
    height: float = 4000.0
    name: str = "sphere zone"

    @property
    def bounds(self) -> Array:
        r, h = self.radius, self.height
        return np.array([[-r, -r, -h], [r, r, h]])

    @property
    def loops(self) -> tuple[Array, ...]:
        return self.circle(-self.height), self.circle(self.height)

    def circle(self, z: float, count: int = 400) -> Array:
        angle = 2.0 * np.pi * np.arange(count) / count
        r = np.sqrt(self.radius**2 - z**2)
        return np.stack([r * np.cos(angle), r * np.sin(angle), np.full(count, z)], axis=-1)

    def closest(self, points: Array) -> SurfacePoints:
        normal = unit(points)
        shape = -(np.eye(3) - normal[:, :, None] * normal[:, None, :]) / self.radius
        return SurfacePoints(self.radius * normal, normal, shape, np.zeros(len(points), bool))

    def sample(self, count: int) -> SurfacePoints:
        return self.closest(
            np.concatenate([self.circle(z, 40) for z in np.linspace(-1, 1, 20) * self.height])
        )


def sphere_start(surface: SphereZone, strips: int, segments: int, around: bool) -> StripModel:
    """Edges along parallels (around: closed in u) or along meridians (closed in i)."""
    if around:
        z = np.linspace(-surface.height, surface.height, strips + 1)
        return StripModel(
            spline.interpolate(np.stack([surface.circle(v, segments) for v in z]), True), True
        )
    z = np.linspace(-surface.height, surface.height, segments + 1)
    points = np.stack([surface.circle(v, strips) for v in z], axis=1)
    return StripModel(spline.interpolate(points), False, True)


__all__ = ["Graph", "SphereZone", "iso_start", "quadric", "sphere_start", "unit"]
