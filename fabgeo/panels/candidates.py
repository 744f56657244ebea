"""Candidate placements of every class for every panel, each panel by itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fabgeo.arrays import IntArray
from fabgeo.panels.carrier import Carriers
from fabgeo.panels.certify import deviation
from fabgeo.panels.fit_shape import Targets, fit, start
from fabgeo.panels.limits import Tolerances
from fabgeo.panels.pool import CLASSES, Pool, as_fitted
from fabgeo.panels.samples import PanelInput, Samples, boundary_tilt, sample

_ROWS = np.array([0.0, 0.5, 1.0])


def targets_of(
    samples: Samples, deviation_mm: float, edge_mm: float | None, tilt: float | None
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
    """
    count, s = len(samples), len(samples.t)
    points = samples.points(_ROWS)
    unit = np.full((count, s, 3), deviation_mm)
    if edge_mm is not None:
        edge = min(edge_mm, deviation_mm)
        unit[:, :, [0, 2]] = edge
        unit[:, [0, -1]] = edge
    whole = Targets.of_points(points.reshape(count, -1, 3), unit.reshape(count, -1))
    if tilt is None:
        return whole
    at, along = boundary_tilt(samples)
    return Targets(
        whole.points,
        whole.unit,
        at,
        along,
        np.zeros(at.shape[:2]),
        np.full(at.shape[:2], tilt),
    )


def measured(panel: IntArray, kind: int, carriers: Carriers, samples: Samples) -> Pool:
    """Candidates with their deviations from samples of the same panels."""
    found, bound = deviation(samples, carriers)
    ends = samples.edges[0].reshape(len(samples), -1, 3)
    flange = np.abs(carriers.distance(ends)).max(axis=1)
    kinds = np.full(len(panel), kind, dtype=np.int64)
    return Pool(panel, kinds, carriers, found, bound, flange)


def allowed(pool: Pool, tolerances: Tolerances) -> Pool:
    """The candidates whose bounds keep the limits that concern a panel alone."""
    good = (pool.bound <= tolerances.deviation_mm) & (pool.flange <= tolerances.flange)
    good &= np.isfinite(pool.bound)
    return pool[np.flatnonzero(good | ~pool.replaced)]


def own_candidates(panels: Sequence[PanelInput], tolerances: Tolerances) -> tuple[Pool, Samples]:
    """Every panel as fitted, and its shapes within the limits: closest, and closest at the joints.

    The closest shape has the smallest largest deviation. The second weighs the boundary and the
    normals along it so that its neighbours find it where the fitted panel was.
    """
    samples = sample([panel.patch for panel in panels])
    size, everyone = samples.size, np.arange(len(panels))
    pool = as_fitted(start(samples))
    wishes = (
        (None, None),
        (tolerances.gap_mm / 2.0, None),
        (tolerances.gap_mm / 2.0, tolerances.kink / 2.0),
    )
    for kind, name in enumerate(CLASSES[:-1]):
        near = start(samples, name)
        for edge, tilt in wishes:
            targets = targets_of(samples, tolerances.deviation_mm, edge, tilt)
            near = fit(targets, near, name, size)
            pool = pool.with_more(allowed(measured(everyone, kind, near, samples), tolerances))
    return pool, samples
