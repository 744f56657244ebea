"""What becomes of a start: a short fit of a small version of it, before one is chosen.

How much a start twists says little of how far it will untwist: a conjugate net held to a boundary
that no net can follow looks good and stays as it is. A few steps tell.
"""

from __future__ import annotations

from fabgeo.errors import FabgeoError
from fabgeo.fitting.fit import fit
from fabgeo.fitting.options import FitOptions
from fabgeo.fitting.starts.model import model_start
from fabgeo.strips.model import Kind, StripModel
from fabgeo.surfaces.base import DesignSurface

MOST_STRIPS, MOST_SEGMENTS = 14, 16  # of the small version
UNTWISTED = 0.03  # degrees: what is reached in so few steps is a start that works
OPTIONS = FitOptions(
    twist_limit_deg=UNTWISTED,
    kind_limit_deg=UNTWISTED,
    minimise="rms",
    levels=0,
    refinements=0,
    stages=6,
    iterations=10,
)


def trial_twist(model: StripModel, reference: DesignSurface, kind: Kind) -> tuple[float, str]:
    """Largest twist, or defect of the kind, in degrees that a short fit leaves.

    Infinite where it folds, with the place.
    """
    try:
        found = fit(reference, _small(model), kind, OPTIONS)
    except FabgeoError as error:
        return float("inf"), f"a small version of it can't be fitted: {error}"
    left = found.statistics
    return float(max(left["twist_max_deg"], left["kind_max_deg"])), ""


def _small(model: StripModel) -> StripModel:
    strips, segments = min(model.strips, MOST_STRIPS), min(model.segments, MOST_SEGMENTS)
    if model.closed_u:
        segments = min(model.segments, 2 * MOST_SEGMENTS)
    if model.closed_i:
        strips = min(model.strips, 2 * MOST_STRIPS)
    return model_start(None, strips, segments, seed=model)[0]
