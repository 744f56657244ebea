"""The strip models that a design stands on: one, or several side by side (``strips.parts``).

Glossary
--------
lane
    What parts are cut from: a strip, or one of those that `panels.width` divides it into.
number
    Lanes are counted on from model to model, as marks tell them.
part
    Which one, from 1, of how many models side by side, along the curve that their edges leave.
seam
    Where two of them meet: an outer edge of each.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from fabgeo.build.model import looks_inwards, start_of
from fabgeo.errors import GeometryError, InputError
from fabgeo.fitting.fit import FitResult
from fabgeo.fitting.starts import Start
from fabgeo.project import Project
from fabgeo.strips.model import MOST_PARTS, Patch, StripModel
from fabgeo.structures.patches import CutRule, cut
from fabgeo.surfaces.base import DesignSurface


@dataclass(frozen=True)
class Fitted:
    """One strip model of a design, from its start to the lanes that parts are cut from.

    Attributes
    ----------
    start : Start
    fit : FitResult
    model : StripModel
        The fitted model, turned outwards.
    counts : tuple of int
        How many lanes every strip is divided into.
    part : (int, int) or None
        Which one of how many; None of a model that is alone.
    first : int
        The number of its first lane.
    seams : (bool, bool)
        Whether other models go on beyond its first and beyond its last edge.
    """

    start: Start
    fit: FitResult
    model: StripModel
    counts: tuple[int, ...]
    part: tuple[int, int] | None = None
    first: int = 0
    seams: tuple[bool, bool] = (False, False)

    @cached_property
    def lanes(self) -> StripModel:
        """The same surface in strips no wider than panels may be."""
        return lanes_of(self.model, self.counts)

    @property
    def numbers(self) -> range:
        """The numbers of its lanes."""
        return range(self.first, self.first + sum(self.counts))

    @property
    def name(self) -> str:
        """What notes call it."""
        if self.part is None:
            return "model"
        return "model {} of {}".format(*self.part)

    def number(self, strip: int) -> int:
        """The number of a strip of the model: of its first lane."""
        return self.first + sum(self.counts[:strip])

    def own(self, patches: Sequence[Patch]) -> list[int]:
        """Which ones of all patches are on it."""
        return [k for k, patch in enumerate(patches) if patch.strip in self.numbers]


def side_by_side(
    projects: Sequence[Project], starts: Sequence[Start], fits: Sequence[FitResult]
) -> tuple[Fitted, ...]:
    """The models turned outwards, in the order of their strips' numbers.

    Models are turned all alike: where they look inwards, edges and models are counted the other
    way round.

    Parameters
    ----------
    projects, starts, fits
        Of each model, as `parts_of` names them.
    """
    step = -1 if looks_inwards([fit.model for fit in fits]) else 1
    out: list[Fitted] = []
    first = 0
    for project, start, fit in list(zip(projects, starts, fits, strict=True))[::step]:
        model = fit.model.with_control(fit.model.control[::step])
        part, counts = project.strips.part, tuple(lane_counts(project, model))
        before, after = (False, False) if part is None else (part[0] > 1, part[0] < part[1])
        seams = (before, after) if step == 1 else (after, before)
        out.append(Fitted(start, fit, model, counts, part, first, seams))
        first += sum(counts)
    return tuple(out)


def parts_of(project: Project) -> tuple[Project, ...]:
    """The project itself, or one for each of the models side by side that it asks for."""
    strips, count = project.strips, project.strips.parts
    if count is None:
        return (project,)
    own = ({"part": (k + 1, count), "parts": None} for k in range(count))
    return tuple(
        project.model_copy(update={"strips": strips.model_copy(update=changes)}) for changes in own
    )


def starts_of(project: Project, surface: DesignSurface, base: Path) -> list[Start]:
    """Where every model begins."""
    out = []
    for own in parts_of(project):
        with named(own, project):
            out.append(start_of(own, surface, base))
    return out


@contextmanager
def named(project: Project, whole: Project) -> Iterator[None]:
    """Errors about one of several models tell which one."""
    part = project.strips.part
    try:
        yield
    except (InputError, GeometryError) as error:
        if part is None or whole.strips.parts is None:
            raise
        where = "model {} of {}: ".format(*part) + error.where
        raise type(error)(where, error.problem, error.cure) from error


def lanes_of(model: StripModel, counts: Sequence[int]) -> StripModel:
    """The model with every strip divided evenly, into lanes."""
    return model if max(counts) == 1 else model.divided(counts)


def lane_counts(project: Project, model: StripModel) -> list[int]:
    """How many lanes every strip is divided into."""
    widest = None if project.panels is None else project.panels.width
    if widest is None:
        return [1] * model.strips
    _, widths = model.rulings(model.parameters())
    most = widths.max(axis=1)
    if most.max() > MOST_PARTS * widest:
        raise InputError(
            "panels.width",
            f"{widest:g} mm divides a strip of {most.max():.4g} mm into more than {MOST_PARTS:,}",
            "ask for wider panels",
        )
    return [int(np.ceil(w / widest - 1e-9)) for w in most]


def patches_of(project: Project, model: StripModel, first: int = 0) -> tuple[Patch, ...]:
    """The strips cut into patches as [panels] asks for; one patch a strip without it.

    `first` is the number of the first strip.
    """
    asked = project.panels
    if asked is None:
        rule = CutRule(count=1)
    elif asked.cuts is not None:
        rule = CutRule(at=tuple(asked.cuts))
    elif asked.count is not None:
        rule = CutRule(count=asked.count)
    elif asked.length is not None:
        rule = CutRule(length=asked.length)
    else:
        rule = CutRule(box=project.limits.transport_mm)
    return tuple(replace(patch, strip=first + patch.strip) for patch in cut(model, rule))
