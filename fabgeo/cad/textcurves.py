"""Curves of a STEP text as functions, by textbook formulas: no kernel.

Source: de Boor's recursion; ISO 10303-42 for the meaning of each entity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.cad.part21 import Entities
from fabgeo.errors import InputError


def bases(knots: Array, degree: int, t: Array, derivative: int = 0) -> Array:
    """B-spline basis functions (k, n) at t (k,): the Cox - de Boor recursion."""
    if derivative:
        lower = bases(knots, degree - 1, t, derivative - 1)
        gap = knots[degree:] - knots[:-degree]
        scaled = lower * np.divide(degree, gap, out=np.zeros_like(gap), where=gap > 0)
        return scaled[:, :-1] - scaled[:, 1:]
    last = np.searchsorted(knots, knots[-1]) - 1
    span = np.clip(np.searchsorted(knots, t, side="right") - 1, 0, last)
    value = np.zeros((len(t), len(knots) - 1))
    value[np.arange(len(t)), span] = 1.0
    for p in range(1, degree + 1):
        left, right = knots[p:-1] - knots[: -p - 1], knots[p + 1 :] - knots[1:-p]
        a = np.divide(1.0, left, out=np.zeros_like(left), where=left > 0)
        b = np.divide(1.0, right, out=np.zeros_like(right), where=right > 0)
        rise = (t[:, None] - knots[: -p - 1]) * a
        fall = (knots[p + 1 :] - t[:, None]) * b
        value = rise * value[:, :-1] + fall * value[:, 1:]
    return value


class Curve(Protocol):
    """A curve in space."""

    def at(self, t: Array) -> tuple[Array, Array]:
        """Points and derivatives, each (k, 3)."""
        ...

    def breaks(self, start: Array, end: Array) -> Array:
        """Parameters from the start point to the end point, with all knots between."""
        ...


@dataclass(frozen=True)
class Line:
    """``x = origin + t along``."""

    origin: Array
    along: Array

    def at(self, t: Array) -> tuple[Array, Array]:
        """Points and derivatives."""
        return self.origin + t[:, None] * self.along, np.broadcast_to(self.along, (len(t), 3))

    def breaks(self, start: Array, end: Array) -> Array:
        """From the start to the end point."""
        return (
            np.array([start - self.origin, end - self.origin])
            @ self.along
            / dot(self.along, self.along)
        )


@dataclass(frozen=True)
class Ellipse:
    """``x = origin + a cos t x + b sin t y``: a circle where a = b."""

    frame: Array
    a: float
    b: float

    def at(self, t: Array) -> tuple[Array, Array]:
        """Points and derivatives."""
        x, y = self.frame[:3, 0] * self.a, self.frame[:3, 1] * self.b
        c, s = np.cos(t)[:, None], np.sin(t)[:, None]
        return self.frame[:3, 3] + c * x + s * y, c * y - s * x

    def breaks(self, start: Array, end: Array) -> Array:
        """Counter-clockwise from start to end, all round where they are one."""
        local = (np.array([start, end]) - self.frame[:3, 3]) @ self.frame[:3, :2]
        t0, t1 = np.arctan2(local[:, 1] / self.b, local[:, 0] / self.a)
        turn = np.mod(t1 - t0, 2.0 * np.pi)
        if np.linalg.norm(end - start) < 1e-9 * max(self.a, 1.0):
            turn = 2.0 * np.pi
        return np.linspace(t0, t0 + turn, 2 + int(turn / 0.8))


@dataclass(frozen=True)
class Hyperbola:
    """``x = origin + a cosh t x + b sinh t y``: where a plane cuts a cone along its axis."""

    frame: Array
    a: float
    b: float

    def at(self, t: Array) -> tuple[Array, Array]:
        """Points and derivatives."""
        x, y = self.frame[:3, 0] * self.a, self.frame[:3, 1] * self.b
        c, s = np.cosh(t)[:, None], np.sinh(t)[:, None]
        return self.frame[:3, 3] + c * x + s * y, s * x + c * y

    def breaks(self, start: Array, end: Array) -> Array:
        """From the start to the end point."""
        local = (np.array([start, end]) - self.frame[:3, 3]) @ self.frame[:3, 1]
        first, last = np.arcsinh(local / self.b).tolist()
        return np.linspace(first, last, 5)


@dataclass(frozen=True)
class Spline:
    """A B-spline curve, rational where its weights differ."""

    degree: int
    knots: Array
    poles: Array
    weights: Array

    def at(self, t: Array) -> tuple[Array, Array]:
        """Points and derivatives."""
        value, slope = (bases(self.knots, self.degree, t, d) for d in (0, 1))
        weighted = self.poles * self.weights[:, None]
        w, dw = value @ self.weights, slope @ self.weights
        x = (value @ weighted) / w[:, None]
        return x, (slope @ weighted - dw[:, None] * x) / w[:, None]

    def breaks(self, start: Array, end: Array) -> Array:
        """From the start to the end point; the whole curve where they are its ends."""
        spans = np.unique(self.knots[self.degree : len(self.knots) - self.degree])
        ends, _ = self.at(spans[[0, -1]])
        low, high = (
            spans[k] if np.linalg.norm(ends[k] - p) < 1e-5 else self._foot(p, spans)
            for k, p in ((0, start), (-1, end))
        )
        if low == high:
            return spans
        return np.concatenate([[low], spans[(spans > low) & (spans < high)], [high]])

    def _foot(self, point: Array, spans: Array) -> float:
        t = np.linspace(spans[0], spans[-1], 20 * len(spans))
        x, _ = self.at(t)
        foot = t[[np.argmin(((x - point) ** 2).sum(axis=1))]]
        for _ in range(20):
            x, dx = self.at(foot)
            foot = np.clip(foot - dot(x - point, dx) / dot(dx, dx), spans[0], spans[-1])
        return float(foot[0])


def frame_of(file: Entities, number: int) -> Array:
    """The (4, 4) matrix of an AXIS2_PLACEMENT_3D."""
    _, where, axis, ref = file.arguments(number)
    z = unit(point_of(file, axis)) if axis else np.array([0.0, 0.0, 1.0])
    x = point_of(file, ref) if ref else np.eye(3)[np.argmin(np.abs(z))]
    x = unit(x - (x @ z) * z)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([x, cross(z, x), z], axis=1)
    matrix[:3, 3] = point_of(file, where)
    return matrix


def point_of(file: Entities, number: int) -> Array:
    """A CARTESIAN_POINT or DIRECTION (3,), or the point of a VERTEX_POINT."""
    arguments = file.arguments(number)
    if file.kind(number) == "VERTEX_POINT":
        return point_of(file, arguments[1])
    return np.array(arguments[1], dtype=np.float64)


def curve_of(file: Entities, number: int) -> Curve:
    """The curve of an entity.

    Raises
    ------
    InputError
        If its kind is none of those that this reader knows.
    """
    parts = file.parts(number)
    kind, a = next(iter(parts.items()))
    if kind in ("SURFACE_CURVE", "SEAM_CURVE", "INTERSECTION_CURVE", "TRIMMED_CURVE"):
        return curve_of(file, a[1])
    if kind == "LINE":
        _, direction, length = file.arguments(a[2])
        return Line(point_of(file, a[1]), length * unit(point_of(file, direction)))
    if kind in ("CIRCLE", "ELLIPSE"):
        return Ellipse(frame_of(file, a[1]), a[2], a[-1])
    if kind == "HYPERBOLA":
        return Hyperbola(frame_of(file, a[1]), a[2], a[3])
    if "B_SPLINE_CURVE_WITH_KNOTS" in parts:
        return _spline(file, parts)
    raise InputError(f"{file.where}, #{number}", f"is a {file.kind(number)}, which is not known")


def _spline(file: Entities, parts: dict[str, list[Any]]) -> Spline:
    own = parts["B_SPLINE_CURVE_WITH_KNOTS"]
    head = parts["B_SPLINE_CURVE"] if "B_SPLINE_CURVE" in parts else own[1:]
    poles = np.array([point_of(file, p) for p in head[1]])
    weights = parts.get("RATIONAL_B_SPLINE_CURVE", [np.ones(len(poles))])[0]
    return Spline(head[0], np.repeat(own[-2], own[-3]), poles, np.array(weights, dtype=np.float64))
