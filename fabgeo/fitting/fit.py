"""Fit a strip model to a design surface (paper section 1, eq. 2).

Developability has the nature of a constraint: its weight grows stage by stage while that helps.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import GeometryError, InputError
from fabgeo.fitting import held as holding
from fabgeo.fitting.folds import find_fold
from fabgeo.fitting.level import Level
from fabgeo.fitting.levenberg import Solution, Step, minimise
from fabgeo.fitting.options import FitOptions
from fabgeo.fitting.quality import Quality, mean_ruling, quality
from fabgeo.fitting.reference import Reference
from fabgeo.fitting.samples import Net
from fabgeo.strips.model import KINDS, Kind, StripModel
from fabgeo.surfaces.base import DesignSurface


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
        reached; "folded"; "interrupted": the listener stopped it.
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
        self.held = holding.choose(net, self.control, self.reference, options.boundary, kind)
        self.level = Level(net, self.reference, kind, options, self.held)
        fold = find_fold(self.level.state(self.control), self.level.coarse)
        if fold is not None:
            raise GeometryError(
                "start", f"{fold} ({fold.count} places in all)", "choose another start"
            )

    def run(self) -> FitResult:
        """All stages."""
        begin = time.process_time()
        anchor_at = np.array(self.control)
        weight, figures = 1.0, self._figures()
        whole = self.held.everything(self.level.net)
        anchor = 0.0 if whole else self.options.weights.anchor
        status, reason = "limited", "the weight of developability has grown to its end"
        for _ in range(self.options.stages):
            solution = self._stage(anchor_at, weight, anchor)
            figures = self._figures()
            self._record(weight, solution, figures, time.process_time() - begin)
            if self.interrupted:
                status, reason = "interrupted", "stopped by the listener"
                break
            if self._reached(figures):
                status, reason = "converged", "within the limits of twist and kind"
                break
            weight, anchor = weight * self.options.growth, anchor / self.options.growth**0.5
        return self._result(status, reason, figures, time.process_time() - begin)

    def _stage(self, start: Array, weight: float, anchor: float) -> Solution:
        problem = self.level.problem(self.control, start, weight, anchor)
        number = len(self.history) + 1

        def heard(step: Step) -> bool:
            if self.listener is None:
                return True
            progress = Progress(
                number, self.level.net.segments, step.iteration, step.cost, step.gain, weight
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
        return solution

    def _figures(self) -> Quality:
        return quality(self.level.state(self.control), self.level.dense, self.kind)

    def _reached(self, figures: Quality) -> bool:
        options = self.options
        return (
            figures.twist_deg <= options.twist_limit_deg
            and figures.kind_deg <= options.kind_limit_deg
        )

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
