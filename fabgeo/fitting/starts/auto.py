"""The start that "auto" chooses: candidates are made, measured, fitted for a moment, compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from fabgeo.errors import InputError
from fabgeo.fitting.hindrance import hindrance
from fabgeo.fitting.starts.candidate import ALL_ROUND, COVERING, Candidate, trials, tried
from fabgeo.strips.model import Kind
from fabgeo.surfaces.base import DesignSurface
from fabgeo.surfaces.creases import sharpest

PLAIN = (("iso", "v"), ("iso", "u"))
PRINCIPAL = (("principal", "larger"), ("principal", "smaller"))
GEODESIC = (("geodesic", "v"), ("geodesic", "u"))
OF_KIND: dict[Kind, tuple[tuple[str, str], ...]] = {  # what is tried first
    "general": PLAIN,
    "conical": PRINCIPAL,
    "circular": PRINCIPAL,
    "geodesic": GEODESIC,
}
FURTHER: dict[Kind, tuple[tuple[str, str], ...]] = {  # and where none of these works
    "general": (*PRINCIPAL, *GEODESIC),
    "conical": PLAIN,  # geodesics are hardly ever principal lines
    "circular": PLAIN,
    "geodesic": (*PLAIN, *PRINCIPAL),
}
FAR = 1.1  # of the sag limit: what a short fit leaves where the border holds strips off
NEARER = 0.9  # of its deviation: a start with a free border that brings less is not taken
SHORT = 0.04  # of their length, by which edges stop before a boundary that has no corner there


def candidates_of(
    surface: DesignSurface,
    asked: tuple[int | None, int | None],
    direction: str | None,
    kind: Kind,
    options: dict[str, Any],
    held: bool = False,
) -> list[Candidate]:
    """What was tried, best first; `asked` are numbers of strips and segments.

    A model that is to be `held` to the boundary starts on it.

    Raises
    ------
    InputError
        If no start holds, with the property of the surface that forbids it.
    """

    def made(plans: Sequence[tuple[str, str]], options: dict[str, Any]) -> list[Candidate]:
        return [tried(surface, *asked, *plan, kind, options) for plan in plans]

    # An overhang is one of parameter lines: principal nets have their own.
    plans = _plans(surface, direction, "general" if "overhang" in options else kind)
    found = made(plans, options)
    if len(found) > 1:
        found = trials(found, surface, kind)
        if "overhang" not in options and not any(c.holds for c in found):
            # Where a boundary goes round a corner of the net smoothly, edge and ruling have one
            # direction: iso starts again, ending short of a boundary on which they fold.
            again = [(c.method, c.direction) for c in found if c.method == "iso"]
            less = {**options, "overhang": (-SHORT, -SHORT)}
            found += trials(made(again, less), surface, kind)
        if direction is None and len(surface.loops) == 1 and not any(c.promises for c in found):
            others = [plan for plan in FURTHER[kind] if plan not in plans]
            best = min(c.score for c in found)
            found += trials(made(others, options), surface, kind, best)
    found.sort(key=lambda c: (not c.holds, c.trial is None, c.score))
    if not found[0].holds:
        reasons = "; ".join(f"{c.name}: {c.problem}" for c in found)
        words = f"no start holds on it: {hindrance(surface)} ({reasons})"
        raise InputError(surface.name, words, _cure(surface))
    if not held and "overhang" not in options and kind == "general" and len(surface.loops) == 1:
        found = _freed(found, surface, asked, options)
    return [_with_tried(found[0], found), *found[1:]]


def _freed(
    found: list[Candidate],
    surface: DesignSurface,
    asked: tuple[int | None, int | None],
    options: dict[str, Any],
) -> list[Candidate]:
    """The candidates, the best with a free border where its own keeps strips off the surface.

    Where sides of the boundary meet in directions that are not conjugate, no strip keeps to both.
    """
    best, *others = found
    if best.method != "iso" or best.trial is None or best.trial.over_sag <= FAR:
        return found
    free = {**options, "overhang": ALL_ROUND, "across": True}
    twin = tried(surface, *asked, best.method, best.direction, "general", free)
    (twin,) = trials([twin], surface, "general")
    covers = twin.quality and best.quality and twin.quality.coverage >= best.quality.coverage
    if not (covers and twin.works and twin.trial):
        return found
    if twin.trial.deviation > NEARER * best.trial.deviation:
        return found
    words = f"{best.told()}, {best.trial.over_sag:.2f} times the sag limit off"
    words += " where the boundary holds it"
    return [twin, replace(best, problem=words), *others]


def _with_tried(best: Candidate, found: list[Candidate]) -> Candidate:
    """The candidate whose model tells what else was tried: a fit does not advise it again."""
    assert best.model is not None  # or it would not hold
    model = best.model
    start = {**model.info["start"], "tried": sorted({c.method for c in found})}
    told = model.with_control(model.control, info={**model.info, "start": start})
    return replace(best, model=told)


def _plans(surface: DesignSurface, direction: str | None, kind: Kind) -> list[tuple[str, str]]:
    if hasattr(surface, "sections"):
        return [("sections", "")]
    plans = [("mesh", way) for _, way in PLAIN if getattr(surface, "grid", None) is not None]
    plans += OF_KIND[kind] if len(surface.loops) == 1 else PLAIN
    if direction is None:
        return plans
    chosen = dict.fromkeys(p for p in (*plans, *PLAIN) if p[1] == direction)
    return list(chosen) or [("iso", direction)]


def _cure(surface: DesignSurface) -> str:
    """What keeps strips off a surface of several faces, and what to do."""
    crease = sharpest(surface)
    if crease is None:
        return "name a method"
    return (
        f"no strip is smooth across its creases ({crease}): choose the faces of one smooth sheet "
        "by surface.faces (`fabgeo inspect` lists them), or name a method"
    )


def why(candidates: list[Candidate], surface: DesignSurface) -> str:
    """What the first was chosen for, with the figures of all, and why it covers no more."""
    best, *others = candidates
    words = f"{best.name}: {best.told()}"
    for other in others:
        words += f"; {other.name}: {other.told()}"
    words = (
        f"chosen as the least twisted, most even and most covering of {len(candidates)}: {words}"
    )
    if best.quality is not None and best.quality.coverage < COVERING:
        words += f"; no more of it is covered since {hindrance(surface)}"
    return words
