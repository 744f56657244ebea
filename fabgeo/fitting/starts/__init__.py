"""Initial strip models: what an optimisation starts from (paper, "Initializing optimization").

Every method has its file; `start` calls it, checks the result for folds and says why it was chosen.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from inspect import signature
from typing import Any

import numpy as np

from fabgeo.errors import FabgeoError, InputError
from fabgeo.fitting.starts.geodesic import geodesic_start
from fabgeo.fitting.starts.hindrance import hindrance
from fabgeo.fitting.starts.iso import iso_start
from fabgeo.fitting.starts.mesh import mesh_start
from fabgeo.fitting.starts.model import model_start
from fabgeo.fitting.starts.network import network_start
from fabgeo.fitting.starts.principal import principal_start
from fabgeo.fitting.starts.quality import Quality, check_folds, quality
from fabgeo.fitting.starts.sections import sections_start
from fabgeo.fitting.starts.trial import UNTWISTED, trial_twist
from fabgeo.strips.model import Kind, StripModel
from fabgeo.surfaces.base import DesignSurface
from fabgeo.surfaces.creases import sharpest
from fabgeo.surfaces.trace_extension import Extended

# Every method: (surface, strips, segments, direction, seed, **options) -> model, notes.
_STARTS: dict[str, Callable[..., tuple[StripModel, list[str]]]] = {
    "iso": iso_start,
    "principal": principal_start,
    "sections": sections_start,
    "mesh": mesh_start,
    "geodesic": geodesic_start,
    "network": network_start,
    "model": model_start,
}
METHODS: tuple[str, ...] = ("auto", *_STARTS)
# Options of `draw.model_of_net` that several methods pass on.
_PLAIN = (("iso", "v"), ("iso", "u"))
_PRINCIPAL = (("principal", "larger"), ("principal", "smaller"))
_FURTHER = (*_PRINCIPAL, ("geodesic", "v"), ("geodesic", "u"))
_OF_KIND: dict[Kind, tuple[tuple[str, str], ...]] = {  # what "auto" tries first
    "general": _PLAIN,
    "conical": _PRINCIPAL,
    "circular": _PRINCIPAL,
    "geodesic": _PLAIN,
}
ALL_ROUND = 0.1  # of its length and width, by which a net for a conical model overhangs
SHORT = 0.04  # of their length, by which edges stop before a boundary that has no corner there
_SHARED = ("sag", "conjugate", "project", "ends")


@dataclass(frozen=True)
class Candidate:
    """One start that was tried: its method, direction, figures, and what spoke against it.

    `trial` is the twist in degrees that a short fit of it left, None if none was made.
    """

    method: str
    direction: str
    quality: Quality | None
    problem: str = ""
    model: StripModel | None = field(default=None, repr=False)
    notes: tuple[str, ...] = ()
    trial: float | None = None

    @property
    def works(self) -> bool:
        """Whether a short fit made it developable."""
        return self.trial is not None and self.trial <= UNTWISTED

    @property
    def name(self) -> str:
        """Method and direction, such as ``iso v``."""
        return f"{self.method} {self.direction}".strip()

    @property
    def score(self) -> float:
        """The lower the better: degrees of twist, uncovered area and uneven widths in one number.

        A degree of twist weighs as much as 1 % of the surface uncovered or as widths 20 % over the
        mean, one that a short fit left five times as much; a fold excludes.
        """
        q = self.quality
        if q is None or q.folds > 0.0:
            return float("inf")
        twist = q.twist_rms if self.trial is None else 5.0 * self.trial
        return twist + 100.0 * (1.0 - q.coverage) + 5.0 * (q.width_ratio - 1.0)

    def told(self) -> str:
        """Its figures, or what spoke against it."""
        after = "" if self.trial is None else f", {self.trial:.2g} deg after a short fit"
        return self.problem or f"{self.quality}{after}"


@dataclass(frozen=True)
class Start:
    """An initial strip model, the method it came by, and why.

    Attributes
    ----------
    model : StripModel
    method : str
        The method used ("auto" is replaced by the chosen one).
    why : str
        The reason in words, with the figures it rests on.
    candidates : list of Candidate
        What was tried, best first (one, unless "auto").
    notes : list of str
        What the method found: umbilics, resampling, parameters made conjugate.
    reference : DesignSurface
        What to fit the model to: the surface itself, or, where the model overhangs its boundary,
        the surface with its smooth continuation (`surfaces.trace_extension.Extended`).
    """

    model: StripModel
    method: str
    why: str
    candidates: list[Candidate]
    notes: list[str]
    reference: DesignSurface

    @property
    def overhangs(self) -> bool:
        """Whether the model reaches beyond the boundary, to be trimmed (`strips.trim`)."""
        return isinstance(self.reference, Extended)


def start(
    surface: DesignSurface,
    method: str = "auto",
    strips: int | None = None,
    segments: int | None = None,
    direction: str | None = None,
    seed: Any = None,
    kind: Kind = "general",
    **options: Any,
) -> Start:
    """An initial strip model for a design surface.

    Parameters
    ----------
    surface : DesignSurface
    method : str
        "auto" measures candidates and chooses; or one of `METHODS`.
    strips, segments : int, optional
        Numbers wanted; by default from a sag target (option `sag`).
    direction : str, optional
        Which family the edges follow, in the method's own words ("u" or "v").
    seed : optional
        What the method starts from: a point, a curve, or a previous model.
    kind : str
        What the model will be fitted to: "auto" begins with principal lines for conical and
        circular models, which have the property already.
    **options
        Further options of the method's own function.

    Raises
    ------
    InputError
        For unknown methods or options, and strip counts that the surface can't hold.
    GeometryError
        If the start folds, naming strip and u.
    """
    if method not in METHODS:
        raise InputError("start method", f"expected one of {', '.join(METHODS)}, found {method!r}")
    if method == "auto":
        return _auto(surface, strips, segments, direction, kind, options)
    model, notes = _called(method, surface, strips, segments, direction, seed, options)
    check_folds(model, surface, method)
    found = quality(model, surface)
    model = _told(model, method, direction, notes)
    candidate = Candidate(method, direction or "", found, "", model, tuple(notes))
    return Start(
        model,
        method,
        f"{candidate.name} was asked for: {found}",
        [candidate],
        notes,
        _reference(model, surface),
    )


def _called(
    method: str,
    surface: DesignSurface,
    strips: int | None,
    segments: int | None,
    direction: str | None,
    seed: Any,
    options: dict[str, Any],
) -> tuple[StripModel, list[str]]:
    function = _STARTS[method]
    known = signature(function).parameters
    for name in options:
        if name not in known and name not in _SHARED:
            near = get_close_matches(name, [*known, *_SHARED], 1)
            cure = f"did you mean '{near[0]}'?" if near else ""
            raise InputError("start options", f"'{method}' has no option '{name}'", cure)
    return function(surface, strips, segments, direction, seed, **options)


def _auto(
    surface: DesignSurface,
    strips: int | None,
    segments: int | None,
    direction: str | None,
    kind: Kind,
    options: dict[str, Any],
) -> Start:
    asked = strips, segments
    # An overhang is one of parameter lines: principal nets have their own.
    plans = _plans(surface, direction, "general" if "overhang" in options else kind)
    tried = [_tried(surface, *asked, *plan, kind, options) for plan in plans]
    if len(tried) > 1:
        tried = _trials(tried, surface, kind)
        if "overhang" not in options and not any(c.score < float("inf") for c in tried):
            tried += _trials(_shorter(tried, surface, asked, kind, options), surface, kind)
        further = direction is None and len(surface.loops) == 1
        if further and not any(c.works for c in tried):
            others = [plan for plan in (*_PLAIN, *_FURTHER) if plan not in plans]
            more = [_tried(surface, *asked, *plan, kind, options) for plan in others]
            tried += _trials(more, surface, kind)
    tried.sort(key=lambda c: (c.score == float("inf"), c.trial is None, c.score))
    best = tried[0]
    if best.model is None or best.score == float("inf"):
        reasons = "; ".join(f"{c.name}: {c.problem}" for c in tried)
        why = f"no start holds on it: {hindrance(surface)} ({reasons})"
        raise InputError(surface.name, why, _cure(surface))
    return Start(
        best.model,
        best.method,
        _why(tried),
        tried,
        list(best.notes),
        _reference(best.model, surface),
    )


def _all_round(
    surface: DesignSurface, method: str, kind: Kind, options: dict[str, Any]
) -> dict[str, Any]:
    """Options of iso and mesh starts: a net of principal lines overhangs, as nothing holds it."""
    if kind not in ("conical", "circular") or not surface.loops or "overhang" in options:
        return options
    own = {"iso": {"overhang": ALL_ROUND, "across": True}, "mesh": {"around": True}}
    return {**options, **own.get(method, {})}


def _shorter(
    tried: list[Candidate],
    surface: DesignSurface,
    asked: tuple[int | None, int | None],
    kind: Kind,
    options: dict[str, Any],
) -> list[Candidate]:
    """Iso starts again, ending short of a boundary on which they fold.

    Where a boundary goes round a corner of the net smoothly, edge and ruling have one direction.
    """
    less = {**options, "overhang": (-SHORT, -SHORT)}
    return [
        _tried(surface, *asked, c.method, c.direction, kind, less)
        for c in tried
        if c.method == "iso"
    ]


def _cure(surface: DesignSurface) -> str:
    """What keeps strips off a surface of several faces, and what to do."""
    crease = sharpest(surface)
    if crease is None:
        return "name a method"
    return (
        f"no strip is smooth across its creases ({crease}): choose the faces of one smooth sheet "
        "by surface.faces (`fabgeo inspect` lists them), or name a method"
    )


def _trials(candidates: list[Candidate], surface: DesignSurface, kind: Kind) -> list[Candidate]:
    """The candidates from the best on, with short fits of them until one works."""
    done: list[Candidate] = []
    for candidate in sorted(candidates, key=lambda c: c.score):
        model = candidate.model
        if model is None or candidate.score == float("inf") or any(c.works for c in done):
            done.append(candidate)
        else:
            twist, problem = trial_twist(model, _reference(model, surface), kind)
            done.append(replace(candidate, trial=twist, problem=problem))
    return done


def _tried(
    surface: DesignSurface,
    strips: int | None,
    segments: int | None,
    method: str,
    way: str,
    kind: Kind,
    options: dict[str, Any],
) -> Candidate:
    options = _all_round(surface, method, kind, options)
    try:
        model, notes = _called(method, surface, strips, segments, way or None, None, options)
    except FabgeoError as error:
        return Candidate(method, way, None, str(error))
    found = quality(model, surface)
    problem = ""
    if found.fold_at is not None:
        problem = f"folds at strip {found.fold_at[0]}, u = {found.fold_at[1]:.2f}"
    model = _told(model, method, way, notes)
    return Candidate(method, way, found, problem, model, tuple(notes))


def _plans(surface: DesignSurface, direction: str | None, kind: Kind) -> list[tuple[str, str]]:
    if hasattr(surface, "sections"):
        return [("sections", "")]
    plans = [("mesh", way) for _, way in _PLAIN if getattr(surface, "grid", None) is not None]
    plans += _OF_KIND[kind] if len(surface.loops) == 1 else _PLAIN
    if direction is None:
        return plans
    chosen = dict.fromkeys(p for p in (*plans, *_PLAIN) if p[1] == direction)
    return list(chosen) or [("iso", direction)]


def _reference(model: StripModel, surface: DesignSurface) -> DesignSurface:
    """The surface, continued if a border of the model lies beside it by a tenth of a ruling."""
    if not surface.loops:
        return surface
    extended = Extended(surface)
    points = model.points(model.parameters(2))
    width = float(np.median(np.linalg.norm(np.subtract(*model.pairs(points)), axis=-1)))
    beyond = extended.beyond(points.reshape(-1, 3))
    return extended if float(np.quantile(beyond, 0.98)) > 0.1 * width else surface


def _why(tried: list[Candidate]) -> str:
    best, *others = tried
    words = f"{best.name}: {best.told()}"
    for other in others:
        words += f"; {other.name}: {other.told()}"
    return f"chosen as the least twisted, most even and most covering of {len(tried)}: {words}"


def _told(model: StripModel, method: str, direction: str | None, notes: list[str]) -> StripModel:
    info = {**model.info, "start": {"method": method, "direction": direction, "notes": notes}}
    return model.with_control(model.control, info=info)
