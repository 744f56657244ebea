"""Which property of a surface keeps developable strips from following it, and where.

On a developable strip, ruling and edge have conjugate directions: t . S e = 0. What keeps models
off:

- where a held boundary runs along an asymptotic direction: it is its own conjugate, and rulings
  along it would need edges that follow it too;
- where edges do so inside: rulings would have to fall into the edges;
- where the surface is nearly single-curved (its Gaussian curvature changes its sign there, or it
  ends a developable): rulings must take its one straight direction, whatever the edges do;
- at umbilics, about which directions turn;
- where the surface turns too much across one strip, as over a crease.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.fitting.held import Held
from fabgeo.fitting.objectives.base import State
from fabgeo.fitting.reference import Reference, Side
from fabgeo.fitting.samples import Net, Sites
from fabgeo.strips.model import Kind

LEAST_ANGLE = np.radians(15.0)  # between a direction and its conjugate
LEAST_TWIST = np.radians(0.2)  # of the surface along one ruling: less does not matter
SINGLE_CURVED = 0.1  # smaller over larger principal curvature, up to which it is called so
UMBILIC = 0.15  # difference of the principal curvatures over their sum
_PRINCIPAL = "let strips follow the principal directions (start 'principal')"
_SEVERAL = (
    "where geodesics spread or meet, the rulings conjugate to them do too: cover the surface by "
    "several models side by side (strips.part)"
)
CONJUGATE = 3.0  # degrees up to which rulings are called conjugate to the edges
TURN = np.radians(25.0)  # of the surface's normal along one ruling


def obstacle(
    state: State,
    held: Held,
    place: tuple[int, float] | None,
    tried: Collection[str] = (),
    kind: Kind = "general",
) -> str:
    """What keeps a model off its surface, in words, each with strip or edge and u.

    Parameters
    ----------
    state : State
        The model as the fit left it.
    held : Held
    place : (int, float) or None
        Strip and u that are looked into: where it twists or deviates most.
    tried : collection of str
        Methods of a start that were tried, which are not advised again.
    kind : str
        Of the model: edges of a geodesic one cannot be turned to the principal directions.
    """
    words = _borders(state.net, state.control, state.reference, held)
    if place is not None:
        strip, u = place
        bound = bool(held.edges or held.ends)
        geodesic = kind == "geodesic"
        advise = "principal" not in tried and not geodesic
        words.append(_inside(state, strip, u, advise, bound, geodesic))
    return "; ".join(words)


def _borders(net: Net, control: Array, reference: Reference, held: Held) -> list[str]:
    """Where a held border runs along an asymptotic direction."""
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
    return words


def _inside(state: State, strip: int, u: float, advise: bool, bound: bool, geodesic: bool) -> str:
    """What the surface is like at a place; `advise` principal strips, a `bound` border freed."""
    net, reference = state.net, state.reference
    sites = Sites(net, np.array([[min(u, net.segments - 1e-9)]]), np.ones((1, 1)))
    first, second = net.windows(2)[strip]
    points, slopes = sites.evaluate(state.control)[:, 0, 0], sites.evaluate(state.control, 1)
    ruling = points[second] - points[first]
    middle = ((points[first] + points[second]) / 2.0)[None]
    found = reference.surface.closest(middle * reference.length)
    normal, shape = found.normal[0], found.shape[0] * reference.length
    ends = reference.surface.closest(points[[first, second]] * reference.length).normal
    edge = _tangent(slopes[first, 0, 0] + slopes[second, 0, 0], normal)
    along = _tangent(ruling, normal)
    conjugate = unit(np.cross(normal, shape @ edge)[None])[0]
    (kappa,), (axes,) = (part for part in found.principal())
    x, y, z = found.point[0]
    place = f"strip {strip}, u = {u:.2f}, near ({x:.4g}, {y:.4g}, {z:.4g}): "
    large, small = np.abs(kappa)
    turn = float(np.arccos(np.clip(dot(ends[:1], ends[1:])[0], -1.0, 1.0)))
    if turn > TURN:
        return place + (
            f"the surface turns by {np.degrees(turn):.0f} degrees across this one strip (a "
            "crease or a small radius): take more strips, or divide the surface there"
        )
    if small < SINGLE_CURVED * large:
        return place + (
            "the surface is nearly single-curved there (its Gaussian curvature vanishes or changes "
            "its sign): rulings must take its straight direction, which is "
            f"{_degrees(along, axes[1]):.0f} degrees away from this strip's"
            + _cures(advise and _PRINCIPAL, "divide the surface along that line")
        )
    if abs(kappa[0] - kappa[1]) < UMBILIC * (large + small):
        return place + (
            "the surface is nearly umbilic there: principal directions are not defined and turn "
            "about it"
        )
    if kappa[0] * kappa[1] < 0.0 and _degrees(edge, conjugate) < np.degrees(LEAST_ANGLE):
        return place + (
            "edges run along an asymptotic direction of the surface (its own conjugate is "
            f"{_degrees(edge, conjugate):.0f} degrees away): no rulings lead across them"
            + _cures(advise and "turn the edges by 45 degrees (start 'principal')")
        )
    away = _degrees(along, conjugate)
    if away < CONJUGATE:
        return place + (
            "rulings are conjugate to the edges there; what is left is how the surface changes "
            "within one strip and segment: take more of them"
        )
    return place + (
        f"the direction conjugate to the edges is {away:.0f} degrees away from the rulings, which "
        f"neighbouring strips {'or the boundary ' * bound}hold there"
        + _cures(advise and _PRINCIPAL, geodesic and _SEVERAL, bound and "free the border")
    )


def _cures(*cures: str | bool) -> str:
    said = [cure for cure in cures if isinstance(cure, str)]
    return f"; {', or '.join(said)}" if said else ""


def _tangent(vector: Array, normal: Array) -> Array:
    return unit((vector - (vector @ normal) * normal)[None])[0]


def _degrees(a: Array, b: Array) -> float:
    """Angle of two undirected unit vectors."""
    return float(np.degrees(np.arccos(np.clip(abs(a @ b), 0.0, 1.0))))


def _worst(points: Array, reference: Reference, side: Side) -> tuple[float, int]:
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
