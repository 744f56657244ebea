"""The whole way: every stage in its turn, each from the results of those before.

    surface -> start -> fit -> panels, cells, beams -> flat parts -> nests -> solids -> files

`design` makes the geometry, `build_package` also writes the package.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

from fabgeo.arrays import checked_flag, checked_path
from fabgeo.build.arguments import checked_jobs
from fabgeo.build.cache import Cache
from fabgeo.build.fitted import Fitted, named, parts_of, patches_of, side_by_side, starts_of
from fabgeo.build.fixings import fixings_of
from fabgeo.build.flats import flats_of, refuse_oversize
from fabgeo.build.folder import Folder, open_folder
from fabgeo.build.geometry import Design, pair_of, structure_of
from fabgeo.build.giving import given_way
from fabgeo.build.materials import in_materials
from fabgeo.build.mixed import crossed_by, straightened
from fabgeo.build.model import fit_of, options_of
from fabgeo.build.nests import nests_of
from fabgeo.build.package import Package, write_package
from fabgeo.build.progress import Clock, Listener
from fabgeo.build.seams import seamed
from fabgeo.build.skin import inputs_of, layers_of, limits_of, panels_of
from fabgeo.build.solids import solids_of
from fabgeo.build.splitting import divided_patches, divided_structure
from fabgeo.build.surface import project_of, seen, surface_of
from fabgeo.build.trimming import trimmed, trims_panels
from fabgeo.cad.given import as_surface
from fabgeo.errors import GeometryError
from fabgeo.fitting.fit import FitResult
from fabgeo.fitting.starts import Start
from fabgeo.project import Project
from fabgeo.review.ifc import need_ifc
from fabgeo.strips.model import Patch, StripModel
from fabgeo.structures.fixing import Fixing
from fabgeo.surfaces.base import DesignSurface


def design(
    project: Project | Mapping[str, Any] | Path | str,
    *,
    surface: object | None = None,
    base: Path | None = None,
    listener: Listener | None = None,
    clock: Clock | None = None,
    cache: Cache | None = None,
    jobs: int | None = None,
    fixing: Fixing | None = None,
) -> Design:
    """All geometry of a project, nothing written.

    Parameters
    ----------
    project : Project, mapping or path
        A project, its tables as a project file holds them, or the path of its file.
    surface : object, optional
        A surface in memory, in millimetres, in place of the project's [surface]: see
        `fabgeo.as_surface` for what it may be.
    base : Path, optional
        Folder that the project's paths are relative to; by default the project file's own, or
        the current one.
    listener : callable, optional
        Hears a `fabgeo.build.progress.Progress` at every step.
    cache : Cache, optional
        What earlier builds left.
    jobs : int, optional
        As in `build_package`.
    fixing : Fixing, optional
        A fixing of the user's own in place of the project's (which still says that there are
        any): its `maker` draws the bracket, its holes are drilled.

    Raises
    ------
    InputError, GeometryError
        Naming the file, the setting or the part, and the cure.
    """
    project, base = project_of(project, surface, base)
    jobs = checked_jobs(jobs)
    clock, cache = clock or Clock(listener), cache or Cache()
    with clock.stage("surface"):
        wanted = surface_of(project, base) if surface is None else as_surface(surface)
    with clock.stage("start"):
        begun = starts_of(project, wanted, base)
    made = _skinned(project, wanted, begun, base, clock, cache, jobs)
    whole = made.patches  # only the skin is trimmed
    if trims_panels(project, begun):
        with clock.stage("trim"):
            made = trimmed(made)
    made = seamed(made)
    made = in_materials(made)
    if project.cells or project.beams:
        with clock.stage("structure"):
            made = straightened(replace(made, **_structure(project, made, whole, cache)))
    if project.connectors:
        with clock.stage("connectors"):
            fixed = fixings_of(project, made.panels, made.beams, jobs, cache, fixing)
            made = replace(made, **fixed)
    if project.crossed:
        with clock.stage("crossed"):
            made = crossed_by(made, base)
    return made


def build_package(
    project: Project | Mapping[str, Any] | Path | str,
    out: Path | str,
    *,
    surface: object | None = None,
    base: Path | None = None,
    jobs: int | None = None,
    fresh: bool = False,
    listener: Listener | None = None,
    fixing: Fixing | None = None,
) -> Package:
    """Build the hand-over package of a project into a folder.

    Parameters
    ----------
    project, surface, base, listener, fixing
        As in `design`.
    jobs : int, optional
        Processes for work that is independent per part; by default what joblib's
        `parallel_config` around the call says, else this process alone. A crash of the CAD
        kernel on one part is isolated where the work is done by other processes.
    out : path
        The output folder; a package there is replaced once the new one is complete.
    fresh : bool
        Ignore what an earlier build left to use again.

    Returns
    -------
    Package

    Raises
    ------
    InputError, GeometryError
        For bad input; nothing is written then.
    MissingExtraError
        If the project asks for what an extra brings that is not installed.
    """
    project, base = project_of(project, surface, base)
    fresh, jobs = checked_flag("fresh", fresh), checked_jobs(jobs)
    if project.ifc:
        need_ifc()
    clock = Clock(listener)
    with open_folder(checked_path("out", out)) as folder:
        cache = Cache(folder.cache, fresh)
        if fresh:
            folder.forget()
        shared: dict[str, Any] = {"clock": clock, "cache": cache, "jobs": jobs}
        made = design(project, surface=surface, base=base, fixing=fixing, **shared)
        package = _written(folder, made, **shared)
        cache.prune()
        return package


def _written(folder: Folder, made: Design, clock: Clock, cache: Cache, jobs: int | None) -> Package:
    """Flat parts, nests and solids of a design, and every file of its package."""
    with clock.stage("classes"):
        made = replace(made, tradeoff=_tradeoff(made, cache))
    with clock.stage("unfold", len(made.plates)):
        flats = flats_of(made.project, made.plates, jobs, clock, cache)
        refuse_oversize(made.project, made.plates, flats)
    with clock.stage("nest"):
        nests = nests_of(made.project, made.plates, flats, clock, cache, jobs)
    parts = (*made.plates, *made.cells)
    with clock.stage("solids", len(parts)):
        built = solids_of(parts, jobs, clock, cache)
    return write_package(folder, made, flats, nests, built, clock, jobs, cache)


def _skinned(
    project: Project,
    wanted: DesignSurface,
    begun: Sequence[Start],
    base: Path,
    clock: Clock,
    cache: Cache,
    jobs: int | None,
) -> Design:
    """The models fitted from their starts, and their panels."""
    projects = parts_of(project)
    with clock.stage("fit"):
        fits, bought, worth = [], "", {}
        for own, initial in zip(projects, begun, strict=True):
            with named(own, project):
                fit, bought, worth = _fitted(own, wanted, initial, base, clock, cache, jobs)
            fits.append(fit)
        models = side_by_side(projects, begun, fits)
    with clock.stage("panels"):
        whole = tuple(p for own in models for p in patches_of(project, own.lanes, own.first))
        patches = divided_patches(project, models, whole)
        panels, choices, saved, figures = cache.once(
            "choice",
            _panelled(project, models, patches),
            partial(panels_of, project, models, patches, jobs),
        )
        layers = layers_of(project, models, patches)
    made = Design(project, wanted, models, patches, panels, choices, layers)
    bought = "; ".join(filter(None, [bought, saved]))
    return replace(made, saved=bought, worth={**worth, **figures})


def _fitted(
    project: Project,
    wanted: DesignSurface,
    initial: Start,
    base: Path,
    clock: Clock,
    cache: Cache,
    jobs: int | None,
) -> tuple[FitResult, str, dict[str, float]]:
    """The fit of one model, and what it has bought to let its strips give way, if they may."""
    inputs, room = _fitted_to(project, wanted, initial, base), project.limits
    fitted = cache.once("fit", inputs, partial(fit_of, project, initial, clock))
    if project.strips.give is None:
        return fitted, "", {}
    return cache.once(
        "give",
        (inputs, _asked(project), _shape(fitted.model), room.transport_mm, room.deviation_max_mm),
        partial(given_way, project, wanted, initial, fitted, clock, jobs),
    )


def _tradeoff(made: Design, cache: Cache) -> tuple[Mapping[str, float], ...]:
    """Panel classes over the tolerance, for the page's plot."""
    from fabgeo.panels.tradeoff import by_deviation

    inputs = partial(inputs_of, made.project, made.models, made.patches)
    key = _panelled(made.project, made.models, made.patches)
    return cache.once("tradeoff", key, lambda: tuple(by_deviation(inputs())))


