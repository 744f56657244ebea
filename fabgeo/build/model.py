"""The second stage: a strip model started on the surface, fitted to it and turned outwards."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.arrays import dot
from fabgeo.build.progress import Clock
from fabgeo.fitting.covering import seam_points
from fabgeo.fitting.fit import FitResult, fit
from fabgeo.fitting.options import FitOptions, Weights
from fabgeo.fitting.starts import Start, start
from fabgeo.project import Project
from fabgeo.strips.frames import frames
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import DesignSurface

SAFETY = 0.75
OF_AN_OFFSET = 0.004  # degrees of twist of models that are offset


def start_of(project: Project, surface: DesignSurface, base: Path) -> Start:
    """The initial strip model that the project's [strips] asks for."""
    asked = project.strips
    seed: Any = asked.seed
    if asked.start == "model":
        seed = base / str(asked.model)
    own = {"overhang": asked.overhang, "corners": asked.corners, "part": asked.part}
    options = {name: value for name, value in own.items() if value is not None}
    return start(
        surface,
        method=asked.start,
        strips=asked.count,
        segments=asked.segments,
        direction=asked.direction,
        seed=seed,
        kind=asked.kind,
        held=asked.boundary not in ("auto", "none"),
        **options,
    )


def fit_of(project: Project, initial: Start, clock: Clock | None = None) -> FitResult:
    """The model fitted to the surface, or to its continuation where the start overhangs it."""
    clock = clock or Clock()
    options = options_of(project, initial)

    def listen(news: Any) -> None:
        clock.tell(f"stage {news.stage}, {news.segments} segments, step {news.iteration}")

    return fit(initial.reference, initial.model, project.strips.kind, options, listen)


def options_of(project: Project, begun: Start | None = None) -> FitOptions:
    """What the fit of a start has to reach, by the project's limits; its own where it sets none.

    Three quarters of them: they are measured more densely than the fit looks. Conical and circular
    models, whose offsets rest on it, are made to twist less than a general one may.
    """
    asked, own = project.limits, FitOptions()
    twist = own.twist_limit_deg if asked.twist_max_deg is None else SAFETY * asked.twist_max_deg
    if project.cells or project.beams:
        twist = min(twist, OF_AN_OFFSET)
    seams = None
    if begun is not None and project.strips.part:
        seams = seam_points(begun.model, begun.reference)
    return FitOptions(
        twist_limit_deg=twist,
        kind_limit_deg=min(own.kind_limit_deg, SAFETY * np.degrees(asked.conical_residual)),
        boundary=project.strips.boundary,
        points=seams,
        weights=Weights(anchor=project.strips.anchor, cover=project.strips.cover),
    )


def outwards(model: StripModel, flip: bool = False) -> StripModel:
    """The same surface with normals t x e on the building's outer side.

    Outside is up for a roof; for a model that stands upright it is away from its middle axis; the
    edges are counted the other way round where the normals pointed inwards.

    Parameters
    ----------
    flip : bool
        Take the other side, where the building's outside is below or within.
    """
    if looks_inwards([model]) == flip:
        return model
    return model.with_control(model.control[::-1])


def looks_inwards(models: Sequence[StripModel]) -> bool:
    """Whether the normals t x e of models that are one building's point to its inner side."""
    found = [(model, frames(model, model.parameters(2))) for model in models]
    sides = [model.pairs(f.p) for model, f in found]
    middle = np.concatenate([((a + b) / 2.0).reshape(-1, 3) for a, b in sides])
    normal = np.concatenate([f.m.reshape(-1, 3) for _, f in found])
    weight = np.concatenate([f.length.ravel() for _, f in found])
    up = float(np.sum(normal[:, 2] * weight) / np.sum(weight))
    if abs(up) < 0.2:  # walls: away from the vertical axis through the middle
        away = middle - middle.mean(axis=0)
        away[:, 2] = 0.0
        up = float(np.sum(dot(normal, away) * weight))
    return up < 0.0
