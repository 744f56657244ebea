"""Candidate placements of every class for every panel, each panel by itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fabgeo.arrays import Array, BoolArray, IntArray
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.certify import deviation
from fabgeo.panels.fit_shape import Targets, fit, start
from fabgeo.panels.limits import Tolerances
from fabgeo.panels.made import end_shift, follows
from fabgeo.panels.pool import CLASSES, Pool, as_fitted
from fabgeo.panels.samples import PanelInput, Samples, boundary_tilt, end_swing, sample
from fabgeo.strips.ruled import RuledPatch

_DENSER = (65, 257)  # samples along a patch where its bound is to be sharpened
_ROWS = np.array([0.0, 1.0])  # along a ruling the distance is nearly linear


def targets_of(
    samples: Samples, deviation_mm: float, edge_mm: float | None, tilt: float | None, swing: Array
) -> Targets:
    """Targets that weigh the whole patch, its boundary and the normals along it.

    Parameters
    ----------
    deviation_mm : float
        Distance that counts as one anywhere.
    edge_mm : float or None
        Distance that counts as one on the boundary; None: no more than elsewhere.
    tilt : float or None
        Angle that counts as one between fitted and replaced normal on the boundary, radians;
        None: normals are free.
    swing : (p, 1) array
        Distance across an end ruling at its ends, between the fitted and the shape's, that counts
        as one; where normals are free, rulings are too.
    """
    count, s = len(samples), len(samples.t)
    points = samples.points(_ROWS)
    unit = np.full((count, s, len(_ROWS)), deviation_mm)
    if edge_mm is not None:
        edge = min(edge_mm, deviation_mm)
        unit[:, :, [0, -1]] = edge
        unit[:, [0, -1]] = edge
    whole = Targets.of_points(points.reshape(count, -1, 3), unit.reshape(count, -1))
    if tilt is None:
        return whole
    at, along = boundary_tilt(samples)
    middle, across, half = end_swing(samples)
    return Targets(
        whole.points,
        whole.unit,
        at,
        along,
        np.zeros(at.shape[:2]),
        np.full(at.shape[:2], tilt),
        middle,
        across,
        np.zeros(half.shape),
        swing / half,
    )


def measured(
    panel: IntArray, kind: int, carriers: Carriers, samples: Samples, tolerances: Tolerances
) -> Pool:
    """Candidates with their deviations from samples of the same panels.

    Infinitely far off where the shape's rulings don't follow the panel's, to the limit at its ends.
    """
    found, bound = deviation(samples, carriers)
    shift = np.abs(end_shift(samples, carriers)).max(axis=(1, 2))
    follow = follows(samples, carriers) & (shift <= tolerances.ends_mm)
    found = np.where(follow, found, np.inf)
    ends = samples.edges[0].reshape(len(samples), -1, 3)
    flange = np.abs(carriers.distance(ends)).max(axis=1)
    kinds = np.full(len(panel), kind, dtype=np.int64)
    return Pool(panel, kinds, carriers, found, bound, flange)


def allowed(pool: Pool, patches: Sequence[RuledPatch], tolerances: Tolerances) -> Pool:
    """The candidates whose bounds keep the limits that concern a panel alone.

    Where only the bound is beyond the tolerance, denser samples bring it closer to what is found.
    """
    limit = tolerances.deviation_mm
    good = np.isfinite(pool.deviation) & (pool.flange <= tolerances.flange)
    pool = pool[np.flatnonzero((good & (pool.deviation <= limit)) | ~pool.replaced)]
    for count in _DENSER:
        index = np.flatnonzero(~(pool.bound <= limit) & (pool.deviation <= limit))
        if len(index) == 0:
            break
        samples = sample([patches[p] for p in pool.panel[index]], count)
        found, bound = pool.deviation.copy(), pool.bound.copy()
        found[index], bound[index] = deviation(samples, pool.carriers[index])
        pool = replace(pool, deviation=found, bound=bound)
    return pool[np.flatnonzero((pool.bound <= limit) & (pool.deviation <= limit))]


@dataclass(frozen=True)
class OwnCandidates:
    """What each panel can be by itself.

    Attributes
    ----------
    pool : Pool
        Every panel as fitted, and its shapes within the limits.
    samples : Samples
    possible : (p, 4) bool array
        Whether a class is not excluded by the deviation alone, in the order of CLASSES.
    fits : tuple of Carriers
        The closest shape of every class but the last, one a panel.
    """

    pool: Pool
    samples: Samples
    possible: BoolArray
    fits: tuple[Carriers, ...]

    def closest(self, kind: IntArray) -> Carriers:
        """The closest shape of each panel in its class (of the last: any)."""
        carriers = self.fits[-1]
        for k, fitted in enumerate(self.fits):
            carriers = fitted.where(kind == k, carriers)
        return carriers


def own_candidates(panels: Sequence[PanelInput], tolerances: Tolerances) -> OwnCandidates:
    """Every panel as fitted, and its shapes within the limits: closest, and closest at the joints.

    The closest shape has the smallest largest deviation. The others weigh the boundary, and the
    normals along it, so that neighbours find them where the fitted panel was.
    """
    patches = [panel.patch for panel in panels]
    samples = sample(patches)
    size, everyone = samples.size, np.arange(len(panels))
    pool = as_fitted(start(samples))
    possible = np.ones((len(panels), len(CLASSES)), dtype=bool)
    wishes = (
        (None, None),
        (tolerances.gap_mm / 2.0, None),
        (tolerances.gap_mm / 2.0, tolerances.kink / 2.0),
    )
    swing = np.full((len(panels), 1), tolerances.gap_mm / 2.0)
    fits = []
    for kind, name in enumerate(CLASSES[:-1]):
        near = start(samples, name)
        for edge, tilt in wishes:
            at = samples if edge is None else samples.thinned()
            targets = targets_of(at, tolerances.deviation_mm, edge, tilt, swing)
            # Norms from the second fit on begin where the fit before them ended.
            near = fit(targets, near, name, size, (2.0, 4.0, 16.0) if edge is None else (4.0, 16.0))
            if edge is None:
                fits.append(near)
                possible[:, kind] = power_mean(targets.residuals(near)[0]) <= 1.0
            found = measured(everyone, kind, near, samples, tolerances)
            pool = pool.with_more(allowed(found, patches, tolerances))
    return OwnCandidates(pool, samples, possible, tuple(fits))


def power_mean(residuals: Array, power: float = 16.0) -> Array:
    """Power mean (p,) of residuals: at the p-norm's minimum no fit has a smaller largest one."""
    return (np.abs(residuals) ** power).mean(axis=1) ** (1.0 / power)
