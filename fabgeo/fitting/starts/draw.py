"""From a net to a strip model with the numbers of strips and segments wanted."""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array
from fabgeo.fitting.starts.conjugate import conjugate_parameters
from fabgeo.fitting.starts.counts import counts
from fabgeo.fitting.starts.net import Net, model_through
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import DesignSurface


def model_of_net(
    net: Net,
    surface: DesignSurface,
    strips: int | None = None,
    segments: int | None = None,
    *,
    sag: float | None = None,
    conjugate: bool = True,
    project: bool = True,
    ends: str = "held",
    places: Array | None = None,
) -> tuple[StripModel, list[str]]:
    """A strip model whose edges are lines s = const of a net on a surface.

    Parameters
    ----------
    strips, segments : int, optional
        By default from the sag.
    sag : float, optional
        Deviation kappa L^2 / 16 that the strips' width is chosen for.
    conjugate : bool
        Whether corresponding points may move along the edges to make rulings conjugate.
    project : bool
        Whether edge points are brought to the surface (not those beside its boundary).
    ends : "held" or "free"
        See `conjugate_parameters`.
    places : (E,) array, optional
        Values of s of the edges, evenly spaced by default.

    Returns
    -------
    model : StripModel
    notes : list of str
    """
    strips, segments, note = counts(net, surface, strips, segments, sag)
    notes = [note] if note else []
    s = net.places(strips) if places is None else places
    t = np.broadcast_to(net.stations(segments), (len(s), segments + (not net.closed_t)))
    if conjugate:
        t, note = conjugate_parameters(net, s, segments, ends)
        notes.append(note)
    points = net.sampled(s, t)
    if project:
        points = projected(surface, points)
    return model_through(points, net.closed_t, net.closed_s), notes


def projected(surface: DesignSurface, points: Array) -> Array:
    """Points brought to the surface, those that lie beside its boundary kept."""
    at = surface.closest(points.reshape(-1, 3))
    kept = at.on_boundary[:, None]
    return np.where(kept, points.reshape(-1, 3), at.point).reshape(points.shape)
