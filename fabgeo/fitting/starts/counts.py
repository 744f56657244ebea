"""How many strips and segments: from a sag target, or as asked if the surface can hold them.

Strips of width L on a normal curvature kappa stay within kappa L^2 / 16 of the surface (half the
chord's sag inside, half outside), so L = sqrt(16 sag / kappa).
"""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import checked_number, unit
from fabgeo.errors import InputError
from fabgeo.fitting.starts.net import Net
from fabgeo.surfaces.base import DesignSurface, size_of

SAG_SHARE = 1.0 / 3000.0  # of the surface's size, where no sag is asked for
FEWEST, MOST = 8, 60  # strips chosen without being asked
TURN = np.radians(15.0)  # of an edge's tangent in one segment, where segments are chosen


def counts(
    net: Net, surface: DesignSurface, strips: int | None, segments: int | None, sag: float | None
) -> tuple[int, int, str]:
    """Numbers of strips and segments, with a note on how they were found.

    Raises
    ------
    InputError
        If the surface can't hold the strips asked for: fewer than one (closed: three), or narrower
        than a ten-thousandth of the surface's size.
    """
    x = (np.arange(13) + 0.5) / 13.0
    s, t = (np.asarray(a) for a in np.meshgrid(x, x, indexing="ij"))
    across, along = net.evaluate(s, t, 1, 0), net.evaluate(s, t, 0, 1)
    width = float(np.linalg.norm(across, axis=-1).mean())
    length = float(np.linalg.norm(along, axis=-1).mean())
    note = ""
    if sag is not None:
        checked_number("sag", sag, above=0.0)
    if strips is None:
        target = sag if sag is not None else SAG_SHARE * size_of(surface)
        at = surface.closest(net.evaluate(s, t).reshape(-1, 3))
        kappa = np.abs(at.normal_curvature(unit(across.reshape(-1, 3))))
        reach = np.linalg.norm(across, axis=-1).ravel()
        needed = float(np.quantile(reach * np.sqrt(kappa / (16.0 * target)), 0.95))
        strips = int(np.clip(np.ceil(needed), FEWEST, MOST))
        note = f"{strips} strips, so that kappa L^2 / 16 is about {target:.3g}"
    check_strips(strips, net.closed_s, width, size_of(surface))
    if segments is None:
        least = 24 if net.closed_t else 6
        wanted = max(length / (1.5 * width / strips), _turn(net) / TURN)
        segments = int(np.clip(np.ceil(wanted), least, 60))
    elif segments < (3 if net.closed_t else 1):
        raise InputError("segments", f"expected at least 3 round, 1 along, found {segments}")
    return strips, segments, note


def _turn(net: Net) -> float:
    """The largest total turn of a line s = const."""
    s, t = np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 65)
    grid = np.meshgrid(s, t, indexing="ij")
    tangent = unit(net.evaluate(grid[0], grid[1], 0, 1))
    return float(np.linalg.norm(np.diff(tangent, axis=1), axis=2).sum(axis=1).max())


def check_strips(strips: int, closed: bool, width: float, size: float) -> None:
    """Raise InputError if a surface `width` wide can't hold so many strips."""
    least = 3 if closed else 1
    if strips < least:
        raise InputError(
            "strips",
            f"expected at least {least}"
            + (" for a closed ring of strips" if closed else "")
            + f", found {strips}",
        )
    if width / strips < 1e-4 * size:
        raise InputError(
            "strips",
            f"{strips} strips across {width:.4g} would be {width / strips:.3g} wide, less than a "
            "ten-thousandth of the surface's size",
            f"ask for at most {int(width / (1e-4 * size))}",
        )
