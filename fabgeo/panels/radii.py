"""Equal radii: few set-ups of the rolls, or few moulds, for many cylinders.

Glossary
--------
slack
    How far a cylinder's curvature may be off its best: a change c moves the ends of an arc of
    length a by about c a^2 / 16 to either side of the best balance.
"""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array


def nearest(curvature: Array, radii: Array) -> Array:
    """Curvatures (p,) of the nearest radii of a list (nearest in curvature), signs kept."""
    offered = 1.0 / np.asarray(radii, dtype=float)
    at = np.abs(np.abs(curvature)[:, None] - offered).argmin(axis=1)
    return np.sign(curvature) * offered[at]


def multiples(radii: Array, step: float) -> Array:
    """The nearest multiples of a step, each once."""
    return step * np.unique(np.maximum(np.round(np.asarray(radii) / step), 1.0))


def fewest(curvature: Array, slack: Array, most: int | None = None) -> Array:
    """Radii that serve as many cylinders as possible with few of them.

    Every cylinder accepts the interval of curvatures within its slack. Stabbing the intervals at
    their lowest open right end needs the fewest radii; where `most` allows fewer still, those that
    serve most cylinders are taken, one after the other.

    Parameters
    ----------
    curvature, slack : (p,) arrays
        1/mm; the curvature's sign does not matter to the rolls.
    most : int, optional
        Most radii allowed.
    """
    low, high = np.abs(curvature) - slack, np.abs(curvature) + slack
    stabs: list[float] = []
    for i in np.argsort(high):
        if not stabs or low[i] > stabs[-1]:
            stabs.append(float(high[i]))
    offered = np.array(stabs)
    # The middle of what all served intervals share is the safest place.
    serves = (low[:, None] <= offered) & (offered <= high[:, None])
    shared = np.array([(low[s].max() + high[s].min()) / 2.0 for s in serves.T])
    if most is not None and most < len(shared):
        serves = (low[:, None] <= shared) & (shared <= high[:, None])
        left, kept = np.ones(len(low), dtype=bool), []
        for _ in range(most):
            best = int((serves & left[:, None]).sum(axis=0).argmax())
            kept.append(best)
            left &= ~serves[:, best]
        shared = shared[sorted(set(kept))]
    return 1.0 / np.maximum(shared, 1e-12)
