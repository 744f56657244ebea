"""How good an initial strip model is, measured before any fit.

Glossary
--------
twist
    Angle between a strip's normals at the two ends of one ruling; zero for a developable strip.
fold
    A place where a strip's normal points to the other side of the surface than elsewhere.
coverage
    Share of points spread over the surface that the model covers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from fabgeo.arrays import Array, BoolArray, cross, dot, unit
from fabgeo.errors import GeometryError
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import DesignSurface


@dataclass(frozen=True)
class Quality:
    """Figures of a start; angles in degrees, lengths in the surface's unit.

    Attributes
    ----------
    twist_max, twist_rms : float
        Largest and root mean square twist.
    twist_at, fold_at : tuple of int and float, or None
        Strip and u of the largest twist, of the first fold.
    folds : float
        Share of the sampled rulings that are folded.
    width_ratio : float
        Largest over mean ruling length.
    coverage : float
        Between 0 and 1.
    """

    twist_max: float
    twist_rms: float
    twist_at: tuple[int, float]
    folds: float
    fold_at: tuple[int, float] | None
    width_ratio: float
    coverage: float

    def __str__(self) -> str:
        return (
            f"twist {self.twist_rms:.2f} deg rms, {self.twist_max:.2f} max, "
            f"coverage {100.0 * self.coverage:.0f} %, widest ruling {self.width_ratio:.2f} of the "
            f"mean" + (f", {100.0 * self.folds:.1f} % folded" if self.folds else "")
        )


def quality(model: StripModel, surface: DesignSurface, samples: int = 400) -> Quality:
    """Measure a model against the surface it starts from."""
    u = model.parameters(2)
    first, second = model.pairs(model.points(u))
    t0, t1 = model.pairs(unit(model.points(u, 1)))
    ruling = second - first
    length = np.linalg.norm(ruling, axis=-1)
    e = unit(ruling)
    normal = unit(np.stack([cross(t0, e), cross(t1, e)]))
    twist = np.degrees(
        np.arctan2(np.linalg.norm(cross(normal[0], normal[1]), axis=-1), dot(normal[0], normal[1]))
    )
    middle = surface.closest(((first + second) / 2.0).reshape(-1, 3))
    folded = _folded(normal, middle.normal.reshape((*length.shape, 3)))
    beside = middle.on_boundary.reshape(length.shape)
    if not beside.all():  # what overhangs will be trimmed: its twist does not count
        twist = np.where(beside, 0.0, twist)
    worst = np.unravel_index(int(np.argmax(twist)), twist.shape)
    place = np.argwhere(folded)
    return Quality(
        float(twist.max()),
        float(np.sqrt(np.mean(twist**2))),
        (int(worst[0]), float(u[worst[1]])),
        float(folded.mean()),
        (int(place[0, 0]), float(u[place[0, 1]])) if len(place) else None,
        float(length.max() / max(length.mean(), 1e-300)),
        coverage(model, surface, samples),
    )


def _folded(normal: Array, reference: Array) -> BoolArray:
    """Whether either end's normal lies on the other side than the majority: (strips, k)."""
    side = dot(normal, reference[None])
    majority = 1.0 if np.sum(np.sign(side)) >= 0.0 else -1.0
    return np.any(side * majority <= 0.0, axis=0)


def coverage(model: StripModel, surface: DesignSurface, samples: int = 400) -> float:
    """Share of points spread over the surface that the model covers."""
    return float(np.mean(covered(model, surface.sample(samples).point)))


def covered(model: StripModel, points: Array) -> BoolArray:
    """Whether points (k, 3) lie within about a mesh width of the model's own dense points."""
    u = model.parameters(4)
    first, second = model.pairs(model.points(u))
    v = np.linspace(0.0, 1.0, 5)[:, None, None, None]
    grid = (1.0 - v) * first + v * second
    along = np.linalg.norm(np.diff(grid, axis=2), axis=-1)
    across = np.linalg.norm(second - first, axis=-1)
    reach = 0.75 * max(float(np.quantile(along, 0.9)), float(np.quantile(across, 0.9)) / 4.0)
    sag = float(np.quantile(across, 0.9)) / 8.0
    far, _ = KDTree(grid.reshape(-1, 3)).query(points)
    return np.asarray(far) <= np.hypot(reach, sag)


def check_folds(model: StripModel, surface: DesignSurface, name: str) -> None:
    """Raise if a start folds, naming strip and u.

    Raises
    ------
    GeometryError
        Naming the first folded strip and its parameter.
    """
    found = quality(model, surface, samples=1)
    if found.fold_at is not None:
        strip, u = found.fold_at
        raise GeometryError(
            f"strip {strip}, u = {u:.2f}",
            f"the start '{name}' folds over there ({100.0 * found.folds:.1f} % of its rulings "
            "point to the other side of the surface)",
            "choose another start, another direction or fewer strips",
        )
