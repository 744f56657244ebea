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

from fabgeo.arrays import Array, checked_count, dot, unit
from fabgeo.fitting.starts.geodesic import geodesic_start, part_seed
from fabgeo.fitting.starts.quality import covered
from fabgeo.strips.model import StripModel, check_model
from fabgeo.surfaces.base import DesignSurface, check_surface

MOST_MODELS = 1000


@dataclass(frozen=True)
class Covering:
    """Geodesic strip models that cover a surface together.

    Attributes
    ----------
    models : tuple of StripModel
        Initial models of kind "geodesic", each overhanging the surface's boundary at its ends. Fit
        each with `FitOptions(points=seam_points(model, surface))`.
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
        Number of strip models, up to 1,000.
    strips, segments : int, optional
        Of each model; by default from its sag.
    direction : "u", "v" or (3,) array_like, optional
        Where the geodesics run; see `geodesic_start`. The models follow one another across it.

    Raises
    ------
    InputError
        If one of the arguments is something else.
    """
    check_surface("cover", surface)
    checked_count("covering: models", models, 1, MOST_MODELS)
    parts = [(k + 1, models) for k in range(models)]
    seeds = [part_seed(surface, part, direction) for part in parts]
    started = [geodesic_start(surface, strips, segments, direction, part=p)[0] for p in parts]
    found = [model.with_control(model.control, kind="geodesic") for model in started]
    widths = tuple(_widths(m, surface) for m in found)
    return Covering(tuple(found), tuple(seeds), _coverage(found, surface), widths)


def seam_points(model: StripModel, surface: DesignSurface) -> Array:
    """Points (k, 3) beside both outer edges of a start, for `FitOptions.points` of its fit.

    Fitted to them, models side by side still meet afterwards. They lie off the surface as free
    edges do: by the sag limit `kappa L^2 / 16` of the rulings that end there, whose middles lie as
    far off it on the other side.
    """
    check_model("seam_points", model)
    check_surface("seam_points", surface)
    points = model.points(model.parameters(2))
    outer, inner = points[[0, -1]].reshape(-1, 3), points[[1, -2]].reshape(-1, 3)
    at, ruling = surface.closest(outer), inner - outer
    lift = at.normal_curvature(unit(ruling)) * dot(ruling, ruling) / 16.0
    return outer - lift[:, None] * at.normal


def _coverage(models: list[StripModel], surface: DesignSurface, samples: int = 600) -> float:
    points = surface.sample(samples).point
    return float(np.mean(np.any([covered(m, points) for m in models], axis=0)))


def _widths(model: StripModel, surface: DesignSurface) -> tuple[float, float]:
    first, second = model.pairs(model.points(model.parameters(2)))
    length = np.linalg.norm(second - first, axis=-1).ravel()
    inside = ~surface.closest(((first + second) / 2.0).reshape(-1, 3)).on_boundary
    kept = length[inside] if inside.any() else length
    return float(kept.min() / kept.mean()), float(kept.max() / kept.mean())
