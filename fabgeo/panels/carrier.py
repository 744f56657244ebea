"""Plane, right circular cylinder and right circular cone as one family, many at a time.

Glossary
--------
carrier
    The whole infinite shape on which a panel lies. In the frame (a, m, n) at a point o on it, with
    a along the ruling, n the unit normal and m = n x a, two numbers say which shape it is: k, the
    normal curvature along m at o, and g, the rate at which the rulings turn there (the apex lies
    at -a/g). k = g = 0 is a plane, g = 0 a cylinder of radius 1/k, otherwise a cone of half angle
    atan(g/k). Nothing in the formulas divides by k or g: a plane is an ordinary point of the
    family, which is what lets one fit run through all three.
signed distance
    With local coordinates (x, y, z), e = 1 + g x, E = e + k z, Q = sqrt(E^2 + (k^2 + g^2) y^2)::

        d = z + k y^2 / (Q + E)

    the orthogonal distance, positive on the side of n. Its gradient is the unit normal at the
    foot, its only curvature k/Q, along the circle's direction (-g y, E, -k y)/Q.
turn, reach
    Coordinates on the carrier: the ruling is reached from o's by turning through the arc `turn`
    (measured at o's level), the point lies at `reach` along it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from fabgeo.arrays import Array, BoolArray, IntArray, cross, unit


@dataclass(frozen=True)
class Carriers:
    """A batch of carriers.

    Attributes
    ----------
    origin : (p, 3) array
        Points o on the carriers.
    frame : (p, 3, 3) array
        Rows a (ruling), m, n (normal).
    k, g : (p,) arrays
        Curvature across the ruling and turning rate of the rulings at o, 1/mm.
    """

    origin: Array
    frame: Array
    k: Array
    g: Array

    def __len__(self) -> int:
        return len(self.origin)

    def __getitem__(self, index: IntArray | BoolArray | slice) -> Self:
        return type(self)(self.origin[index], self.frame[index], self.k[index], self.g[index])

    @classmethod
    def joined(cls, parts: list[Carriers]) -> Carriers:
        """One batch of several."""
        return cls(
            *(
                np.concatenate([getattr(p, name) for p in parts])
                for name in ("origin", "frame", "k", "g")
            )
        )

    def as_class(self, name: str) -> Carriers:
        """The same places without what a class has not: "flat" no curvature, only "cone" turns."""
        zero = np.zeros(len(self))
        k, g = (zero if name == "flat" else self.k), (self.g if name == "cone" else zero)
        return Carriers(self.origin, self.frame, k, g)

    def where(self, mask: BoolArray, other: Carriers) -> Carriers:
        """These carriers where `mask` holds, `other`'s elsewhere."""
        return Carriers(
            np.where(mask[:, None], self.origin, other.origin),
            np.where(mask[:, None, None], self.frame, other.frame),
            np.where(mask, self.k, other.k),
            np.where(mask, self.g, other.g),
        )

    def local(self, points: Array) -> Array:
        """World points (p, s, 3) in the carriers' frames."""
        return (points - self.origin[:, None]) @ self.frame.transpose(0, 2, 1)

    def world(self, points: Array) -> Array:
        """Local points (p, s, 3) in the world."""
        return self.vectors(points) + self.origin[:, None]

    def vectors(self, local: Array) -> Array:
        """Local vectors (p, s, 3) in the world."""
        return local @ self.frame

    def distance(self, points: Array) -> Array:
        """Signed distance (p, s) of world points (p, s, 3)."""
        local, big_e, q = self._terms(points)
        y, z = local[..., 1], local[..., 2]
        return z + self.k[:, None] * y * y / (q + big_e)

    def normal(self, points: Array) -> Array:
        """Unit normal (p, s, 3) at the foot of world points: the distance's gradient."""
        return self.vectors(self._local_normal(*self._terms(points)))

    def project(self, points: Array) -> Array:
        """Feet (p, s, 3) of world points."""
        local, big_e, q = self._terms(points)
        y = local[..., 1]
        distance = local[..., 2] + self.k[:, None] * y * y / (q + big_e)
        normal = self.vectors(self._local_normal(local, big_e, q))
        return points - distance[..., None] * normal

    def curvature(self, points: Array) -> tuple[Array, Array]:
        """Curvature (p, s) of the parallel carrier through the points and its direction (p, s, 3).

        The distance's Hessian is the curvature times the direction's square.
        """
        local, big_e, q = self._terms(points)
        y = local[..., 1]
        direction = np.stack([-self.g[:, None] * y, big_e, -self.k[:, None] * y], -1) / q[..., None]
        return self.k[:, None] / q, self.vectors(direction)

    def ruling(self, points: Array) -> Array:
        """Unit direction (p, s, 3) of the ruling at the foot, along the side of a."""
        _, direction = self.curvature(points)
        return _cross(direction, self.normal(points))

    def derivatives(self, points: Array) -> tuple[Array, Array]:
        """Signed distance (p, s) and its exact derivatives (p, s, 6).

        By a shift along n, rotations about a, m, n (acting on the carrier), k and g.
        """
        local, big_e, q = self._terms(points)
        x, y, z = local[..., 0], local[..., 1], local[..., 2]
        k, g, w = self.k[:, None], self.g[:, None], q + big_e
        normal = self._local_normal(local, big_e, q)
        turning = -_cross(local, normal)  # a rotation w moves the local point by -w x X
        factor = k * y * y / (w * w)
        by_k = y * y / w - factor * (z + (big_e * z + k * y * y) / q)
        by_g = -factor * (x + (big_e * x + g * y * y) / q)
        jacobian = np.concatenate(
            [-normal[..., 2:], turning, by_k[..., None], by_g[..., None]], axis=-1
        )
        return z + k * y * y / w, jacobian

    def tilt_derivatives(self, points: Array, along: Array) -> tuple[Array, Array]:
        """Component (p, t) of the normal along world vectors (p, t, 3), derivatives (p, t, 6)."""
        local, big_e, q = self._terms(points)
        x, y, z = local[..., 0], local[..., 1], local[..., 2]
        k, g, w = self.k[:, None], self.g[:, None], q + big_e
        normal = self._local_normal(local, big_e, q)
        c = along @ self.frame.transpose(0, 2, 1)
        circle = np.stack([-g * y, big_e, -k * y], -1) / q[..., None]
        hessian = (k / q * np.einsum("psi,psi->ps", circle, c))[..., None] * circle  # H c
        # c . (w x N) - (H c) . (w x X) for a rotation w, -(H c) . n for a shift
        turning = _cross(normal, c) - _cross(local, hessian)
        by = []
        for d_e, d_q in (
            (z, (big_e * z + k * y * y) / q),
            (x, (big_e * x + g * y * y) / q),
        ):
            d_k = 1.0 if len(by) == 0 else 0.0
            d_g = 1.0 - d_k
            ratio = y * y / (q * w)
            d_ratio = -ratio * (d_q / q + (d_q + d_e) / w)
            d_normal = np.stack(
                [
                    -(d_g * k + d_k * g) * ratio - g * k * d_ratio,
                    d_k * y / q - k * y * d_q / (q * q),
                    -2.0 * k * d_k * ratio - k * k * d_ratio,
                ],
                -1,
            )
            by.append(np.einsum("psi,psi->ps", d_normal, c))
        jacobian = np.concatenate(
            [-hessian[..., 2:], turning, by[0][..., None], by[1][..., None]], axis=-1
        )
        return np.einsum("psi,psi->ps", normal, c), jacobian

    def swing_derivatives(self, points: Array, along: Array) -> tuple[Array, Array]:
        """Component (p, t) of the ruling along world vectors (p, t, 3), derivatives (p, t, 6).

        Of the ruling a + g X through points X taken to lie on the carrier.
        """
        local = self.local(points)
        c = along @ self.frame.transpose(0, 2, 1)
        g = self.g[:, None, None]
        ray = np.array([1.0, 0.0, 0.0]) + g * local
        length = np.linalg.norm(ray, axis=-1, keepdims=True)
        ray = ray / length
        swing = np.einsum("psi,psi->ps", ray, c)
        free = (c - swing[..., None] * ray) / length  # how the component follows the ray
        # A rotation w moves the local point by -w x X and the local c by -w x c.
        turning = -g * _cross(local, free) - _cross(c, ray)
        by_g = np.einsum("psi,psi->ps", free, local)[..., None]
        shift = -g * free[..., 2:]
        return swing, np.concatenate([shift, turning, np.zeros_like(by_g), by_g], axis=-1)

    def moved(self, step: Array) -> Carriers:
        """Carriers after a step (p, 6) in the order of `derivatives`."""
        rotation = _rotations(step[:, 1:4])  # in local coordinates
        frame = np.einsum("pji,pjk->pik", rotation, self.frame)
        origin = self.origin + step[:, :1] * self.frame[:, 2]
        return Carriers(origin, frame, self.k + step[:, 4], self.g + step[:, 5])

    def at(self, turn: Array, reach: Array) -> Array:
        """World points (p, s, 3) on the carriers at coordinates (p, s)."""
        k, g, n = self._k_g_n()
        half = n * turn / 2.0
        sag = 0.5 * turn**2 * np.sinc(half / np.pi) ** 2  # (1 - cos(n turn)) / n^2
        across = turn * np.sinc(2.0 * half / np.pi)  # sin(n turn) / n
        e = 1.0 + g * reach
        return self.world(np.stack([reach - e * g * sag, e * across, -e * k * sag], -1))

    def coordinates(self, points: Array) -> tuple[Array, Array]:
        """Turn and reach (p, s) of the feet of world points."""
        _, g, n = self._k_g_n()
        local, big_e, _ = self._terms(self.project(points))
        x, y = local[..., 0], local[..., 1]
        small = n * np.abs(y) < 1e-9 * np.abs(big_e)
        turn = np.where(small, y / big_e, np.arctan2(n * y, big_e) / np.where(n > 0.0, n, 1.0))
        sag = 0.5 * turn**2 * np.sinc(n * turn / 2.0 / np.pi) ** 2
        return turn, (x + g * sag) / (1.0 - g * g * sag)

    def _k_g_n(self) -> tuple[Array, Array, Array]:
        k, g = self.k[:, None], self.g[:, None]
        return k, g, np.hypot(k, g)

    def _terms(self, points: Array) -> tuple[Array, Array, Array]:
        """Local coordinates, E and Q: see the module's glossary."""
        local = self.local(points)
        y = local[..., 1]
        big_e = 1.0 + self.g[:, None] * local[..., 0] + self.k[:, None] * local[..., 2]
        q = np.sqrt(big_e**2 + (self.k**2 + self.g**2)[:, None] * y * y)
        # Beyond an apex (E < 0) and on the ray there Q + E is zero, by which the formulas divide.
        return local, big_e, np.maximum(q, np.maximum(-big_e * (1.0 + 1e-14), 1e-150))

    def _local_normal(self, local: Array, big_e: Array, q: Array) -> Array:
        y = local[..., 1]
        k, g = self.k[:, None], self.g[:, None]
        ratio = k * y * y / (q * (q + big_e))
        return np.stack([-g * ratio, k * y / q, 1.0 - k * ratio], -1)


