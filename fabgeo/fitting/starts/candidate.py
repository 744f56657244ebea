"""One start that "auto" tries: made, measured, and fitted for a moment."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from fabgeo.errors import FabgeoError
from fabgeo.fitting.starts.methods import called, told
from fabgeo.fitting.starts.quality import Quality, quality
from fabgeo.fitting.starts.trial import UNTWISTED, Trial, short_fit
from fabgeo.strips.model import Kind, StripModel
from fabgeo.surfaces.base import DesignSurface
from fabgeo.surfaces.trace_extension import Extended

PROMISING = 10.0  # times the twist of a start that works, up to which no others are looked for
EQUAL = 1  # decimals of scores that differ: of a tenth of a degree, of 2 % of a width
COVERING = 0.8  # of a surface, from which on a start is said to cover it
ALL_ROUND = 0.1  # of its length and width, by which a net for a conical model overhangs


@dataclass(frozen=True)
class Candidate:
    """One start that was tried: its method, direction, figures, and what spoke against it.

    `trial` is what a short fit of it left, None if none was made.
    """

    method: str
    direction: str
    quality: Quality | None
    problem: str = ""
    model: StripModel | None = field(default=None, repr=False)
    notes: tuple[str, ...] = ()
    trial: Trial | None = None

    @property
    def works(self) -> bool:
        """Whether a short fit made it developable."""
        return self.trial is not None and self.trial.works

    @property
    def holds(self) -> bool:
        """Whether there is a model, without folds."""
        return self.score < float("inf")

    @property
    def name(self) -> str:
        """Method and direction, such as ``iso v``."""
        return f"{self.method} {self.direction}".strip()

    @property
    def promises(self) -> bool:
        """Whether it covers the surface and a short fit made it nearly developable."""
        near = self.trial is not None and self.trial.twist <= PROMISING * UNTWISTED
        return near and self.quality is not None and self.quality.coverage >= COVERING

    @property
    def score(self) -> float:
        """The lower the better: degrees of twist, uncovered area and uneven widths in one number.

        A degree of twist weighs as much as 1 % of the surface uncovered or as widths 20 % over the
        mean, one that a short fit left ten times as much; a fold excludes.
        """
        q = self.quality
        if q is None or q.folds > 0.0:
            return float("inf")
        return self.at_best + (q.twist_rms if self.trial is None else 10.0 * self.trial.twist)

    @property
    def at_best(self) -> float:
        """The score that a fit without any twist would give it."""
        q = self.quality
        if q is None or q.folds > 0.0:
            return float("inf")
        return 100.0 * (1.0 - q.coverage) + 5.0 * (q.width_ratio - 1.0)

    def told(self) -> str:
        """Its figures, or what spoke against it."""
        after = "" if self.trial is None else f", {self.trial.twist:.2g} deg after a short fit"
        return self.problem or f"{self.quality}{after}"


def tried(
    surface: DesignSurface,
    strips: int | None,
    segments: int | None,
    method: str,
    way: str,
    kind: Kind,
    options: dict[str, Any],
) -> Candidate:
    """The candidate of one method and direction, or what spoke against it."""
    options = all_round(surface, method, kind, options)
    try:
        model, notes = called(method, surface, strips, segments, way or None, None, options)
    except FabgeoError as error:
        return Candidate(method, way, None, str(error))
    found = quality(model, surface)
    problem = ""
    if found.fold_at is not None:
        problem = f"folds at strip {found.fold_at[0]}, u = {found.fold_at[1]:.2f}"
    model = told(model, method, way, notes)
    return Candidate(method, way, found, problem, model, tuple(notes))


def trials(
    candidates: list[Candidate], surface: DesignSurface, kind: Kind, beat: float = float("inf")
) -> list[Candidate]:
    """The candidates from the best on, with short fits of them until one works.

    Those that could not score below `beat`, nor below the best found, are not fitted. Equally
    good ones keep their order: planks run the long way rather than the one 0.2 % more even.
    """
    done: list[Candidate] = []
    for candidate in sorted(candidates, key=lambda c: round(c.score, EQUAL)):
        model = candidate.model
        if model is not None and candidate.at_best < beat and not any(c.works for c in done):
            trial = short_fit(model, reference_of(model, surface), kind)
            candidate = replace(candidate, trial=trial, problem=trial.problem)
            beat = min(beat, candidate.score)
        done.append(candidate)
    return done


def all_round(
    surface: DesignSurface, method: str, kind: Kind, options: dict[str, Any]
) -> dict[str, Any]:
    """Options of iso and mesh starts: a net of a special kind overhangs, as nothing holds it."""
    if kind == "general" or not surface.loops or "overhang" in options:
        return options
    own = {"iso": {"overhang": ALL_ROUND, "across": True}, "mesh": {"around": True}}
    return {**options, **own.get(method, {})}


def reference_of(model: StripModel, surface: DesignSurface) -> DesignSurface:
    """The surface, continued if a border of the model lies beside it by a tenth of a ruling."""
    if not surface.loops:
        return surface
    extended = Extended(surface)
    points = model.points(model.parameters(2))
    width = float(np.median(np.linalg.norm(np.subtract(*model.pairs(points)), axis=-1)))
    beyond = extended.beyond(points.reshape(-1, 3))
    return extended if float(np.quantile(beyond, 0.98)) > 0.1 * width else surface
