"""Whether a fit did what it was asked for, and if not, why.

Glossary
--------
excess
    Twist and the kind's defect as multiples of their limits; at most 1 within them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from fabgeo.fitting.folds import find_fold
from fabgeo.fitting.hindrance import hindrance
from fabgeo.fitting.level import Level
from fabgeo.fitting.objectives.base import State
from fabgeo.fitting.obstacle import obstacle
from fabgeo.fitting.options import FitOptions
from fabgeo.fitting.quality import Quality, dense_sites

WORTH_A_REASON = 1.2  # of the sag limit: above, the reason says what holds the model off
NEAR_ENOUGH = 1e-4  # of a ruling's length: a deviation that needs no reason, whatever the sag
FINEST = 16  # places a segment where the result is looked at for folds: cusps are short


def excess_of(figures: Quality | Mapping[str, Any], options: FitOptions) -> float:
    """The larger of twist and the kind's defect over their limits."""
    plain = figures.plain() if isinstance(figures, Quality) else figures
    return max(
        plain["twist_deg"] / options.twist_limit_deg, plain["kind_deg"] / options.kind_limit_deg
    )


def verdict(
    state: State,
    level: Level,
    figures: Quality,
    options: FitOptions,
    tried: Collection[str],
    *,
    interrupted: bool,
) -> tuple[str, str]:
    """Status and reason of a `FitResult`; `tried` are methods of starts, advised no more."""
    within = excess_of(figures, options) <= 1.0
    if interrupted:
        status, words = "interrupted", ["stopped by the listener"]
    elif within:
        status, words = "converged", ["within the limits of twist and kind; nothing more is gained"]
    else:
        status, words = "limited", [_short(figures, options, level)]
    if not interrupted:
        words += _why(state, level, figures, tried, within)
    fold = find_fold(state, level.coarse, dense_sites(level.net, FINEST))
    if fold is not None:
        status = "interrupted" if interrupted else "limited"
        words.insert(0, str(fold))
    return status, "; ".join(words)


def _short(figures: Quality, options: FitOptions, level: Level) -> str:
    """By how much the limits are missed, and what the whole surface is like."""
    return (
        f"strip {figures.twist_strip} twists by {figures.twist_deg:.4f} degrees at u = "
        f"{figures.twist_u:.2f} (limit {options.twist_limit_deg:.4g}), the defect of its kind is "
        f"{figures.kind_deg:.4f} degrees (limit {options.kind_limit_deg:.4g}); a larger weight of "
        f"developability no longer helps; of the surface as a whole: "
        f"{hindrance(level.reference.surface)}"
    )


def _why(
    state: State, level: Level, figures: Quality, tried: Collection[str], within: bool
) -> list[str]:
    """What holds the model off where it twists most, or where it is farthest from the surface."""
    if not within:
        place = (figures.twist_strip, figures.twist_u) if figures.twist_deg > 0.0 else None
    elif figures.deviation_over_sag > WORTH_A_REASON and figures.deviation > NEAR_ENOUGH:
        place = figures.deviation_strip, figures.deviation_u
    else:
        return []
    why = obstacle(state, level.held, place, tried, level.kind)
    if within:
        why = f"{figures.deviation_over_sag:.2g} times the sag limit off the surface: {why}"
    return [why] if why else []
