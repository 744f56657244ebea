"""One planar section as a smooth curve: by arc length and by the direction of its tangent."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from fabgeo.arrays import Array, cross, unit

DENSE = 1024


class SectionCurve:
    """The cubic through a section's points, by chord length; periodic where closed.

    Attributes
    ----------
    angle : (DENSE + 1,) array
        Direction of the tangent against a fixed axis of the plane, continuous along the curve.
    convex : bool
        Whether the direction turns strictly one way, once round at most.
    """

    def __init__(self, points: Array, closed: bool, normal: Array) -> None:
        self.closed = closed
        ring = np.concatenate([points, points[:1]]) if closed else points
        chords = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
        chords /= chords[-1]
        degree = 3 if closed else min(3, len(ring) - 1)
        self._spline: BSpline = make_interp_spline(
            chords, ring, degree, bc_type="periodic" if closed else None
        )
        t = np.linspace(0.0, 1.0, DENSE + 1)
        speed = np.linalg.norm(self._spline(t, 1), axis=1)
        steps = _simpson_steps(lambda x: np.linalg.norm(self._spline(x, 1), axis=1), t)
        self._t = t
        self._length = np.concatenate([[0.0], np.cumsum(steps)])
        self.length = float(self._length[-1])
        self._length /= self.length
        e1, e2 = plane_axes(normal)
        first, second = self._spline(t, 1), self._spline(t, 2)
        self.angle = np.unwrap(np.arctan2(first @ e2, first @ e1))
        turning = (first @ e1) * (second @ e2) - (first @ e2) * (second @ e1)
        curvature = turning / speed**3 * self.length
        if closed:  # the angle at the start in [0, 2 pi), so that all sections agree
            self.angle += 2.0 * np.pi * np.round((0.0 - self.angle[0]) / (2.0 * np.pi))
        total = abs(self.angle[-1] - self.angle[0])
        strict = curvature.min() > 1e-2 or curvature.max() < -1e-2
        self.convex = bool(strict and total < 2.0 * np.pi + 1e-3 and (closed or total > 0.05))

    def at_length(self, part: Array) -> Array:
        """Points (k, 3) at parts of the arc length; closed curves go round."""
        part = np.mod(part, 1.0) if self.closed else np.clip(part, 0.0, 1.0)
        return self._spline(np.interp(part, self._length, self._t))

    def length_at(self, angle: Array) -> Array:
        """Parts of the arc length at which the tangent has the given angle (strictly convex)."""
        if not self.closed:
            order = slice(None) if self.angle[-1] > self.angle[0] else slice(None, None, -1)
            return np.interp(angle, self.angle[order], self._length[order])
        turns = np.floor((angle - self.angle[0]) / (2.0 * np.pi))
        within = angle - 2.0 * np.pi * turns
        return np.interp(within, self.angle, self._length) + turns


def _simpson_steps(speed: Callable[[Array], Array], t: Array) -> Array:
    h = t[1] - t[0]
    return (speed(t[:-1]) + 4.0 * speed(t[:-1] + h / 2.0) + speed(t[1:])) * h / 6.0


def plane_axes(normal: Array) -> tuple[Array, Array]:
    """Two unit vectors that form a right-handed frame with `normal`."""
    helper: Array = np.eye(3)[int(np.argmin(np.abs(normal)))]
    e1 = unit(cross(helper, normal))
    return e1, cross(normal, e1)
