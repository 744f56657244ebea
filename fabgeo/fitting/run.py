"""One fit while it runs: levels from coarse to fine, stages of growing weight, the last evening.

Glossary
--------
level
    A net of strips and segments; the next finer one holds the same model exactly.
stage
    One minimisation with fixed weights.

Developability has the nature of a constraint: its weight grows stage by stage while that helps.
Stages on the way need not be solved exactly, only the one that reaches the limits.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from fabgeo.errors import GeometryError
from fabgeo.fitting import held as holding
from fabgeo.fitting.folds import find_fold
from fabgeo.fitting.level import Level
from fabgeo.fitting.levenberg import Solution, Step, minimise
from fabgeo.fitting.options import FitOptions
from fabgeo.fitting.quality import Quality, mean_ruling, quality
from fabgeo.fitting.reference import Reference
from fabgeo.fitting.result import FitResult, Listener, Progress, totals
from fabgeo.fitting.samples import Net, coarsened, refined
from fabgeo.fitting.verdict import excess_of, verdict
from fabgeo.strips.model import Kind, StripModel
from fabgeo.surfaces.base import DesignSurface

FINE_AT_ONCE = 3500  # unknowns up to which a fit starts at its finest level
MOST_LEVELS = 3  # times that `levels=None` halves the number of segments of a larger one
LEAST_SEGMENTS = 8
COARSE_LIMIT = 10.0  # multiple of the limits that a coarse level has to reach
LEAST_ANCHOR = 0.01  # of its first weight: without any, free borders retreat
WORTH = 0.7  # of the best excess so far: a stage that brings less is idle
PATIENCE = 3  # idle stages in a row, after which more weight is of no use
WITHIN_REACH = 10.0  # multiple of the limits up to which more effort may reach them
EXACTLY = 1e-3  # the same for nets of a kind: their path is narrow
ON_THE_WAY, SETTLED = 1e-2, 3e-3  # relative gain of a step at which a stage ends
FLAT_ENOUGH = 1.05  # of the sag limit: reweighting has nothing to gain below
ROUNDS = 4  # of reweighting, at most
FLATTER = 0.95  # of the largest deviation: a round that brings less is the last
GIVE = 2  # steps of growth that a round takes back
FADES, FADE = 3, 0.1  # times that fairness fades at the end, at most, and by which factor
STILL_GOOD = 2.0  # of the cost it was left with: up to here a model is gone on with


class Run:
    """The state of one fit."""

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
        fold = find_fold(self.level.state(self.control), self.level.coarse, self.level.dense)
        if fold is not None:
            raise GeometryError(
                "start", f"{fold} ({fold.count} places in all)", "choose another start"
            )
        self.begin = time.process_time()
        self.anchor = 0.0 if held.everything(net) else options.weights.anchor
        # Principal nets are the surface's own: a pull that stays would hold them off it.
        self.least_anchor = LEAST_ANCHOR * self.anchor if kind == "general" else 0.0
        self.anchor_at = np.array(self.control)
        self.weight = 1.0

    def result(self) -> FitResult:
        """All levels from coarse to fine, then the largest deviation."""
        resumed = self._resume()
        for _ in range(0 if resumed else self._coarsen()):
            self._grow(COARSE_LIMIT, finer=True)
            if self.interrupted or not self._refine(self.options.growth):
                break
        if not self.interrupted:
            self._grow(1.0, finer=self.options.refinements > 0)
        for left in range(self.options.refinements, 0, -1):
            excess = self._excess(self._figures())
            hopeless = left < self.options.refinements and excess > WITHIN_REACH
            if self.interrupted or excess <= 1.0 or hopeless:
                break
            # Halve the knot spans once more: the limits can't be reached with these.
            if not self._refine(self.options.growth**2):
                break
            self._grow(1.0, finer=left > 1)
        if self.kind == "general" and self._uneven() and not self.interrupted:
            self._fade()
        # A model of a kind that misses its limits has no room to come nearer.
        room = self.kind == "general" or self._excess(self._figures()) <= 1.0
        if self.options.minimise == "max" and room and self._uneven() and not self.interrupted:
            self._flatten()
        return self._result()

    def _resume(self) -> bool:
        """Take up the weights of the fit that left the start, if it is as good here as there."""
        left = self.start.info.get("fit", {})
        if left.get("kind") != self.kind or "cost" not in left:
            return False
        anchor = min(self.anchor, left["anchor"])
        problem = self.level.problem(self.control, self.anchor_at, left["developability"], anchor)
        if float(problem.costs(self.control.reshape(-1, 3)).sum()) > STILL_GOOD * left["cost"]:
            return False
        self.weight, self.anchor = left["developability"], anchor
        return True

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
            net, coarse = coarsened(net, self.control)
            level = Level(net, self.reference, self.kind, self.options, self.held)
            state = level.state(coarse)
            if find_fold(state, level.coarse, level.dense) is not None:
                break
            spoilt = self._excess(quality(state, level.dense, self.kind)) > 2.0 * excess
            if spoilt and levels is None:
                break
            self.control, self.anchor_at, self.level = coarse, np.array(coarse), level
            done += 1
        return done

    def _refine(self, back: float) -> bool:
        """The same model on twice as many segments, with the weight some way back.

        False, and nothing done, where the denser look finds a fold.
        """
        old = self.level.net
        net, control = refined(old, self.control)
        level = self.level.refined(net)
        if find_fold(level.state(control), level.coarse, level.dense) is not None:
            return False
        self.control, self.level = control, level
        self.anchor_at = refined(old, self.anchor_at)[1]
        self.weight = max(self.weight / back, 1.0)
        return True

    def _grow(self, slack: float, finer: bool) -> None:
        """Let the weight of developability grow while that helps and the limits are not reached.

        `slack` multiplies the limits: a coarse level need not reach those of the finest. Stages
        that bring nothing only drive the model off the surface: they are taken back.
        """
        best, mark, idle = np.inf, np.inf, 0
        kept = self.control, self.weight, self.anchor
        for _ in range(self.options.stages):
            self._stage(ON_THE_WAY if self.kind == "general" else EXACTLY)
            if self._excess(self.history[-1]) <= slack and slack <= 1.0 and not self.interrupted:
                self._stage(SETTLED)
            excess = self._excess(self.history[-1])
            if self.interrupted or excess <= slack:
                return
            worth = excess <= WORTH * mark
            mark, idle = (excess, 0) if worth else (mark, idle + 1)
            if excess < best and (worth or not finer):
                best, kept = excess, (self.control, self.weight, self.anchor)
            if idle == (1 if finer and self.kind == "general" else PATIENCE):
                break
            self.weight *= self.options.growth
            self.anchor = max(self.anchor / self.options.growth**0.5, self.least_anchor)
        self.control, self.weight, self.anchor = kept

    def _uneven(self) -> bool:
        return self.history[-1]["deviation_over_sag"] > FLAT_ENOUGH

    def _fade(self) -> None:
        """Less fairness while that brings the model nearer to the surface within the limits.

        Fairness spans what nothing else decides; where normal curvatures change their sign along
        the edges, it keeps strips from following the surface to the sag limit.
        """
        for _ in range(FADES):
            best, found = self.control, self._figures()
            self.level.fairness *= FADE
            self._stage(ON_THE_WAY)
            now = self._figures()
            within = self._excess(now) <= max(1.0, self._excess(found))
            if not within or now.deviation > 0.9 * found.deviation:
                self.control = best
                self.level.fairness /= FADE
                return

    def _flatten(self) -> None:
        """Make the largest deviation small: rounds of reweighting, of which the best is kept.

        Each gives developability some way back, so that the model can move, and lets it grow again.
        """
        best, found = (self.control, self.weight, self.anchor), self._figures()
        for _ in range(ROUNDS):
            self.level.stress(self.control)
            self.weight = max(self.weight / self.options.growth**GIVE, 1.0)
            self.anchor = best[2]
            self._grow(1.0, finer=False)
            now = self._figures()
            within = self._excess(now) <= max(1.0, self._excess(found))
            if not within or now.deviation > FLATTER * found.deviation or self.interrupted:
                break
            best, found = (self.control, self.weight, self.anchor), now
            if not self._uneven():
                break
        self.control, self.weight, self.anchor = best

    def _stage(self, gain: float) -> None:
        """One minimisation with fixed weights, recorded."""
        problem = self.level.problem(self.control, self.anchor_at, self.weight, self.anchor)
        number = len(self.history) + 1

        def heard(step: Step) -> bool:
            if self.listener is None:
                return True
            progress = Progress(
                number, self.level.net.segments, step.iteration, step.cost, step.gain, self.weight
            )
            answer = self.listener(progress)
            self.interrupted = answer is not None and not answer
            return not self.interrupted

        solution = minimise(
            problem,
            self.control.reshape(-1, 3),
            self.level.equations(problem),
            iterations=self.options.iterations,
            gain=gain,
            listener=heard,
        )
        self.control = solution.x.reshape(self.control.shape)
        self._record(solution)

    def _excess(self, figures: Quality | Mapping[str, Any]) -> float:
        return excess_of(figures, self.options)

    def _figures(self) -> Quality:
        return quality(self.level.state(self.control), self.level.dense, self.kind)

    def _record(self, solution: Solution) -> None:
        self.history.append(
            {
                "stage": len(self.history) + 1,
                "segments": self.level.net.segments,
                "developability": self.weight,
                "steps": len(solution.steps),
                "factorisations": solution.factorisations,
                "outcome": solution.outcome,
                "cost": solution.cost,
                **self._figures().plain(),
                "seconds": time.process_time() - self.begin,
            }
        )

    def _result(self) -> FitResult:
        figures, state = self._figures(), self.level.state(self.control)
        begun = self.start.info.get("start", {})
        tried = begun.get("tried", [begun.get("method", "")])
        status, reason = verdict(
            state, self.level, figures, self.options, tried, interrupted=self.interrupted
        )
        left = {
            "status": status,
            "reason": reason,
            "kind": self.kind,
            "continuation": self.options.continuation,
            "developability": self.weight,
            "anchor": self.anchor,
            "cost": self.history[-1]["cost"],
        }
        info = {**self.start.info, "fit": left}
        model = StripModel(
            self.control * self.length, self.start.closed_u, self.start.closed_i, self.kind, info
        )
        statistics = {
            "unknowns": int(self.control.size),
            "seconds": time.process_time() - self.begin,
            "solver": self.level.solver,
            **totals(self.history, figures, self.length),
        }
        return FitResult(model, status, reason, tuple(self.history), statistics)
