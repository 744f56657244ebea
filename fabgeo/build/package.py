"""The last stage: every file of the hand-over package, and what a script gets back."""

from __future__ import annotations

import importlib.metadata
import os
import platform
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import fabgeo
from fabgeo.build.cache import Cache
from fabgeo.build.drawn import write_flats
from fabgeo.build.folder import Folder
from fabgeo.build.geometry import Design
from fabgeo.build.identity import identity
from fabgeo.build.models import write_models
from fabgeo.build.parallel import Work, results
from fabgeo.build.places import places
from fabgeo.build.progress import Clock
from fabgeo.build.record import record_of
from fabgeo.build.solids import Built, tree_of
from fabgeo.errors import InputError
from fabgeo.fitting.store import save_model
from fabgeo.panels.flat import FlatPart
from fabgeo.project import Project
from fabgeo.review.manifest import write_manifest
from fabgeo.review.record import ReviewRecord
from fabgeo.review.schedules import write_schedules
from fabgeo.review.verdicts import verdict_of, write_review
from fabgeo.sheets.stock import Nest

if TYPE_CHECKING:
    import build123d
    import cadquery

LIBRARIES = ("numpy", "scipy", "build123d", "ezdxf", "highspy", "packingsolver", "spyrrow")


@dataclass(frozen=True)
class Package:
    """A written package.

    Attributes
    ----------
    path : Path
    design : Design
    flats : mapping of mark to FlatPart
    nests : list of Nest
    built : mapping of mark to Built
        Solids of panels, plates and cells.
    review : dict
        What checks/review.json holds.
    record : ReviewRecord
    seconds : mapping of stage to float
        Wall-clock seconds.
    """

    path: Path
    design: Design
    flats: Mapping[str, FlatPart]
    nests: list[Nest]
    built: Mapping[str, Built]
    review: Mapping[str, Any]
    record: ReviewRecord
    seconds: Mapping[str, float]

    @property
    def name(self) -> str:
        """The project's name."""
        return self.design.project.name

    @cached_property
    def failures(self) -> list[str]:
        """One line for every verdict that fails, with the place."""
        lines = [
            f"{mark}: {part['reason']}"
            for mark, part in self.review["parts"].items()
            if part["verdict"] == "fail"
        ]
        where = self.record.where
        for key, found, bound, verdict in self.figures():
            if verdict == "fail":
                told = f": {where[key]}" if key in where else ""
                lines.append(f"package: {key} is {found}, limit {bound}{told}")
        return lines

    @property
    def passed(self) -> bool:
        """Whether no verdict fails."""
        return not self.failures

    def figures(self) -> Iterator[tuple[str, str, str, str]]:
        """Name, measured value, limit and verdict of every figure of the package, as text."""
        limits = {limit.key: limit for limit in self.record.limits}
        for key, value in self.review["summary"].items():
            if value is None:
                continue
            limit = limits.get(key)
            bound = "" if limit is None or limit.good is None else f"{limit.good:g}"
            verdict = "" if limit is None else verdict_of(limit, value)
            yield key, f"{value:.4g}", bound, verdict

    def as_dict(self) -> dict[str, Any]:
        """Plain data for scripts."""
        return {
            "name": self.name,
            "path": str(self.path),
            "passed": self.passed,
            "failures": self.failures,
            "notes": list(self.record.remarks),
            **self.review,
        }

    def to_build123d(self) -> build123d.Compound:
        """All parts as a build123d `Compound` with labels, colours and children."""
        from fabgeo.cad.convert import to_build123d

        return to_build123d(tree_of(self.design, dict(self.built)))

    def to_cadquery(self) -> cadquery.Assembly:
        """All parts as a CadQuery `Assembly` (extra ``cadquery``)."""
        from fabgeo.cad.convert import to_cadquery

        return to_cadquery(tree_of(self.design, dict(self.built)))