def _fitted_to(
    project: Project, surface: DesignSurface, initial: Start, base: Path
) -> tuple[object, ...]:
    """What a fit depends on: the surface's data, its start, [strips], and its own limits."""
    asked = project.surface
    data: object = b""
    if asked.file is not None:
        data = (base / asked.file).read_bytes()
    elif asked.given is not None:
        data = seen(surface)
    options = asdict(options_of(project))
    return asked.model_dump(), data, project.strips.model_dump(), initial.model, options


def _panelled(
    project: Project, models: Sequence[Fitted], patches: tuple[Patch, ...]
) -> tuple[object, ...]:
    """What panels depend on: geometry, and of the project what is not of materials or later."""
    shapes = [(_shape(own.lanes), own.first, own.seams) for own in models]
    return _asked(project), shapes, patches


def _asked(project: Project) -> tuple[object, ...]:
    """What a project asks of panels, but for materials and what comes later."""
    asked = project.panels
    panels = asked and asked.model_dump(exclude={"material", "materials", "layers", "trim"})
    return panels, asdict(limits_of(project))


def _structure(
    project: Project, made: Design, patches: tuple[Patch, ...], cache: Cache
) -> dict[str, Any]:
    """Cells, walls, beams from the cache or made, and the pair that bounds the cells."""
    tables = [table and table.model_dump() for table in (project.cells, project.beams)]
    inputs = (tables, project.limits.transport_mm, _shape(made.lanes), patches)
    try:
        pair = pair_of(project, made.lanes)
        make = partial(structure_of, project, made.lanes, patches, pair)
        built = divided_structure(project, cache.once("structure", inputs, make))
    except GeometryError as error:
        if made.fit.status != "limited":
            raise
        problem = f"{error.problem}; the fit ended short of its limits: {made.fit.reason}"
        raise GeometryError(error.where, problem, error.cure) from error
    return {**built, "pair": pair}


def _shape(model: StripModel) -> tuple[object, ...]:
    return model.control, model.closed_u, model.closed_i, model.kind
