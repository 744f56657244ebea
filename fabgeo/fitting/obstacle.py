"""Which property of a surface forbids that strips follow its boundary, and where.

On a developable strip, ruling and edge have conjugate directions. Where the boundary runs along
an asymptotic direction it is its own conjugate: rulings that follow it would need edges that
follow it too, so a model held there can only stand off the surface or twist.
"""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import cross, dot
from fabgeo.fitting.held import Held
from fabgeo.fitting.reference import Reference, Side
from fabgeo.fitting.samples import Net, Sites

LEAST_ANGLE = np.radians(15.0)  # between the boundary and its conjugate direction
LEAST_TWIST = np.radians(0.2)  # of the surface along one ruling: less does not matter


def obstacle(net: Net, control: np.ndarray, reference: Reference, held: Held) -> str:
    """Where a held border runs along an asymptotic direction, in words; "" if nowhere.

    Parameters
    ----------
    net : Net
    control : (edges, columns, 3) array
        In the fit's unit.
    reference : Reference
    held : Held
    """
    words = []
    for end, side in held.ends.items():
        angle, at = _worst(Sites.at_end(net, bool(end)).evaluate(control), reference, side)
        if angle < LEAST_ANGLE:
            u = net.segments if end else 0
            words.append(_sentence(f"end u = {u}", f"edge {at}", angle))
    if held.edges:
        sites = Sites.gauss(net, 2)
        points = sites.evaluate(control)
        for edge, side in held.edges.items():
            angle, at = _worst(points[edge], reference, side)
            if angle < LEAST_ANGLE:
                words.append(_sentence(f"edge {edge}", f"u = {sites.u.ravel()[at]:.1f}", angle))
    return "; ".join(words)


def _worst(points: np.ndarray, reference: Reference, side: Side) -> tuple[float, int]:
    """Smallest angle between the boundary and its conjugate direction, and at which point."""
    flat = points.reshape(-1, 3)
    _, tangent = side.closest(flat)
    found = reference.surface.closest(flat * reference.length)
    across = cross(found.normal, tangent)
    bent = np.einsum("kij,kj->ki", found.shape * reference.length, tangent)
    bending, twisting = np.abs(dot(bent, tangent)), np.abs(dot(bent, across))
    angle = np.where(twisting > LEAST_TWIST, np.arctan2(bending, twisting), np.pi / 2.0)
    return float(angle.min()), int(np.argmin(angle))


def _sentence(border: str, place: str, angle: float) -> str:
    return (
        f"the boundary that holds {border} runs along an asymptotic direction of the surface near "
        f"{place} (its conjugate direction is {np.degrees(angle):.0f} degrees away): leave that "
        "border free, or end the surface elsewhere"
    )
