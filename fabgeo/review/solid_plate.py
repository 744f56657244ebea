"""A plate's solid, as read back from STEP, seen as what it was cut from: mid-surface and thickness.

Glossary (skin, side: see `fabgeo.review.plate_sides`)
--------
rails
    The two edges of the mid-surface between which its rulings run, sampled alike.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fabgeo.arrays import Array, ComplexArray, cross, dot, unit
from fabgeo.errors import GeometryError
from fabgeo.review.plate_sides import loops, sides, skins
from fabgeo.review.rails import rail_normals, ruling_radii

if TYPE_CHECKING:
    from fabgeo.cad.readback import ReadPart

SAMPLES = 65  # of an edge of the outline; of an edge of many knots, two to a span:
MOST_SAMPLES = 257  # bending changes from knot to knot
SQUARE = 1.001  # a bevel of 5 degrees makes a side as much wider than the plate is thick
VOLUME_EPS = 1e-3  # asked of the adaptive quadrature; on plates with holes it leaves under 1e-9


@dataclass(frozen=True)
class SolidPlate:
    """A plate measured from its solid.

    Attributes
    ----------
    mark : str
    volume : float
        mm3, holes taken off.
    centre : (3,) array
        Centre of mass.
    edges : tuple of (n, 3) arrays
        Edges of the mid-surface, each beginning where the one before ends.
    straight : tuple of bool
        Whether each edge is a straight line.
    thickness : float
        Mean distance of the skins in mm, along the edges that are not bevelled.
    openings : tuple of (n, 3) arrays
        Rims of the openings through both skins, at mid-surface.
    gaussian : float
        Largest Gaussian curvature of the skins, times the square of the plate's size.
    through : (e, 3) array
        Half way along each edge the vector from one skin to the other, of the same sense.
    """

    mark: str
    volume: float
    centre: Array
    edges: tuple[Array, ...]
    straight: tuple[bool, ...]
    thickness: float
    openings: tuple[Array, ...]
    gaussian: float = 0.0
    through: Array = field(default_factory=lambda: np.empty((0, 3)))

    @cached_property
    def lengths(self) -> Array:
        """Lengths of the edges."""
        return np.array([polyline_length(edge) for edge in self.edges])

    @cached_property
    def corners(self) -> Array:
        """Corner points of the mid-surface."""
        return np.stack([edge[0] for edge in self.edges])

    @cached_property
    def turns(self) -> Array:
        """Angles by which the mid-surface's outline turns at its corners, radians."""
        leave = unit(np.stack([_tangent(edge) for edge in self.edges]))
        arrive = np.roll(unit(np.stack([-_tangent(edge[::-1]) for edge in self.edges])), 1, axis=0)
        sine = np.linalg.norm(cross(arrive, leave), axis=1)
        return np.arctan2(sine, np.sum(arrive * leave, axis=1))

    @cached_property
    def normals(self) -> tuple[Array, Array]:
        """Unit normals of the mid-surface along both rails: `rail_normals`; four-sided plates."""
        return rail_normals(*self.four_sided)

    @cached_property
    def radii(self) -> Array:
        """Bending radii (2, n) along both rails: `ruling_radii`; four-sided plates."""
        return ruling_radii(self.four_sided)

    @property
    def four_sided(self) -> tuple[Array, Array]:
        """`rails` of a plate that has them.

        Raises
        ------
        GeometryError
            If it has none.
        """
        rails = self.rails()
        if rails is None:
            raise GeometryError(self.mark, "is no four-sided plate", "ask `rails` first")
        return rails

    def rails(self) -> tuple[Array, Array] | None:
        """The two edges that rulings join, in the same sense; None: not a four-sided plate."""
        if len(self.edges) != 4:
            return None
        first = 0 if self.straight[1] and self.straight[3] else 1
        if not (self.straight[first + 1] and self.straight[(first + 3) % 4]):
            return None
        a, b = self.edges[first], self.edges[first + 2][::-1]
        return a, b


def _tangent(points: Array) -> Array:
    """Derivative at the first of evenly sampled points, exact on parabolas."""
    if len(points) < 3:
        return points[1] - points[0]
    return 2.0 * points[1] - 1.5 * points[0] - 0.5 * points[2]


def polyline_length(points: Array) -> float:
    """Length of a smooth curve through evenly sampled points: chords, once extrapolated."""
    fine = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    if len(points) % 2 == 0 or len(points) < 5:
        return fine
    coarse = float(np.linalg.norm(np.diff(points[::2], axis=0), axis=1).sum())
    return fine + (fine - coarse) / 3.0


