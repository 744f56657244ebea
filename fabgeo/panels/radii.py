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
from fabgeo.errors import InputError

_HALVINGS = 20  # of shares of slacks


def nearest(curvature: Array, radii: Array) -> Array:
    """Curvatures (p,) of the nearest radii of a list (nearest in curvature), signs kept."""
    if not len(radii):
        raise InputError("panels.radii", "expected one radius or more, found none")
    offered = 1.0 / np.asarray(radii, dtype=float)
    at = np.abs(np.abs(curvature)[:, None] - offered).argmin(axis=1)
    return np.sign(curvature) * offered[at]


def multiples(radii: Array, step: float) -> Array:
    """The nearest multiples of a step, each once."""
    return step * np.unique(np.maximum(np.round(np.asarray(radii) / step), 1.0))


def fewest(curvature: Array, slack: Array, most: int | None = None) -> Array:
    """Radii that serve as many cylinders as possible with few of them.

    Every cylinder accepts the interval of curvatures within its slack. Stabbing the intervals at
    their lowest open right end needs the fewest radii. Where `most` allows more, they come nearer
    to the cylinders: the largest share of a slack that any one uses is least. Where it allows
    fewer, those that serve most cylinders are taken, one after the other.

    Parameters
    ----------
    curvature, slack : (p,) arrays
        1/mm; the curvature's sign does not matter to the rolls.
    most : int, optional
        Most radii allowed.
    """
    curvature = np.abs(curvature)
    share, none = 1.0, 0.0
    if most is not None and len(_stabs(curvature, slack)) < most:
        for _ in range(_HALVINGS):
            half = (share + none) / 2.0
            enough = len(_stabs(curvature, half * slack)) <= most
            share, none = (half, none) if enough else (share, half)
    offered = _stabs(curvature, share * slack)
    low, high = curvature - share * slack, curvature + share * slack
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


def _stabs(curvature: Array, slack: Array) -> Array:
    """The fewest curvatures of which every cylinder accepts one."""
    low, high = curvature - slack, curvature + slack
    stabs: list[float] = []
    for i in np.argsort(high):
        if not stabs or low[i] > stabs[-1]:
            stabs.append(float(high[i]))
    return np.array(stabs)
