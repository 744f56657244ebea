"""Best plane, cylinder and cone of many patches at once: orthogonal distance fits.

Least squares first (Levenberg-Marquardt with exact derivatives, started from the Gauss image),
then the p-norm with p rising, which approaches the smallest largest distance: the deviation is
what a tolerance limits.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fabgeo.arrays import Array, IntArray, dot
from fabgeo.panels.carrier import Carriers, frames
from fabgeo.panels.samples import Samples, turning

type ShapeKind = Literal["flat", "cylinder", "cone"]

# Which of the six steps (shift, three rotations, k, g) each shape is free to make.
_FREE: dict[str, Array] = {
    "flat": np.array([1.0, 1, 1, 0, 0, 0]),
    "cylinder": np.array([1.0, 1, 1, 1, 1, 0]),
    "cone": np.array([1.0, 1, 1, 1, 1, 1]),
    "rolled": np.array([1.0, 1, 1, 1, 0, 0]),  # a cylinder of given radius
}

_TOGETHER = 128  # panels in one batch
_LONGEST = 0.5  # step, in radians and in panel sizes


@dataclass(frozen=True)
class Targets:
    """What a batch of carriers is fitted to; residuals are divided by their unit.

    Attributes
    ----------
    points : (p, s, 3) array
        Points that should lie on the carrier, each with the distance that counts as one.
    unit : (p, s) array
    tilt_points, along : (p, t, 3) arrays
        The carrier's normal at these points should have the component `tilt` along `along`.
    tilt, tilt_unit : (p, t) arrays
        Wanted component, and the error that counts as one.
    swing_points, swing_along : (p, r, 3) arrays
        The carrier's ruling at these points should have the component `swing` along `swing_along`.
    swing, swing_unit : (p, r) arrays
        Wanted component, and the error that counts as one.
    """

    points: Array
    unit: Array
    tilt_points: Array
    along: Array
    tilt: Array
    tilt_unit: Array
    swing_points: Array
    swing_along: Array
    swing: Array
    swing_unit: Array

    @classmethod
    def of_points(cls, points: Array, unit: float | Array = 1.0) -> Targets:
        """Points alone, (p, s, 3)."""
        p, s = points.shape[:2]
        none = np.zeros((p, 0, 3))
        return cls(
            points,
            np.broadcast_to(np.asarray(unit, dtype=float), (p, s)),
            *(none, none, none[..., 0], none[..., 0]) * 2,
        )

    def __getitem__(self, index: IntArray) -> Targets:
        return Targets(*(getattr(self, name)[index] for name in self.__dataclass_fields__))

    def scaled(self, centre: Array, size: Array) -> Targets:
        """The same problem with lengths in units of `size` (p,) about `centre` (p, 3)."""

        def place(x: Array) -> Array:
            return (x - centre[:, None]) / size[:, None, None]

        return Targets(
            place(self.points),
            self.unit / size[:, None],
            place(self.tilt_points),
            self.along,
            self.tilt,
            self.tilt_unit,
            place(self.swing_points),
            self.swing_along,
            self.swing,
            self.swing_unit,
        )

    def residuals(self, carriers: Carriers) -> tuple[Array, Array]:
        """Residuals (p, s + t + r) and their exact derivatives (p, s + t + r, 6)."""
        d, jac = carriers.derivatives(self.points)
        found: list[tuple[Array, Array, Array | float, Array]] = [(d, jac, 0.0, self.unit)]
        if self.tilt.shape[1]:
            tilt = carriers.tilt_derivatives(self.tilt_points, self.along)
            found.append((*tilt, self.tilt, self.tilt_unit))
        if self.swing.shape[1]:
            swing = carriers.swing_derivatives(self.swing_points, self.swing_along)
            found.append((*swing, self.swing, self.swing_unit))
        return (
            np.concatenate([(f - wanted) / unit for f, _, wanted, unit in found], axis=1),
            np.concatenate([jac / unit[..., None] for _, jac, _, unit in found], axis=1),
        )


def start(samples: Samples, kind: str = "cone") -> Carriers:
    """Carriers from the Gauss image: touching at the middle ruling, mean bend and swing."""
    arc, bend, swing = turning(samples)
    middle = len(samples.t) // 2
    origin = samples.points(np.array([0.5]))[:, middle, 0]
    frame = frames(samples.rulings[:, middle], samples.normals()[:, middle])
    square = np.maximum(dot(arc, arc), 1e-300)
    # d = z + k y^2 / 2: with the normal n towards +z and turning by `bend`, n . m = k y.
    k, g = dot(arc, bend) / square, dot(arc, swing) / square
    free = _FREE[kind]
    return Carriers(origin, frame, k * free[4], g * free[5])


def fit(
    targets: Targets,
    guess: Carriers,
    kind: str,
    size: Array,
    powers: tuple[float, ...] = (2.0, 4.0, 8.0, 16.0),
    steps: int = 30,
) -> Carriers:
    """Carriers of one kind closest to their targets.

    Parameters
    ----------
    guess : Carriers
        Start, one a panel, of the kind itself ("rolled": a cylinder that keeps its k).
    size : (p,) array
        Length unit of each panel.
    powers : tuple of float
        Norms passed through; the last approaches the largest residual.
    steps : int
        Most steps in each norm.
    """
    # Panels are independent of each other: a few at a time stay in the processor's cache, and
    # numpy lets threads run side by side.
    parts = np.array_split(np.arange(len(guess)), max(1, len(guess) // _TOGETHER))

    def some(index: IntArray) -> Carriers:
        return _fit(targets[index], guess[index], kind, size[index], powers, steps)

    if len(parts) == 1:
        return some(parts[0])
    with ThreadPoolExecutor(min(len(parts), os.cpu_count() or 1)) as threads:
        return Carriers.joined(list(threads.map(some, parts)))


def _fit(
    targets: Targets,
    guess: Carriers,
    kind: str,
    size: Array,
    powers: tuple[float, ...],
    steps: int,
) -> Carriers:
    centre = guess.origin
    carriers = Carriers(np.zeros_like(centre), guess.frame, guess.k * size, guess.g * size)
    scaled = targets.scaled(centre, size)
    for power in powers:
        # Norms on the way need no more than to lead to the last.
        gain = (0.0 if power == 2.0 else 1e-5) if power == powers[-1] else 1e-2
        carriers = _descend(scaled, carriers, _FREE[kind], power, steps, gain)
    origin = centre + carriers.origin * size[:, None]
    return Carriers(origin, carriers.frame, carriers.k / size, carriers.g / size)


def _descend(
    targets: Targets, carriers: Carriers, free: Array, power: float, steps: int, enough: float
) -> Carriers:
    """Levenberg-Marquardt on the sum of |r|^power, every panel with its own damping.

    A panel is done when a step gains no more than the share `enough` of its sum.
    """
    count = len(carriers)
    damping = np.full(count, 1e-3)
    best = carriers
    r, jac = targets.residuals(carriers)
    unit = np.maximum(np.abs(r).max(axis=1), 1e-300)  # fixed within a norm: powers stay finite
    value = _objective(r, unit, power)
    active = np.arange(count)
    for _ in range(steps):
        step = _step(
            r[active] / unit[active, None], jac[active], unit[active], free, power, damping[active]
        )
        trial = best[active].moved(step)
        new_r, new_jac = targets[active].residuals(trial)
        new_value = _objective(new_r, unit[active], power)
        better = new_value <= value[active]
        gain = value[active] - new_value
        done = better & (gain <= enough * value[active]) & (enough > 0.0)
        done |= np.abs(step).max(axis=1) < 1e-15
        done |= damping[active] > 1e8
        chosen = active[better]
        best = _put(best, chosen, trial[better])
        r[chosen], jac[chosen], value[chosen] = new_r[better], new_jac[better], new_value[better]
        damping[active] = np.where(better, damping[active] * 0.1, damping[active] * 10.0)
        damping = np.maximum(damping, 1e-14)
        active = active[~done]
        if len(active) == 0:
            break
    return best


def _objective(r: Array, unit: Array, power: float) -> Array:
    return (np.abs(r / unit[:, None]) ** power).sum(axis=1)


def _step(r: Array, jac: Array, unit: Array, free: Array, power: float, damping: Array) -> Array:
    """Damped Gauss-Newton step; the p-norm's Hessian is (p - 1) times the weighted one."""
    weight = np.abs(r) ** (power - 2.0) if power > 2.0 else np.ones_like(r)
    jac = jac * free / unit[:, None, None]
    scale = np.sqrt(np.einsum("psi,psi,ps->pi", jac, jac, weight))
    # A step that changes nothing (the turning rate of a plane's rulings) stays where it is.
    scale = np.maximum(scale, 1e-10 * scale.max(axis=1, keepdims=True) + 1e-290)
    jac = jac / scale[:, None]
    across = jac.transpose(0, 2, 1)
    normal = across @ (jac * weight[..., None])
    normal += damping[:, None, None] * np.eye(6) + np.diag(1.0 - free)
    right = -(across @ (weight * r)[..., None]) / (power - 1.0)
    step = np.linalg.solve(normal, right)[..., 0] / scale * free
    return np.clip(step, -_LONGEST, _LONGEST)


def _put(into: Carriers, index: IntArray, values: Carriers) -> Carriers:
    arrays = []
    for name in ("origin", "frame", "k", "g"):
        array = getattr(into, name).copy()
        array[index] = getattr(values, name)
        arrays.append(array)
    return Carriers(*arrays)


def best_fit(samples: Samples, kind: ShapeKind, polish: bool = True) -> Carriers:
    """Best carriers of one kind for whole patches.

    Parameters
    ----------
    samples : Samples
        The patches as trimmed.
    kind : str
        "flat", "cylinder" or "cone".
    polish : bool
        Go on from least squares to (nearly) the smallest largest distance.
    """
    v = np.array([0.0, 0.5, 1.0])
    points = samples.points(v).reshape(len(samples), -1, 3)
    powers = (2.0, 4.0, 8.0, 16.0) if polish else (2.0,)
    return fit(Targets.of_points(points), start(samples, kind), kind, samples.size, powers)