def solid_plate(part: ReadPart, volume: float, centre: Array) -> SolidPlate | None:
    """Measure a plate's solid; None if it has no two skins with sides between them."""
    edges = part.edges()
    one, two = skins(edges)
    found = loops(sides(edges, one, two))
    if not found:
        return None
    outer = max(found, key=lambda loop: sum(side.length for side in loop))
    if len(outer) < 3:
        return None
    spans = max(edge.spans for side in outer for edge in (side.one, side.two))
    apart = [side.apart(max(SAMPLES, min(2 * spans + 1, MOST_SAMPLES))) for side in outer]
    mids = [0.5 * (a + b) for a, b in apart]
    size = sum(polyline_length(mid) for mid in mids) / 4.0
    return SolidPlate(
        part.name,
        volume,
        centre,
        tuple(mids),
        tuple(
            side.one.kind == "line" or _is_straight(mid)
            for side, mid in zip(outer, mids, strict=True)
        ),
        _thickness(apart),
        tuple(
            np.concatenate([side.rim(SAMPLES) for side in loop])
            for loop in found
            if loop is not outer
        ),
        max(part.gaussian(one), part.gaussian(two)) * size**2,
        np.array([b[len(b) // 2] - a[len(a) // 2] for a, b in apart]),
    )


def _thickness(apart: list[tuple[Array, Array]]) -> float:
    """Mean distance of the skins along the edges whose sides are square to them.

    Between bevelled ends one skin's edges are longer: what its points are ahead along the edge is
    left out.
    """
    means = []
    for a, b in apart:
        along = np.gradient(0.5 * (a + b), axis=0, edge_order=2)
        ahead = dot(b - a, along) / np.maximum(dot(along, along), 1e-300)
        means.append(np.linalg.norm(b - a - ahead[:, None] * along, axis=1).mean())
    least = SQUARE * min(means)
    return float(np.mean([mean for mean in means if mean <= least]))


def _is_straight(points: Array, tolerance: float = 1e-6) -> bool:
    chord = points[-1] - points[0]
    length = float(np.linalg.norm(chord))
    if length == 0.0:
        return False
    away = np.linalg.norm(cross(points - points[0], chord / length), axis=1)
    return bool(away.max() <= tolerance * length)


def developed(a: Array, b: Array) -> tuple[Array, Array]:
    """Lay the strip between two rails (n, 3) flat; returns both rails in the plane, (m, 2) each.

    Quad by quad as two triangles each. The chords' error falls with the square of the sampling:
    one extrapolation over every second sample (n odd) leaves the fourth order. A cubic over the
    chords' length gives the curves between the samples: over their number it would swing where a
    rail that is cut along a boundary comes to run along a ruling, and steps grow without bound.
    """
    fine, coarse = _laid(a, b), _laid(a[::2], b[::2])
    first, second = (between_samples(_refined(f, c)) for f, c in zip(fine, coarse, strict=True))
    return first, second


def _refined(fine: Array, coarse: Array) -> Array:
    """The fine points (n, 2) with a third of what they gained on the coarse ones once more."""
    gain, made = (fine[::2] - coarse) / 3.0, fine.copy()
    made[::2] += gain
    made[1::2] += 0.5 * (gain[:-1] + gain[1:])
    return made


def between_samples(points: Array, count: int = 4) -> Array:
    """Points (count (n - 1) + 1, d) of the curve through n points (n, d), these among them."""
    from scipy.interpolate import CubicSpline

    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    arc = np.append(0.0, np.cumsum(np.maximum(steps, 1e-9 * steps.sum() + 1e-12)))
    sites = np.linspace(0.0, len(points) - 1.0, count * (len(points) - 1) + 1)
    return np.asarray(CubicSpline(arc, points)(np.interp(sites, np.arange(len(points)), arc)))


def _laid(a: Array, b: Array) -> tuple[Array, Array]:
    """The triangles between two rails in the plane, the first ruling on the y axis.

    In complex numbers every triangle turns and stretches its base onto its next side: the rulings
    in the plane are a running product, the points of the first rail a running sum.
    """
    rulings, diagonals = np.linalg.norm(b - a, axis=1), np.linalg.norm(b[:-1] - a[1:], axis=1)
    steps_a = np.linalg.norm(np.diff(a, axis=0), axis=1)
    steps_b = np.linalg.norm(np.diff(b, axis=0), axis=1)
    along = _apex(rulings[:-1], steps_a, diagonals)
    across = _apex(diagonals, rulings[1:], steps_b)
    turned = np.append(1.0, np.cumprod((1.0 - along) * across)) * 1j * rulings[0]
    first = np.append(0.0, np.cumsum(turned[:-1] * along))
    second = first + turned
    return _plane(first), _plane(second)


def _apex(base: Array, to_p: Array, to_q: Array) -> ComplexArray:
    """The apex right of a base from p to q by its two sides, as a complex multiple of the base."""
    x = (to_p**2 - to_q**2 + base**2) / (2.0 * base)
    y = np.sqrt(np.maximum(to_p**2 - x * x, 0.0))
    return (x - 1j * y) / base


def _plane(points: ComplexArray) -> Array:
    return np.stack([points.real, points.imag], axis=-1)


def shape_area(flat: Array) -> float:
    """Area of a closed polygon (n, 2), unsigned."""
    x, y = flat[:, 0], flat[:, 1]
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)))
