"""What panels of a project could be made as, over tolerances: the table and plot of one command."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fabgeo.arrays import checked_path
from fabgeo.build.fitted import parts_of, patches_of, side_by_side, starts_of
from fabgeo.build.model import fit_of
from fabgeo.build.progress import Clock, Listener
from fabgeo.build.skin import inputs_of, limits_of, sheet_of
from fabgeo.build.surface import surface_of
from fabgeo.errors import InputError
from fabgeo.panels.limits import Costs
from fabgeo.panels.samples import PanelInput
from fabgeo.panels.tradeoff import TradeOffRow, plot, table, trade_off
from fabgeo.project import Project, read_project

DEVIATIONS_MM = (1.0, 3.0, 6.0)
ANGLES_DEG = (0.5, 1.0, 3.0)
NOTES = (
    "mm, deg: tolerances of deviation and added kink. Shares of the panels by class.",
    "cost: chosen together; least: proven by the solver, no choice of placements costs less;",
    "alone: chosen panel by panel. radii: different radii of cylinders. gap (mm) and added kink",
    "(degrees): the largest between panels as made.",
)


def tradeoff_of(
    project_path: Path | str, out: Path | None = None, listener: Listener | None = None
) -> dict[str, Any]:
    """Joint choices of a project's panels at every pair of tolerances.

    Parameters
    ----------
    project_path : path
        The project file; its costs, gap limit and radii hold, and whether its panels are chosen
        thoroughly; its tolerance and angle are replaced.
    out : Path, optional
        Folder for `tradeoff.csv`, `tradeoff.md` and `tradeoff.png`.
    listener : callable, optional
        Hears a `fabgeo.build.progress.Progress` at every step.

    Returns
    -------
    dict
        `rows`: one mapping a pair of tolerances (see `fabgeo.panels.tradeoff.TradeOffRow`);
        `panels`: how many; `notes`: what the columns mean; `files`: what was written.

    Raises
    ------
    InputError, GeometryError
        For bad input, and where the project asks for no panels.
    """
    path = checked_path("project file", project_path)
    project = read_project(path)
    if project.panels is None:
        raise InputError("[panels]", "is not in the project", "add it: the table is about panels")
    clock = Clock(listener)
    panels = _panels(project, path.parent, clock)
    with clock.stage("tradeoff", len(DEVIATIONS_MM) * len(ANGLES_DEG)):
        found = trade_off(
            panels,
            DEVIATIONS_MM,
            ANGLES_DEG,
            limits_of(project),
            Costs(**project.panels.costs),
            sheet_of(project),
            thorough=project.panels.choice == "thorough",
            radii=project.panels.radii,
            radii_step=project.panels.radii_step,
        )
        rows = list(clock.each(found))
    return {
        "panels": len(panels),
        "rows": [asdict(row) for row in rows],
        "notes": list(NOTES),
        "files": [] if out is None else _written(rows, out),
    }


def _panels(project: Project, folder: Path, clock: Clock) -> list[PanelInput]:
    """Gross panels of the fitted model."""
    with clock.stage("surface"):
        surface = surface_of(project, folder)
    projects = parts_of(project)
    with clock.stage("start"):
        starts = starts_of(project, surface, folder)
    with clock.stage("fit"):
        fits = [fit_of(own, start, clock) for own, start in zip(projects, starts, strict=True)]
    models = side_by_side(projects, starts, fits)
    patches = [p for own in models for p in patches_of(project, own.lanes, own.first)]
    return inputs_of(project, models, patches)


def _written(rows: Sequence[TradeOffRow], out: Path) -> list[str]:
    """Names of the files with the rows: numbers, a table, a plot."""
    out.mkdir(parents=True, exist_ok=True)
    with (out / "tradeoff.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(asdict(rows[0])))
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)
    (out / "tradeoff.md").write_text(table(rows) + "\n", encoding="utf-8")
    plot(rows, out / "tradeoff.png")
    return ["tradeoff.csv", "tradeoff.md", "tradeoff.png"]
