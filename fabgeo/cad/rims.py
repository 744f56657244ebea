"""Where the wall of a hole meets the two skins of a plate, by Newton's method.

Glossary
--------
wall
    The surface of a bolt hole or slot: round pieces (half cylinders) and, of a slot, flat ones.
piece
    One of the 2 (round hole) or 4 (slot) pieces of a wall, run through by t in [0, 1]
    counter-clockwise about the hole's axis.
rim
    The curve in which a wall meets a skin: for every t the point on the wall's line along the
    axis at the height s(t), which lies on the skin at parameters u(t), v(t).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline
from scipy.spatial import KDTree
from scipy.special import comb

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.errors import PartError
from fabgeo.structures.holes import hole_frames
from fabgeo.structures.parts import Hole

ROUND, FLAT = 11, 4
"""Degrees of the rims of round and of flat pieces: one polynomial each.

A half circle of radius r lies within r (pi / 2)^12 / (2^11 12!) = 2.3e-10 r of its interpolant:
below the kernel's 1e-7 mm for every hole. A reader of STEP gives an edge further off a tolerance of
just its distance, and its own check finds that too small once in 100,000 rims.
"""


@dataclass(frozen=True)
class Piece:
    """A piece of a wall: a half cylinder about `centre`, or a plane through it (radius 0).

    `frame` holds rows x, y, z: z along the axis; of a half cylinder the angle runs from 0 (x) to
    pi, of a plane the line runs along x from `centre` over `length`.
    """

    centre: Array
    frame: Array
    radius: float
    length: float

    @property
    def start(self) -> Array:
        """Its point at t = 0 and height 0."""
        return self.centre + self.radius * self.frame[0]


@dataclass(frozen=True)
class Bernstein:
    """Polynomials of one degree over [0, 1], through values at Chebyshev's sites.

    Attributes
    ----------
    sites : (k,) array
        Where values are asked for, both ends among them.
    to_poles : (k, k) array
        From values at the sites to Bezier poles.
    fine : (m,) array
    at_fine : (m, k) array
        From poles to values at `fine`, where the interpolant is judged.
    """

    sites: Array
    to_poles: Array
    fine: Array
    at_fine: Array

    @staticmethod
    def of(degree: int) -> Bernstein:
        """Sites and matrices of a degree."""
        k = np.arange(degree + 1)
        sites = 0.5 - 0.5 * np.cos(np.pi * k / degree)
        fine = np.linspace(0.0, 1.0, 2 * degree + 3)

        def basis(t: Array) -> Array:
            x = t[:, None]
            return np.asarray(comb(degree, k) * x**k * (1.0 - x) ** (degree - k))

        return Bernstein(sites, np.linalg.inv(basis(sites)), fine, basis(fine))


_OF_DEGREE = {degree: Bernstein.of(degree) for degree in (ROUND, FLAT)}


@dataclass(frozen=True)
class Rim:
    """The rim of one piece on one skin as Bezier curves of one degree, k - 1.

    Attributes
    ----------
    points : (k, 3) array
        Poles in space.
    skin : (k, 2) array
        Poles (u, v) on the skin.
    height : (k,) array
        Poles of s.
    deviation : float
        Largest distance of the three from each other, measured between the sites (mm).
    """

    points: Array
    skin: Array
    height: Array
    deviation: float

    @property
    def ends(self) -> tuple[float, float]:
        """Heights s at t = 0 and 1."""
        return float(self.height[0]), float(self.height[-1])


def walls_of(holes: Sequence[Hole]) -> list[list[Piece]]:
    """The pieces of every hole's wall, counter-clockwise about its axis."""
    frames = hole_frames(holes)
    d, y, z = (frames[:, k] for k in range(3))
    radius = np.array([hole.diameter / 2.0 for hole in holes])[:, None]
    half = np.array([hole.slot / 2.0 for hole in holes])[:, None]
    middle = np.array([hole.centre for hole in holes])
    out: list[list[Piece]] = [[] for _ in holes]
    for sign in (1.0, -1.0):  # the half around +d runs from -y over d to +y
        centre = middle + sign * half * d
        rounds = np.stack([-sign * y, sign * d, z], axis=1)
        start = centre + sign * radius * y
        flats = np.stack([-sign * d, -sign * y, z], axis=1)
        for k, hole in enumerate(holes):
            out[k].append(Piece(centre[k], rounds[k], float(radius[k, 0]), 0.0))
            if hole.slot > 0.0:
                out[k].append(Piece(start[k], flats[k], 0.0, hole.slot))
    return out


