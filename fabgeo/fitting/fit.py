"""Fit a strip model to a design surface (paper section 1, eq. 2).

Developability has the nature of a constraint: its weight grows stage by stage while that helps.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fabgeo import spline
from fabgeo.errors import GeometryError, InputError
from fabgeo.fitting import held as holding
from fabgeo.fitting.asymptotic import obstacle
from fabgeo.fitting.folds import find_fold
from fabgeo.fitting.level import Level
from fabgeo.fitting.levenberg import Solution, Step, minimise
from fabgeo.fitting.options import FitOptions
from fabgeo.fitting.quality import Quality, mean_ruling, quality
from fabgeo.fitting.reference import Reference
from fabgeo.fitting.samples import Net
from fabgeo.strips.model import KINDS, Kind, StripModel
from fabgeo.surfaces.base import DesignSurface

FINE_AT_ONCE = 3500  # unknowns up to which a fit starts at its finest level
MOST_LEVELS = 3  # times that `levels=None` halves the number of segments of a larger one
LEAST_SEGMENTS = 8
COARSE_LIMIT = 10.0  # multiple of the limits that a coarse level has to reach
PATIENCE = 3  # stages in a row without gain, after which more weight is of no use
HASTE = 2  # the same where a finer level is still to come
FLAT_ENOUGH = 1.05  # of the sag limit: reweighting has nothing to gain below
WORTH_A_REASON = 1.2  # of the sag limit: above, the reason says what holds the model off
ROUNDS = 6  # of reweighting, at most


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
        reached; "interrupted": the listener stopped it. (Steps that fold a strip are never taken.)
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


def fit(
    surface: DesignSurface,
    start: StripModel,
    kind: Kind = "general",
    options: FitOptions | None = None,
    listener: Listener | None = None,
) -> FitResult:
    """Fit a strip model of the given kind to a surface.

    Parameters
    ----------
    surface : DesignSurface
    start : StripModel
        Strips without folds, roughly on the surface, in the surface's unit of length.
    kind : {"general", "conical", "circular", "geodesic"}
    options : FitOptions, optional
    listener : callable, optional
        Called with a Progress after every step; returning False ends the fit with the best model
        so far.

    Returns
    -------
    FitResult

    Raises
    ------
    InputError
        If the kind is unknown or options contradict the surface.
    GeometryError
        If a strip of the start folds over; names strip and u.
    """
    if kind not in KINDS:
        raise InputError("fit", f"expected a kind of {KINDS}, found {kind!r}")
    return _Fit(surface, start, kind, options or FitOptions(), listener).run()


class _Fit:
    """The state of one fit while it runs."""

    def __init__(
        self,
        surface: DesignSurface,
        start: StripModel,
        kind: Kind,
        options: FitOptions,
        listener: Listener | None,
    ) -> None:
        self.start, self.options, self.listener = start, options, listener
        self.kind: Kind = kind
        net = Net.of(start)
        self.length = mean_ruling(start.control, net)
        if not self.length > 0.0:
            raise GeometryError("fit", "all rulings of the start have length zero")
        self.reference = Reference(surface, self.length)
        self.control = np.array(start.control) / self.length
        self.history: list[dict[str, Any]] = []
        self.interrupted = False
        held = holding.choose(net, self.control, self.reference, options.boundary, kind)
        self.held = held
        self.level = Level(net, self.reference, kind, options, held)
        fold = find_fold(self.level.state(self.control), self.level.coarse)
        if fold is not None:
            raise GeometryError(
                "start", f"{fold} ({fold.count} places in all)", "choose another start"
            )
        self.begin = time.process_time()
        whole = held.everything(net)
        self.anchor = 0.0 if whole else options.weights.anchor
        self.anchor_at = np.array(self.control)
        self.weight = 1.0

    def run(self) -> FitResult:
        """All levels from coarse to fine, then the largest deviation."""
        for _ in range(self._coarsen()):
            self._grow(COARSE_LIMIT, finer=True)
            if self.interrupted:
                break
            self.control = spline.refine(self.control, self.level.net.closed_u)
            self.anchor_at = spline.refine(self.anchor_at, self.level.net.closed_u)
            self._at_level()
            self.weight = max(self.weight / self.options.growth, 1.0)
        refinements = self.options.refinements
        if not self.interrupted:
            self._grow(1.0, finer=refinements > 0)
        for left in range(refinements, 0, -1):
            if self.interrupted or self._excess(self._figures()) <= 1.0:
                break
            self._refine(finer=left > 1)
        uneven = self._figures().deviation_over_sag > FLAT_ENOUGH
        if not self.interrupted and self.options.minimise == "max" and uneven:
            self._flatten()
        status, reason = self._verdict()
        return self._result(status, reason, self._figures(), time.process_time() - self.begin)

    def _refine(self, finer: bool) -> None:
        """Halve the knot spans once more where the limits can't be reached with these."""
        self.control = spline.refine(self.control, self.level.net.closed_u)
        self.anchor_at = spline.refine(self.anchor_at, self.level.net.closed_u)
        self._at_level()
        self.weight = max(self.weight / self.options.growth**2, 1.0)
        self._grow(1.0, finer)

    def _coarsen(self) -> int:
        """Take every other knot away as often as asked; the number of refinements to come.

        Not where that spoils a start that is nearly a model of its kind, such as a mesh's own.
        """
        excess = self._excess(self._figures())
        net, levels = self.level.net, self.options.levels
        fine = self.control.size < FINE_AT_ONCE
        count = (0 if fine else MOST_LEVELS) if levels is None else levels
        done = 0
        while done < count and net.segments % 2 == 0 and net.segments // 2 >= LEAST_SEGMENTS:
            u = np.arange(0.0, net.segments + (0 if net.closed_u else 1), 2.0)
            points = spline.evaluate(self.control, u, net.closed_u)
            coarse = spline.interpolate(points, net.closed_u)
            net = Net(net.edges, net.segments // 2, net.closed_u, net.closed_i)
            level = Level(net, self.reference, self.kind, self.options, self.held)
            state = level.state(coarse)
            if find_fold(state, level.coarse) is not None:
                break
            spoilt = self._excess(quality(state, level.dense, self.kind)) > 2.0 * excess
            if spoilt and levels is None:
                break
            self.control, self.anchor_at, self.level = coarse, np.array(coarse), level
            done += 1
        return done

    def _at_level(self) -> None:
        old = self.level.net
        net = Net(old.edges, old.segments * 2, old.closed_u, old.closed_i)
        self.level = Level(net, self.reference, self.kind, self.options, self.held)

    def _grow(self, slack: float, finer: bool = False) -> None:
        """Let the weight of developability grow while that helps and the limits are not reached.

        `slack` multiplies the limits: a coarse level need not reach those of the finest. Stages
        that bring nothing only drive the model off the surface: they are taken back.
        """
        best, idle, kept = np.inf, 0, (self.control, self.weight, self.anchor)
        for _ in range(self.options.stages):
            self._stage()
            excess = self._excess(self._record_of_last())
            if self.interrupted or excess <= slack:
                return
            if excess <= 0.7 * best:
                best, idle, kept = excess, 0, (self.control, self.weight, self.anchor)
            else:
                idle += 1
            if idle == (HASTE if finer else PATIENCE):
                self.control, self.weight, self.anchor = kept
                return
            self.weight *= self.options.growth
            self.anchor /= self.options.growth**0.5

    def _flatten(self) -> None:
        """Make the largest deviation small: rounds of reweighting, of which the best is kept."""
        best, found = self.control, self._figures()
        kept = len(self.history)
        for _ in range(ROUNDS):
            self.level.stress(self.control)
            self._stage()
            figures = self._record_of_last()
            within = self._excess(figures) <= max(1.0, self._excess(found))
            if within and figures["deviation"] < found.deviation * 0.999:
                best, found, kept = self.control, self._figures(), len(self.history)
            elif len(self.history) - kept >= 2 or self.interrupted:
                break
        self.control = best

    def _stage(self) -> None:
        """One minimisation with fixed weights, recorded."""
        problem = self.level.problem(self.control, self.anchor_at, self.weight, self.anchor)
        number = len(self.history) + 1

        def heard(step: Step) -> bool:
            if self.listener is None:
                return True
            progress = Progress(
                number, self.level.net.segments, step.iteration, step.cost, step.gain, self.weight
            )
            self.interrupted = self.listener(progress) is False
            return not self.interrupted

        solution = minimise(
            problem,
            self.control.reshape(-1, 3),
            self.level.equations(problem),
            iterations=self.options.iterations,
            gain=1e-3,
            listener=heard,
        )
        self.control = solution.x.reshape(self.control.shape)
        self._record(self.weight, solution, self._figures(), time.process_time() - self.begin)

    def _record_of_last(self) -> dict[str, Any]:
        return self.history[-1]

    def _excess(self, figures: Any) -> float:
        """Twist and kind's defect as multiples of their limits: at most 1 within them."""
        plain = figures if isinstance(figures, dict) else figures.plain()
        return max(
            plain["twist_deg"] / self.options.twist_limit_deg,
            plain["kind_deg"] / self.options.kind_limit_deg,
        )

    def _verdict(self) -> tuple[str, str]:
        if self.interrupted:
            return "interrupted", "stopped by the listener"
        figures = self._figures()
        within = self._excess(figures) <= 1.0
        why = ""
        if not within or figures.deviation_over_sag > WORTH_A_REASON:
            why = obstacle(self.level.net, self.control, self.reference, self.held)
        if within:
            words = ["within the limits of twist and kind; nothing more is gained"]
        else:
            words = [
                f"strip {figures.twist_strip} twists by {figures.twist_deg:.4f} degrees at u = "
                f"{figures.twist_u:.2f} (limit {self.options.twist_limit_deg}), the defect of its "
                f"kind is {figures.kind_deg:.4f} degrees (limit {self.options.kind_limit_deg}); a "
                "larger weight of developability no longer helps"
            ]
        return "converged" if within else "limited", "; ".join([*words, *([why] if why else [])])

    def _figures(self) -> Quality:
        return quality(self.level.state(self.control), self.level.dense, self.kind)

    def _record(self, weight: float, solution: Solution, figures: Quality, seconds: float) -> None:
        self.history.append(
            {
                "stage": len(self.history) + 1,
                "segments": self.level.net.segments,
                "developability": weight,
                "steps": len(solution.steps),
                "factorisations": solution.factorisations,
                "outcome": solution.outcome,
                "cost": solution.cost,
                **figures.plain(),
                "seconds": seconds,
            }
        )

    def _result(self, status: str, reason: str, figures: Quality, seconds: float) -> FitResult:
        info = {**self.start.info, "fit": {"status": status, "reason": reason}}
        model = StripModel(
            self.control * self.length, self.start.closed_u, self.start.closed_i, self.kind, info
        )
        statistics = {
            "unknowns": int(self.control.size),
            "steps": sum(h["steps"] for h in self.history),
            "factorisations": sum(h["factorisations"] for h in self.history),
            "seconds": seconds,
            "solver": self.level.solver,
            "twist_max_deg": figures.twist_deg,
            "kind_max_deg": figures.kind_deg,
            "deviation_max": figures.deviation * self.length,
            "deviation_rms": figures.deviation_rms * self.length,
            "deviation_over_sag_limit": figures.deviation_over_sag,
        }
        return FitResult(model, status, reason, tuple(self.history), statistics)