def _cross(a: Array, b: Array) -> Array:
    """Cross product of vectors of equal shape (..., 3), leaner than numpy's."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(a[..., j], b[..., k], out=out[..., i])
        out[..., i] -= a[..., k] * b[..., j]
    return out


def frames(ruling: Array, normal: Array) -> Array:
    """Right-handed frames (p, 3, 3), rows a, m, n, from rulings and normals (p, 3)."""
    n = unit(normal)
    a = unit(ruling - np.einsum("pi,pi->p", ruling, n)[:, None] * n)
    return np.stack([a, cross(n, a), n], axis=1)


def _rotations(vectors: Array) -> Array:
    """Rotation matrices (p, 3, 3) of rotation vectors (p, 3) (Rodrigues)."""
    angle = np.linalg.norm(vectors, axis=-1)[:, None, None]
    cross = np.zeros((len(vectors), 3, 3))
    for i, j, c, sign in ((0, 1, 2, -1), (0, 2, 1, 1), (1, 2, 0, -1)):
        cross[:, i, j] = sign * vectors[:, c]
        cross[:, j, i] = -sign * vectors[:, c]
    sine = np.sinc(angle / np.pi)
    cosine = 0.5 * np.sinc(angle / 2.0 / np.pi) ** 2
    return np.eye(3) + sine * cross + cosine * cross @ cross
