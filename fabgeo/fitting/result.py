"""What a fit tells while it runs, and what it found."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from fabgeo.fitting.quality import Quality
from fabgeo.strips.model import StripModel


@dataclass(frozen=True)
class Progress:
    """What a listener hears after every accepted step.

    Attributes
    ----------
    stage : int
        Running number of the stage, from 1.
    segments : int
        Segments of the edge curves at the present level.
    iteration : int
        Step within the stage.
    cost, gain : float
        Half the weighted sum of squares, and the part of it that the step gained.
    developability : float
        Its weight.
    """

    stage: int
    segments: int
    iteration: int
    cost: float
    gain: float
    developability: float


type Listener = Callable[[Progress], bool | None]


@dataclass(frozen=True)
class FitResult:
    """What a fit found.

    Attributes
    ----------
    model : StripModel
        In the unit of the start.
    status : str
        "converged": within the limits asked; "limited": nothing more helps, the limits are not
        reached, or a strip has folded between the places where steps are tested for it (the
        reason names it); "interrupted": the listener stopped it.
    reason : str
        Why the fit ended, for people; names strip and u where one is to blame.
    history : tuple of dict
        One plain record a stage: weights, cost, twist, deviation, steps, seconds.
    statistics : dict
        Totals: unknowns, steps, factorisations, seconds, solver, and the last figures.
    """

    model: StripModel
    status: str
    reason: str
    history: tuple[dict[str, Any], ...] = ()
    statistics: dict[str, Any] = field(default_factory=dict)


def totals(
    history: Sequence[Mapping[str, Any]], figures: Quality, length: float
) -> dict[str, float | int]:
    """Sums over the stages, and the last figures in the model's unit: `length` is the fit's."""
    return {
        "steps": sum(h["steps"] for h in history),
        "factorisations": sum(h["factorisations"] for h in history),
        "twist_max_deg": figures.twist_deg,
        "kind_max_deg": figures.kind_deg,
        "deviation_max": figures.deviation * length,
        "deviation_rms": figures.deviation_rms * length,
        "deviation_over_sag_limit": figures.deviation_over_sag,
    }
