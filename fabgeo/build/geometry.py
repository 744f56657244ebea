"""The third stage: everything that a building is made of, as geometry in millimetres.

The panels themselves: `fabgeo.build.skin`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from fabgeo.build.fitted import Fitted
from fabgeo.build.trimming import Trims
from fabgeo.errors import GeometryError, InputError
from fabgeo.fitting.fit import FitResult
from fabgeo.fitting.starts import Start
from fabgeo.panels.classify import PanelChoice
from fabgeo.project import Beams, Project
from fabgeo.strips.axes import Axes
from fabgeo.strips.model import Patch, StripModel
from fabgeo.strips.offset import Offset, offset
from fabgeo.structures.beams import BeamRule, Section, beams
from fabgeo.structures.cells import cells
from fabgeo.structures.fixing import Fixing
from fabgeo.structures.parts import Beam, Cell, Connector, Plate
from fabgeo.structures.walls import coped_walls, walls
from fabgeo.surfaces.base import DesignSurface


@dataclass(frozen=True)
class Design:
    """All geometry of a project; what is not asked for is empty.

    Attributes
    ----------
    project : Project
    surface : DesignSurface
    models : tuple of Fitted
        One, or several side by side that cover the surface together.
    patches : tuple of Patch
        Their strips counted on from model to model.
    panels : tuple of Plate
        Net panels, on the shapes that they are made as, in the order of `patches`.
    choices : mapping of mark to PanelChoice
    layers : tuple of Plate
        Panels of further layers.
    cells : tuple of Cell
    walls : tuple of Plate
    beams : tuple of Beam
    connectors : tuple of Connector
    products : mapping of key to Fixing
        Parameters of the connectors' products.
    complaints : mapping of panel mark to (verdict, reason)
        Where no fixing could be placed, and clashes.
    pair : Offset or None
        The offset pair that bounds the cells.
    trims : Trims or None
        What became of the panels that overhang the surface's boundary; None if none was cut.
    saved : str
        What choosing panels together saves, and at most could.
    worth : mapping
        The same, what giving way bought, and how seams meet, as figures of the summary.
    remarks : tuple of str
        What was measured of seams, and of a structure of two layers.
    tradeoff : tuple of mappings
        Panel classes over the tolerance, where a package is built.
    """

    project: Project
    surface: DesignSurface
    models: tuple[Fitted, ...]
    patches: tuple[Patch, ...] = ()
    panels: tuple[Plate, ...] = ()
    choices: Mapping[str, PanelChoice] = field(default_factory=dict)
    layers: tuple[Plate, ...] = ()
    cells: tuple[Cell, ...] = ()
    walls: tuple[Plate, ...] = ()
    beams: tuple[Beam, ...] = ()
    connectors: tuple[Connector, ...] = ()
    products: Mapping[str, Fixing] = field(default_factory=dict)
    complaints: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    pair: Offset | None = None
    trims: Trims | None = None
    saved: str = ""
    worth: Mapping[str, float] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    tradeoff: tuple[Mapping[str, float], ...] = ()

    @property
    def only(self) -> Fitted:
        """The model of a design that has one.

        Raises
        ------
        InputError
            If it has several.
        """
        count = len(self.models)
        if count != 1:
            raise InputError("design", f"has {count} models side by side", "take one of .models")
        return self.models[0]

    @property
    def start(self) -> Start:
        """Where the only model began."""
        return self.only.start

    @property
    def fit(self) -> FitResult:
        """The fit of the only model."""
        return self.only.fit

    @property
    def model(self) -> StripModel:
        """The only model, fitted and turned outwards."""
        return self.only.model

    @property
    def lanes(self) -> StripModel:
        """The only model's surface in strips no wider than panels may be."""
        return self.only.lanes

    @property
    def notes(self) -> tuple[str, ...]:
        """What people should know of the models: why a fit fell short, what trimming cut."""
        why = (
            f"{'' if own.part is None else own.name + ': '}fit {own.fit.status}: {own.fit.reason}"
            for own in self.models
            if own.fit.status != "converged"
        )
        trims = () if self.trims is None else (f"trim: {self.trims}",)
        saved = (self.saved,) if self.saved else ()
        return (*why, *trims, *saved, *self.remarks)

    @property
    def plates(self) -> tuple[Plate, ...]:
        """Everything that is cut flat: panels, layers, walls, and the plates of beams."""
        of_beams = tuple(plate for beam in self.beams for plate in beam.plates)
        return self.panels + self.layers + self.walls + of_beams


