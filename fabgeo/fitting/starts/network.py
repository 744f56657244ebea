"""Start from a network of two given curve families; its conjugacy is measured.

Glossary
--------
conjugacy defect
    The angle between a column and the direction conjugate to the row on the surface: zero for a
    conjugate network, the smooth kin of developable strips.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from fabgeo.arrays import Array, checked, cross, unit
from fabgeo.errors import GeometryError, InputError
from fabgeo.fitting.starts.crossings import crossings
from fabgeo.fitting.starts.draw import model_of_net
from fabgeo.fitting.starts.net import Net
from fabgeo.fitting.starts.polyline import even
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import DesignSurface
from fabgeo.surfaces.trace import conjugate_direction


def network_start(
    surface: DesignSurface,
    strips: int | None,
    segments: int | None,
    direction: str | None = None,
    seed: tuple[Sequence[npt.ArrayLike], Sequence[npt.ArrayLike]] | npt.ArrayLike | None = None,
    **options: Any,
) -> tuple[StripModel, list[str]]:
    """Edges along the rows of a given network, rulings along its columns.

    Parameters
    ----------
    seed : two sequences of (k, 3) curves, or a (rows, columns, 3) array of nodes
        The curves that become edges, and those that become rulings.
    direction : "u", optional
        Exchanges the two families.
    """
    if seed is None:
        raise InputError("start 'network'", "expected two families of curves as seed, found none")
    net = network_net(seed)
    if direction == "u":
        net = net.turned
    defect = conjugacy_defect(net, surface)
    note = f"conjugacy defect {np.degrees(np.sqrt(np.mean(defect**2))):.2f} deg rms"
    options.setdefault("conjugate", False)
    model, notes = model_of_net(net, surface, strips, segments, **options)
    return model, [note, *notes]


def network_net(seed: Any) -> Net:
    """The net of two families of curves, or of an array of nodes.

    Raises
    ------
    GeometryError
        Naming two curves that do not cross.
    """
    if isinstance(seed, np.ndarray) and seed.ndim == 3:
        return Net(seed)
    rows, columns = ([checked("network curve", c, (None, 3)) for c in family] for family in seed)
    nodes = crossings(
        np.stack([even(c, 65) for c in rows]), np.stack([even(c, 65) for c in columns])
    )
    missing = np.argwhere(~np.isfinite(nodes).all(axis=2))
    if len(missing):
        i, j = missing[0]
        raise GeometryError(
            f"network curves {i} and {j}",
            "do not cross: every curve of one family must cross every curve of the other",
            "extend them, or leave one out",
        )
    return Net(nodes)


def conjugacy_defect(net: Net, surface: DesignSurface, size: int = 15) -> Array:
    """Angles (k,) between columns and the directions conjugate to the rows, in radians."""
    x = (np.arange(size) + 0.5) / size
    s, t = (a.ravel() for a in np.meshgrid(x, x, indexing="ij"))
    at = surface.closest(net.evaluate(s, t))
    along, across = unit(net.evaluate(s, t, 0, 1)), unit(net.evaluate(s, t, 1, 0))
    wanted = conjugate_direction(at, along)
    return np.arcsin(np.clip(np.linalg.norm(cross(across, wanted), axis=1), 0.0, 1.0))