def feet(walls: Sequence[Piece], t: Array) -> Array:
    """Points (n, k, 3) of pieces at height 0, at t (k,)."""
    radius = np.array([piece.radius for piece in walls])[:, None]
    length = np.array([piece.length for piece in walls])[:, None]
    frame = np.array([piece.frame for piece in walls])
    centre = np.array([piece.centre for piece in walls])
    x = np.where(radius > 0.0, radius * np.cos(np.pi * t), length * t)
    y = radius * np.sin(np.pi * t)
    return centre[:, None] + x[..., None] * frame[:, None, 0] + y[..., None] * frame[:, None, 1]


class Skin:
    """One ruled face of a prism, for finding rims on it."""

    def __init__(self, mark: str, knots: Array, poles: Array) -> None:
        self.mark = mark
        self.low = np.array([knots[0], 0.0])
        self.high = np.array([knots[-1], 1.0])
        curve = BSpline(knots, np.moveaxis(poles, 1, 0), 3)
        self.curve, self.slope = curve, curve.derivative()
        u = np.linspace(knots[0], knots[-1], 4 * (len(knots) - 7) + 1)
        v = np.linspace(0.0, 1.0, 5)
        self.grid_uv = np.stack(np.meshgrid(u, v, indexing="ij"), -1).reshape(-1, 2)
        self.grid = KDTree(self.at(self.grid_uv)[0])

    def at(self, uv: Array) -> tuple[Array, Array, Array]:
        """Points and derivatives by u and v, each (k, 3)."""
        x = np.asarray(self.curve(uv[:, 0]))
        slope = np.asarray(self.slope(uv[:, 0]))
        v = uv[:, 1:]
        ruling = x[:, 1] - x[:, 0]
        return x[:, 0] + v * ruling, slope[:, 0] + v * (slope[:, 1] - slope[:, 0]), ruling

    def rims(self, walls: Sequence[Piece]) -> list[Rim]:
        """The rims of pieces on this skin, all at once.

        Raises
        ------
        PartError
            If a wall breaks out of the skin or meets it at more than 45 degrees from square.
        """
        out: dict[int, Rim] = {}
        for degree in (ROUND, FLAT):
            chosen = [
                k for k, piece in enumerate(walls) if (piece.radius > 0.0) == (degree == ROUND)
            ]
            if chosen:
                made = self._rims([walls[k] for k in chosen], _OF_DEGREE[degree])
                out.update(zip(chosen, made, strict=True))
        return [out[k] for k in range(len(walls))]

    def _rims(self, walls: Sequence[Piece], form: Bernstein) -> list[Rim]:
        t = np.concatenate([form.sites, form.fine])
        count, sites = len(t), len(form.sites)
        foot, axis, uv, height = self.meet(walls, t)
        points = foot + height[:, None] * axis
        values = np.concatenate([points, uv, height[:, None]], axis=1).reshape(-1, count, 6)
        poles = form.to_poles @ values[:, :sites]  # (piece, pole, quantity)
        fine, true = form.at_fine @ poles, values[:, sites:, :3]
        on_skin = self.at(fine[..., 3:5].reshape(-1, 2))[0].reshape(true.shape)
        on_wall = foot.reshape(-1, count, 3)[:, sites:] + fine[..., 5:] * axis[::count, None]
        miss = [np.linalg.norm(fine[..., :3] - x, axis=-1) for x in (on_skin, on_wall, true)]
        deviation = np.max(miss, axis=(0, 2))
        return [
            Rim(c[:, :3], c[:, 3:5], c[:, 5], float(d))
            for c, d in zip(poles, deviation, strict=True)
        ]

    def meet(self, walls: Sequence[Piece], t: Array) -> tuple[Array, Array, Array, Array]:
        """Feet and axes (k, 3), parameters (k, 2) and heights (k,) of all pieces at t, in order.

        Raises
        ------
        PartError
            As `rims`.
        """
        foot = feet(walls, t).reshape(-1, 3)
        axis = np.repeat([piece.frame[2] for piece in walls], len(t), axis=0)
        middle = foot.reshape(len(walls), -1, 3).mean(axis=1)
        nearest = self.grid_uv[self.grid.query(middle)[1]]
        seeds, _ = self._meet(middle, axis[:: len(t)], nearest)
        uv, height = self._meet(foot, axis, np.repeat(seeds, len(t), axis=0))
        self._check(foot, axis, uv, height)
        return foot, axis, uv, height

    def closest(self, points: Array) -> Array:
        """Parameters (k, 2) of the skin's points closest to points (k, 3) near it."""
        uv = self.grid_uv[self.grid.query(points)[1]]
        for _ in range(30):
            x, xu, xv = self.at(uv)
            gap = points - x
            a, b, c, d, e = dot(xu, xu), dot(xu, xv), dot(xv, xv), dot(gap, xu), dot(gap, xv)
            step = np.stack([c * d - b * e, a * e - b * d], axis=1) / (a * c - b * b)[:, None]
            new = np.clip(uv + step, self.low, self.high)
            change = np.abs((new - uv) / (self.high - self.low)).max()
            uv = new
            if change < 1e-9:  # the next would be of its square
                break
        return uv

    def _meet(self, foot: Array, axis: Array, uv: Array) -> tuple[Array, Array]:
        """Parameters (k, 2) and heights (k,) where lines meet the skin, kept within its range."""
        height = np.zeros(len(foot))
        for _ in range(30):
            x, xu, xv = self.at(uv)
            gap = foot + height[:, None] * axis - x
            normal = cross(xu, xv)
            slope = dot(axis, normal)
            rise = dot(gap, normal) / np.where(slope == 0.0, 1e-300, slope)
            moved = gap - rise[:, None] * axis  # in the tangent plane now
            size = dot(normal, normal)
            step = np.stack([dot(cross(moved, xv), normal), dot(cross(xu, moved), normal)], axis=1)
            new = np.clip(uv + step / size[:, None], self.low, self.high)
            height = height - rise
            change = np.abs((new - uv) / (self.high - self.low)).max()
            uv = new
            if change < 1e-12:
                break
        return uv, height

    def _check(self, foot: Array, axis: Array, uv: Array, height: Array) -> None:
        x, xu, xv = self.at(uv)
        miss = np.linalg.norm(foot + height[:, None] * axis - x, axis=1)
        out = (miss > 1e-6) | np.any((uv <= self.low) | (uv >= self.high), axis=1)
        if out.any():
            raise PartError(
                self.mark,
                f"a hole at {_place(foot[out])} breaks out of the part's edge or misses it",
                "keep the edge distance",
            )
        skew = np.abs(dot(unit(cross(xu, xv)), axis)) < np.sqrt(0.5)
        if skew.any():
            raise PartError(
                self.mark,
                f"a hole at {_place(foot[skew])} runs more than 45 degrees from square",
                "turn its axis towards the normal",
            )


def _place(points: Array) -> str:
    x, y, z = points.reshape(-1, 3).mean(axis=0)
    return f"({x:.1f}, {y:.1f}, {z:.1f}) mm"
