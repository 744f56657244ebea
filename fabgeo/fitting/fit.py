"""Fit a strip model to a design surface (paper section 1, eq. 2)."""

from __future__ import annotations

from dataclasses import replace

from fabgeo.arrays import shown
from fabgeo.errors import InputError
from fabgeo.fitting.options import FitOptions
from fabgeo.fitting.result import FitResult, Listener, Progress
from fabgeo.fitting.run import WITHIN_REACH, Run
from fabgeo.fitting.store import check_info
from fabgeo.fitting.verdict import excess_of
from fabgeo.strips.frames import check_lengths, frames
from fabgeo.strips.model import KINDS, Kind, StripModel, check_model
from fabgeo.surfaces.base import DesignSurface, check_surface
from fabgeo.surfaces.trace_extension import Extended

__all__ = ["FitResult", "Listener", "Progress", "fit"]

MORE_STEPS = 3  # times those of a fit that ended near the limits


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
        Strips without folds, roughly on the surface, in the surface's unit of length. A model that
        a fit left (its `info` says so) is gone on with at the weights reached.
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
        If an argument is something else (a Start holds its model: ``start.model``), the kind is
        unknown or options contradict the surface.
    GeometryError
        If a strip of the start folds over, or has no normal; names strip and u.
    """
    if not isinstance(kind, str) or kind not in KINDS:
        raise InputError("fit", f"expected a kind of {KINDS}, found {shown(kind)}")
    check_surface("fit", surface)
    check_model("fit", start)
    check_info("fit: info", start.info)
    check_lengths("start", frames(start, start.parameters(2)))
    options = FitOptions() if options is None else options
    if not isinstance(options, FitOptions):
        raise InputError("fit", f"expected FitOptions, found {shown(options)}")
    if listener is not None and not callable(listener):
        raise InputError("fit", f"expected a function as listener, found {shown(listener)}")
    if options.across == 0:
        return _run(surface, start, kind, options, listener)
    coarse = replace(options, across=options.across - 1, refinements=0)
    first = fit(surface, _every_other_edge(start), kind, coarse, listener)
    halved = first.model.divided(2)
    if first.status == "interrupted":
        return replace(first, model=halved)
    found = _run(surface, halved, kind, options, listener)
    return replace(found, history=first.history + found.history)


def _run(
    surface: DesignSurface,
    start: StripModel,
    kind: Kind,
    options: FitOptions,
    listener: Listener | None,
) -> FitResult:
    """One fit; where it ends short of the limits, others that may reach them."""
    if options.continuation == "auto" and _was_let_go(start):
        options = replace(options, continuation="faded")
    first = Run(surface, start, kind, options, listener).result()
    history = first.history
    for more in _further(surface, kind, options, first):
        other = Run(surface, start, kind, more, listener).result()
        history += other.history
        if other.status == "converged":
            return replace(other, history=history)
        if other.status == "interrupted":
            return replace(first, status=other.status, reason=other.reason, history=history)
    return first


def _further(
    surface: DesignSurface, kind: Kind, options: FitOptions, first: FitResult
) -> list[FitOptions]:
    """What to try after a fit: letting go beyond the boundary; more steps, and finer knots."""
    if first.status != "limited":
        return []
    out = []
    chosen = options.continuation == "auto" and kind == "general"
    if chosen and isinstance(surface, Extended):
        out.append(replace(options, continuation="faded"))
    left = first.statistics
    figures = {"twist_deg": left["twist_max_deg"], "kind_deg": left["kind_max_deg"]}
    excess = excess_of(figures, options)
    if options.refinements > 0 and 1.0 < excess <= WITHIN_REACH:
        longer, finer = MORE_STEPS * options.iterations, options.refinements + 1
        out.append(replace(options, iterations=longer, refinements=finer))
    return out


def _was_let_go(start: StripModel) -> bool:
    return start.info.get("fit", {}).get("continuation") == "faded"


def _every_other_edge(model: StripModel) -> StripModel:
    least = 6 if model.closed_i else 2
    if model.strips % 2 or model.strips < least:
        raise InputError(
            "FitOptions.across",
            f"{model.strips} strips cannot be taken together in pairs",
            "ask for fewer times, or for another number of strips",
        )
    return model.with_control(model.control[::2])