def write_package(
    folder: Folder,
    design: Design,
    flats: Mapping[str, FlatPart],
    nests: list[Nest],
    built: Mapping[str, Built],
    clock: Clock,
    jobs: int | None = None,
    cache: Cache | None = None,
) -> Package:
    """Write all files beside, then move them into place.

    Where SOURCE_DATE_EPOCH is set, files hold no dates of their own and no times spent: the same
    input gives the same bytes.
    """
    seconds = {} if os.environ.get("SOURCE_DATE_EPOCH") else clock.seconds
    project = design.project
    staged = folder.staged
    _write_strips(staged, design)
    with clock.stage("step"):
        write_models(folder, design, built, jobs, cache)
    if flats:
        with clock.stage("dxf", len(flats)):
            write_flats(folder, project, flats, nests, jobs, cache)
    with clock.stage("measure"):
        missing = not_asked(project)
        record = record_of(design, flats, nests, built, seconds, missing, jobs, cache)
        found = ((limit, record.summary.get(limit.key)) for limit in record.limits)
        failed = [limit.key for limit, value in found if verdict_of(limit, value) == "fail"]
        record = replace(record, where=places(design, failed))
    with clock.stage("review"):
        _write_papers(folder, record, project, jobs, cache)
        review = write_review(folder.place("checks/review.json"), record)
    write_manifest(
        staged,
        name=project.name,
        project=project.model_dump(mode="json", exclude_none=True),
        versions=versions(),
        seconds=seconds,
        not_asked=missing,
        known=folder.taken,
    )
    folder.finish()
    return Package(folder.path, design, flats, nests, built, review, record, clock.seconds)


def _write_strips(folder: Path, design: Design) -> None:
    """Every fitted model in a file of its own, which tells the number of its first strip."""
    for count, own in enumerate(design.models, 1):
        name = "strips.json" if count == 1 else f"strips-{count}.json"
        rows = own.fit.history
        history = [{k: v for k, v in stage.items() if k != "seconds"} for stage in rows]
        model = own.model
        if len(design.models) > 1:
            told = {"part": list(own.part or ()), "first_strip": own.first}
            model = replace(model, info={**model.info, **told})
        save_model(folder / name, model, history=history)


def _write_papers(
    folder: Folder, record: ReviewRecord, project: Project, jobs: int | None, cache: Cache | None
) -> None:
    """Schedules, page and drawings; other processes draw while this one writes the others."""
    from fabgeo.review.page import write_page

    drawn = _drawn(record, jobs, cache) if project.drawings and record.panels else None
    write_schedules(folder.staged, record)
    write_page(folder.place("index.html"), record)
    if project.ifc:
        from fabgeo.review.ifc import write_ifc

        write_ifc(folder.place("model/facade.ifc"), record)
    if drawn is not None:
        from fabgeo.review.drawings import write_panel_drawings

        write_panel_drawings(folder.place("drawings/panels.pdf"), record, drawn)


def _drawn(
    record: ReviewRecord, jobs: int | None, cache: Cache | None
) -> Iterator[tuple[str, ...]]:
    """Pages of the drawings."""
    from fabgeo.review.drawings import DrawnFrom, drawn_page, pages_of

    def depends(page: DrawnFrom) -> Any:
        return page.plain, [identity(record.flats[part.mark]) for part in page.parts]

    work = Work[DrawnFrom, tuple[str, ...]]("page", drawn_page, depends, lambda *_: (), light=True)
    return results(work, pages_of(record), jobs, cache)


def not_asked(project: Project) -> tuple[str, ...]:
    """Stages that the project does not ask for."""
    names = ("panels", "cells", "beams", "connectors", "nesting", "drawings")
    return tuple(name for name in names if not getattr(project, name))


def versions() -> dict[str, str]:
    """Versions of fabgeo, Python and the libraries whose results are in the files."""
    found = {"fabgeo": fabgeo.__version__, "python": platform.python_version()}
    for name in LIBRARIES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError as error:
            raise InputError(name, "is not installed", "install fabgeo again") from error
    return found
