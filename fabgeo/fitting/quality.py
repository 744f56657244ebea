"""What a fit watches to know when it is done; the verdict on a model is `strips.measures`'."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from fabgeo.arrays import Array, cross, dot, unit
from fabgeo.fitting.objectives.base import State
from fabgeo.fitting.objectives.circular import Circular
from fabgeo.fitting.objectives.conical import Conical
from fabgeo.fitting.objectives.geodesic import Geodesic
from fabgeo.fitting.samples import Net, Sites
from fabgeo.strips.model import Kind

OVERHANG = 0.1  # in the fit's unit: what lies farther beyond the boundary is cut off later
KIND_TERM = {"conical": Conical, "circular": Circular, "geodesic": Geodesic}


@dataclass(frozen=True)
class Quality:
    """Figures of a model: angles in degrees, lengths in the fit's unit."""

    twist_deg: float
    twist_strip: int
    twist_u: float
    deviation: float
    deviation_strip: int
    deviation_u: float
    deviation_rms: float
    sag_limit: float
    kind_deg: float

    @property
    def deviation_over_sag(self) -> float:
        """Largest deviation by the largest kappa L^2 / 16."""
        return self.deviation / self.sag_limit if self.sag_limit > 0.0 else 0.0

    def plain(self) -> dict[str, float]:
        """As plain data."""
        return {**asdict(self), "deviation_over_sag": self.deviation_over_sag}


def dense_sites(net: Net, per_segment: int = 4) -> Sites:
    """Evenly spaced sites, knots included."""
    local = np.linspace(0.0, 1.0, per_segment + 1)
    u = np.arange(net.segments)[:, None] + local
    return Sites(net, u, np.ones_like(u))


def quality(state: State, sites: Sites, kind: Kind) -> Quality:
    """Figures of the model `state` at the given sites."""
    d0, d1 = (unit(d) for d in state.around(sites, 2, 1))
    p0, p1 = state.around(sites, 2)
    chord = p1 - p0
    e = unit(chord)
    m0, m1 = unit(cross(d0, e)), unit(cross(d1, e))
    twist = np.arctan2(np.linalg.norm(cross(m0, m1), axis=-1), dot(m0, m1))
    worst = np.unravel_index(int(np.argmax(twist)), twist.shape)
    edge, middle = state.feet(sites)
    at_edges = dot(state.at(sites) - edge.point, edge.normal)
    at_middles = dot((p0 + p1) / 2.0 - middle.point, middle.normal)
    # What overhangs is cut off: it counts neither in deviations nor in sags.
    off = np.concatenate([edge.beyond.ravel(), middle.beyond.ravel()]) > OVERHANG
    distances = np.where(off, 0.0, np.concatenate([at_edges.ravel(), at_middles.ravel()]))
    # A chord's sag: how much farther its middle lies than its ends, kappa L^2 / 8.
    first, second = state.net.windows(2).T
    sag = np.abs((at_edges[first] + at_edges[second]) / 2.0 - at_middles)
    sag = np.where(middle.beyond > OVERHANG, 0.0, sag)
    term = KIND_TERM.get(kind)
    defect = term(sites).evaluate(state, False)[0] if term and len(term(sites).window) else 0.0
    farthest, column = divmod(int(np.argmax(np.abs(distances))), sites.u.size)
    strips, edges = len(e), len(at_edges)
    return Quality(
        twist_deg=float(np.degrees(twist[worst])),
        twist_strip=int(worst[0]),
        twist_u=float(sites.u[worst[1], worst[2]]),
        deviation=float(np.abs(distances).max()),
        deviation_strip=min(farthest, strips - 1) if farthest < edges else farthest - edges,
        deviation_u=float(sites.u.ravel()[column]),
        deviation_rms=float(np.sqrt(np.sum(distances**2) / max(int(np.sum(~off)), 1))),
        sag_limit=float(sag.max()) / 2.0,
        kind_deg=float(np.degrees(np.abs(defect).max())),
    )


def mean_ruling(control: Array, net: Net) -> float:
    """Mean ruling length of a model: the fit's unit of length."""
    sites = Sites.gauss(net, 1)
    points, window = sites.evaluate(control), net.windows(2)
    return float(np.linalg.norm(points[window[:, 1]] - points[window[:, 0]], axis=-1).mean())
