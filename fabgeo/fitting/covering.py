"""Cover a freeform interior by several geodesic strip models (paper, Fig. 5).

Glossary
--------
patch of a covering
    One geodesic strip model; neighbouring patches meet along a border curve across their edges.

The seed curves of the models are consecutive pieces of one geodesic across the surface; neighbours
share the geodesic that leaves from where their pieces meet.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.fitting.starts.draw import model_of_net
from fabgeo.fitting.starts.geodesic import default_seed, geodesic_net
from fabgeo.fitting.starts.polyline import even
from fabgeo.fitting.starts.quality import covered
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import DesignSurface
from fabgeo.surfaces.trace_extension import Extended


@dataclass(frozen=True)
class Covering:
    """Geodesic strip models that cover a surface together.

    Attributes
    ----------
    models : tuple of StripModel
        Initial models of kind "geodesic", each overhanging the surface's boundary.
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
    """Several geodesic starts side by side that cover a surface.

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
    extended = Extended(surface)
    across = default_seed(surface, direction)
    pieces = _pieces(across, models)
    found, seeds = [], []
    for piece in pieces:
        net = geodesic_net(extended, piece)
        model, _ = model_of_net(net, extended, strips, segments)
        found.append(model.with_control(model.control, kind="geodesic"))
        seeds.append(piece)
    widths = tuple(_widths(m, surface) for m in found)
    return Covering(tuple(found), tuple(seeds), _coverage(found, surface), widths)


def _pieces(curve: Array, count: int) -> list[Array]:
    dense = even(curve, 40 * count + 1)
    return [dense[40 * k : 40 * k + 41] for k in range(count)]


def _coverage(models: list[StripModel], surface: DesignSurface, samples: int = 600) -> float:
    points = surface.sample(samples).point
    return float(np.mean(np.any([covered(m, points) for m in models], axis=0)))


def _widths(model: StripModel, surface: DesignSurface) -> tuple[float, float]:
    first, second = model.pairs(model.points(model.parameters(2)))
    length = np.linalg.norm(second - first, axis=-1).ravel()
    inside = ~surface.closest(((first + second) / 2.0).reshape(-1, 3)).on_boundary
    kept = length[inside] if inside.any() else length
    return float(kept.min() / kept.mean()), float(kept.max() / kept.mean())
