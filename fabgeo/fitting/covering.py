"""Cover a freeform interior by several geodesic strip models (paper, Fig. 5).

Glossary
--------
patch of a covering
    One geodesic strip model, side by side with its neighbours.
seam
    The geodesic that neighbouring models share: it leaves from where their pieces of one geodesic
    across the surface meet.

Strips come nearer to a surface as they get narrower, so models shrink whose outer edges nothing
holds: seams are to be fitted to as well.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.fitting.starts.geodesic import geodesic_start, part_seed
from fabgeo.fitting.starts.quality import covered
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import DesignSurface


@dataclass(frozen=True)
class Covering:
    """Geodesic strip models that cover a surface together.

    Attributes
    ----------
    models : tuple of StripModel
        Initial models of kind "geodesic", each overhanging the surface's boundary at its ends. Fit
        each with `FitOptions(points=seam_points(model))`.
    seeds : tuple of (k, 3) arrays
        The curve that the geodesics of each cross at right angles.
    coverage : float
        Share of the surface that the models cover together.
    widths : tuple of (float, float)
        Smallest and largest ruling over the mean, within the surface, of each model.
    """

    models: tuple[StripModel, ...]
    seeds: tuple[Array, ...]
    coverage: float
    widths: tuple[tuple[float, float], ...]


def cover(
    surface: DesignSurface,
    models: int = 5,
    strips: int | None = None,
    segments: int | None = None,
    direction: Any = None,
) -> Covering:
    """Several geodesic starts side by side that cover a surface; one alone: `part` of its start.

    Parameters
    ----------
    models : int
        Number of strip models.
    strips, segments : int, optional
        Of each model; by default from its sag.
    direction : "u", "v" or (3,) array_like, optional
        Where the geodesics run; see `geodesic_start`. The models follow one another across it.

    Raises
    ------
    InputError
        If there is no model asked for.
    """
    if models < 1:
        raise InputError("covering", f"expected one model or more, found {models}")
    parts = [(k + 1, models) for k in range(models)]
    seeds = [part_seed(surface, part, direction) for part in parts]
    started = [geodesic_start(surface, strips, segments, direction, part=p)[0] for p in parts]
    found = [model.with_control(model.control, kind="geodesic") for model in started]
    widths = tuple(_widths(m, surface) for m in found)
    return Covering(tuple(found), tuple(seeds), _coverage(found, surface), widths)


def seam_points(model: StripModel) -> Array:
    """Points (k, 3) on both outer edges of a start, for `FitOptions.points` of its fit.

    Fitted to them, models side by side still meet afterwards.
    """
    u = model.parameters(2)
    return model.points(u)[[0, -1]].reshape(-1, 3)


def _coverage(models: list[StripModel], surface: DesignSurface, samples: int = 600) -> float:
    points = surface.sample(samples).point
    return float(np.mean(np.any([covered(m, points) for m in models], axis=0)))


def _widths(model: StripModel, surface: DesignSurface) -> tuple[float, float]:
    first, second = model.pairs(model.points(model.parameters(2)))
    length = np.linalg.norm(second - first, axis=-1).ravel()
    inside = ~surface.closest(((first + second) / 2.0).reshape(-1, 3)).on_boundary
    kept = length[inside] if inside.any() else length
    return float(kept.min() / kept.mean()), float(kept.max() / kept.mean())