def pair_of(project: Project, model: StripModel) -> Offset | None:
    """The offset pair that bounds the cells.

    Raises
    ------
    GeometryError
        If the model's kind admits no cells or beams, or the offset folds.
    """
    if (project.cells or project.beams) and model.kind not in ("conical", "circular"):
        raise GeometryError(
            "[cells]" if project.cells else "[beams]",
            f"need a conical or circular model, but strips.kind is {model.kind!r}: only these "
            "have offsets with developable strips between",
            'set strips.kind = "conical", or leave [cells] and [beams] out',
        )
    return offset(model, project.cells.depth) if project.cells else None


def structure_of(
    project: Project, model: StripModel, patches: tuple[Patch, ...], pair: Offset | None
) -> dict[str, Any]:
    """Cells, walls and beams, as far as asked for; `pair` of `pair_of`."""
    out: dict[str, Any] = {}
    if project.cells and pair:
        out["cells"] = tuple(cells(model, patches, project.cells.depth, pair=pair))
        if project.cells.walls:
            out["walls"] = tuple(_walls(project, model, patches, pair.axes))
    if project.beams:
        out["beams"] = tuple(_beams(project, model))
    return out


def _walls(
    project: Project, model: StripModel, patches: tuple[Patch, ...], field: Axes
) -> list[Plate]:
    """Walls at the rulings: coped to the beams where every edge has one."""
    asked, of_beams = project.cells, project.beams
    if asked is None:
        return []
    plate = (asked.wall_thickness, asked.material)
    if of_beams is not None and of_beams.edges is None and of_beams.layout == "curved":
        return coped_walls(
            model,
            patches,
            section_of(of_beams),
            *plate,
            construction=of_beams.flanges,
            field=field,
        )
    low, high = sorted((0.0, asked.depth))
    clearance = of_beams.web / 2.0 if of_beams else 0.0
    return walls(model, patches, (low, high), *plate, clearance=clearance, field=field)


def _beams(project: Project, model: StripModel) -> list[Beam]:
    asked = project.beams
    if asked is None:
        return []
    if asked.edges and max(asked.edges) >= model.edges:
        raise InputError(
            "beams.edges", f"the model has edges 0 to {model.edges - 1}, found {max(asked.edges)}"
        )
    if asked.layout == "mesh":
        return []  # made by `fabgeo.build.mixed`
    return beams(model, section_of(asked), beam_rule(project, asked), asked.edges)


def beam_rule(project: Project, asked: Beams) -> BeamRule:
    """How beams are cut and joined."""
    return BeamRule(
        at=None if asked.cuts is None else tuple(asked.cuts),
        box=project.limits.transport_mm,
        gap=asked.weld_gap,
        end_plate=asked.end_plate,
        bevel=asked.bevel,
        construction=asked.flanges,
    )


def section_of(asked: Beams) -> Section:
    """The beams' section."""
    return Section(
        outer=-asked.standoff,
        depth=asked.depth,
        web=asked.web,
        flange_outer=asked.flange,
        flange_inner=0.0 if asked.section == "T" else asked.flange,
        width_outer=asked.flange_width,
        width_inner=asked.flange_width,
        box=asked.flange_width / 2.0 if asked.section == "box" else 0.0,
        material=asked.material,
    )
