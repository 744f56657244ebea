"""What becomes of a start: a short fit of a small version of it, before one is chosen.

How much a start twists says little of how far it will untwist: a conjugate net held to a boundary
that no net can follow looks good and stays as it is. A few steps tell.
"""

from __future__ import annotations

from dataclasses import dataclass

from fabgeo.errors import FabgeoError
from fabgeo.fitting.fit import fit
from fabgeo.fitting.options import FitOptions
from fabgeo.fitting.quality import mean_ruling
from fabgeo.fitting.samples import Net
from fabgeo.fitting.starts.model import model_start
from fabgeo.fitting.verdict import NEAR_ENOUGH
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


@dataclass(frozen=True)
class Trial:
    """What a short fit left.

    Attributes
    ----------
    twist : float
        Largest twist, or defect of the kind, in degrees; infinite where it folds.
    deviation, over_sag : float
        Largest distance to the surface, and the same by the sag limit; the latter 0 where a
        distance is near enough whatever the sag.
    problem : str
        What spoke against a fit, with the place.
    """

    twist: float = float("inf")
    deviation: float = float("inf")
    over_sag: float = float("inf")
    problem: str = ""

    @property
    def works(self) -> bool:
        """Whether it became developable."""
        return self.twist <= UNTWISTED


def short_fit(model: StripModel, reference: DesignSurface, kind: Kind) -> Trial:
    """Figures of a short fit of a start."""
    try:
        found = fit(reference, _small(model), kind, OPTIONS)
    except FabgeoError as error:
        return Trial(problem=f"a small version of it can't be fitted: {error}")
    left = found.statistics
    twist, deviation = max(left["twist_max_deg"], left["kind_max_deg"]), left["deviation_max"]
    near = deviation <= NEAR_ENOUGH * mean_ruling(found.model.control, Net.of(found.model))
    return Trial(twist, deviation, 0.0 if near else left["deviation_over_sag_limit"])


def _small(model: StripModel) -> StripModel:
    strips, segments = min(model.strips, MOST_STRIPS), min(model.segments, MOST_SEGMENTS)
    if model.closed_u:
        segments = min(model.segments, 2 * MOST_SEGMENTS)
    if model.closed_i:
        strips = min(model.strips, 2 * MOST_STRIPS)
    return model_start(None, strips, segments, seed=model)[0]
