"""Start from iso-parameter curves: the surface's own, or those of a net between its boundaries.

Directions
----------
"v"
    Edges run along v (u = const): strips lie side by side in u.
"u"
    Edges run along u.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from fabgeo.arrays import checked_number, shown
from fabgeo.errors import InputError
from fabgeo.fitting.starts.domain import net_of_loops
from fabgeo.fitting.starts.draw import model_of_net
from fabgeo.fitting.starts.ends import steep_ends
from fabgeo.fitting.starts.net import Net
from fabgeo.fitting.starts.overhang import overhanging, shortened
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import DesignSurface
from fabgeo.surfaces.trace_chart import Parametrised
from fabgeo.surfaces.trace_extension import Extended

STEEP_OVERHANG = 0.2
LONGEST = 10.0  # overhang, in parts of the edges' length


def _shares(overhang: Any) -> tuple[float, float]:
    """The overhang at both ends, in parts of the edges' length, checked."""
    several = isinstance(overhang, tuple | list) or getattr(overhang, "ndim", 0) == 1
    pair = list(overhang) if several else [overhang, overhang]
    if len(pair) != 2:
        raise InputError("overhang", f"expected one number or two, found {shown(overhang)}")
    first, second = (checked_number("overhang", share) for share in pair)
    if max(first, second) > LONGEST or min(first, 0.0) + min(second, 0.0) <= -1.0:
        raise InputError(
            "overhang",
            f"expected {LONGEST:g} at most, and edges that keep some length, found {first:g} and "
            f"{second:g}",
        )
    return first, second


def iso_start(
    surface: DesignSurface,
    strips: int | None,
    segments: int | None,
    direction: str | None = None,
    seed: Any = None,
    *,
    overhang: float | tuple[float, float] | None = None,
    across: bool = False,
    corners: npt.ArrayLike | None = None,
    **options: Any,
) -> tuple[StripModel, list[str]]:
    """Edges along iso-parameter curves, rulings made conjugate where that stays monotone.

    Parameters
    ----------
    direction : "v" or "u", optional
        Along which the edges run, "v" by default.
    overhang : float or (float, float), optional
        How far edges reach beyond the boundary at their two ends, in parts of their length. By
        default 0, but 0.2 at an end whose boundary runs in asymptotic directions (see `ends.py`).
        Below 0 edges stop short of it: where a boundary goes round a corner smoothly, edge and
        ruling have one direction there, and no strip reaches it.
    across : bool
        Whether strips overhang sideways as well, by the same shares of the surface's width.
    corners : (4, 3) array_like, optional
        Where the boundary is divided into four sides (see `domain.net_of_loops`); lines between
        them are taken even where the surface has parameter lines of its own.
    """
    net, note = iso_net(surface, corners=corners)
    direction = "v" if direction is None else direction
    if not isinstance(direction, str) or direction not in ("u", "v"):
        problem = f"expected 'u' or 'v' (edges along it), found {shown(direction)}"
        raise InputError("direction", problem)
    net = net if direction == "v" else net.turned
    steep, told = steep_ends(net, surface)
    if overhang is None:
        shares = STEEP_OVERHANG * steep[0], STEEP_OVERHANG * steep[1]
    else:
        shares = _shares(overhang)
    if min(shares) < 0.0 and not net.closed_t:
        net = shortened(net, (max(-shares[0], 0.0), max(-shares[1], 0.0)))
        notes = [f"edges end {100 * -x:.3g} % short of the boundary" for x in shares if x < 0.0]
        told, shares = [*told, *notes], (max(shares[0], 0.0), max(shares[1], 0.0))
    if any(shares) and not (net.closed_t and (net.closed_s or not across)):
        reach = Extended(surface)
        net = overhanging(net, reach, shares, across)
        model, notes = model_of_net(net, reach, strips, segments, **options)
        notes.append(f"edges overhang by {100 * shares[0]:.0f} and {100 * shares[1]:.0f} %")
    else:
        model, notes = model_of_net(net, surface, strips, segments, **options)
    return model, [note, *told, *notes]


def iso_net(
    surface: DesignSurface, size: int = 33, corners: npt.ArrayLike | None = None
) -> tuple[Net, str]:
    """The net of parameter lines (rows u, columns v), or one between the boundary loops."""
    chart = parametrisation(surface)
    if chart is None or corners is not None:
        return net_of_loops(surface, corners=corners)
    (u0, u1), (v0, v1) = chart.domain
    closed_u, closed_v = chart.closed
    u = np.linspace(u0, u1, size + closed_u)[: size if closed_u else None]
    v = np.linspace(v0, v1, size + closed_v)[: size if closed_v else None]
    grid_u, grid_v = np.meshgrid(u, v, indexing="ij")
    found = chart.evaluate(grid_u.ravel(), grid_v.ravel())
    points = np.asarray(getattr(found, "point", found)).reshape(*grid_u.shape, 3)
    return Net(points, closed_u, closed_v), "the surface's own parameter lines"


def parametrisation(surface: Any) -> Any | None:
    """What answers by parameters for the whole surface: itself, or its only, untrimmed chart."""
    charts, trims = getattr(surface, "charts", ()), getattr(surface, "trims", (None,))
    if len(charts) == 1 and trims[0] is None:
        return charts[0]
    return surface if isinstance(surface, Parametrised) else None
