"""The tables of a project file: what each stage is asked for.

Lengths are millimetres, angles degrees, as people write them.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

type Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
type NonNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
type Finite = Annotated[float, Field(allow_inf_nan=False)]
type Share = Annotated[float, Field(gt=0.0, le=1.0)]
type LayerName = Annotated[str, Field(pattern=r'^[^<>/\\":;?*|=,`\x00-\x1f]{1,255}$')]
"""What DXF takes for a layer's name; a line break in it would end the group it stands in."""
type Count = Annotated[int, Field(ge=1)]
type Segments = Annotated[int, Field(ge=1, le=10_000)]
type Models = Annotated[int, Field(ge=1, le=1000)]
type PanelCount = Annotated[int, Field(ge=1, le=100_000)]
type Radii = Annotated[list[Positive], Field(min_length=1)]
type Unit = Literal["mm", "cm", "m", "in", "ft"]
type Point = tuple[Finite, Finite, Finite]
type Overhang = Annotated[float, Field(gt=-0.4, allow_inf_nan=False)]


class Table(BaseModel):
    """A table of the project file: unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Surface(Table):
    """The design surface: a file, or a formula for x, y and z over a (u, v) domain.

    `file` is relative to the project file. `faces` picks faces of a CAD file by index or name.
    `given` names a surface that a Python script holds and passes to the build. `scale` enlarges
    what a file or formula describes: 50 for a model at 1:50.
    """

    file: str | None = None
    scale: Positive = 1.0
    given: str | None = None
    unit: Unit | None = None
    faces: list[int | str] | None = None
    define: dict[str, str | float] = {}
    x: str | None = None
    y: str | None = None
    z: str | None = None
    u: tuple[Finite, Finite] | None = None
    v: tuple[Finite, Finite] | None = None
    closed_u: bool = False
    closed_v: bool = False

    @model_validator(mode="after")
    def _one_source(self) -> Surface:
        formula = (self.x, self.y, self.z, self.u, self.v)
        named = (self.file is not None) + (self.given is not None)
        if named + any(part is not None for part in formula) != 1:
            raise ValueError("give either file, or a formula by x, y, z, u and v")
        if not named and any(part is None for part in formula):
            raise ValueError("a formula needs all of x, y, z, u and v")
        if not named and self.unit is None:
            raise ValueError('a formula needs its unit, such as unit = "m"')
        return self


class Strips(Table):
    """The strip model: how it starts and what it is fitted to.

    `overhang`: how far edges reach beyond the surface's boundary at their two ends, in parts of
    their length (start = "iso"; absent: only where no edge can end on the boundary), or below 0
    stop short of it. `corners`: four points, in mm, beside which the boundary is divided into the
    four sides between which edges and rulings run (start = "iso"). `cover`: the weight by which
    overhanging ends are kept beyond the boundary. `give`: strips may give way towards cheaper
    panels, up to so many mm from the surface. `parts`: so many geodesic models side by side that
    cover the surface together, each with `count` strips (start = "geodesic"); `part`: only one of
    them, from 1, of how many.
    """

    kind: Literal["general", "conical", "circular", "geodesic"] = "general"
    start: Literal[
        "auto", "iso", "principal", "sections", "mesh", "geodesic", "model", "network"
    ] = "auto"
    count: Count | None = None
    segments: Segments | None = None
    direction: Literal["u", "v", "larger", "smaller"] | None = None
    seed: Point | None = None
    model: str | None = None
    boundary: Literal["auto", "edges", "ends", "all", "none"] = "auto"
    anchor: NonNegative = 1e-3
    cover: NonNegative = 0.02
    overhang: tuple[Overhang, Overhang] | None = None
    corners: tuple[Point, Point, Point, Point] | None = None
    give: Positive | None = None
    part: tuple[Models, Models] | None = None
    parts: Models | None = None

    @model_validator(mode="after")
    def _parts_of_geodesics(self) -> Strips:
        for name in ("part", "parts"):
            if getattr(self, name) is not None and self.start != "geodesic":
                raise ValueError(f'{name} needs start = "geodesic"')
        if self.part is not None and self.parts is not None:
            raise ValueError("part is one of several models, parts all of them: leave one out")
        if self.parts is not None and self.give is not None:
            raise ValueError(
                "give draws one model: leave it out, or build models one by one with part"
            )
        if self.overhang is not None and self.start not in ("auto", "iso"):
            raise ValueError('overhang needs start = "iso"')
        if self.part is not None and self.part[0] > self.part[1]:
            raise ValueError(f"part: there is no model {self.part[0]} of {self.part[1]}")
        return self


class Panels(Table):
    """Panels on the strips: length along the strip, joint, layers and class tolerances.

    `length`, `count` of a strip and `cuts` (parameters) say the same: one of them at most.
    `width` limits their width across: a strip that is wider anywhere is divided evenly along its
    rulings; strips are counted after that. `trim` cuts panels along the boundary of the surface
    where the model overhangs it; absent: yes, unless cells or beams go on below them. `materials`
    names the material of single panels by their marks, others are of `material`. `ends` is how far
    a simpler shape may move the ends of panels along the strip, mm; absent: the joint's width over
    walls, else 30. `radii` are those that cylinders may have, or how many different ones at most,
    `radii_step` what they are multiples of. `choice`: panel by panel, all together, or thoroughly:
    with neighbouring strips placed at once however many panels there are, which takes longer.
    """

    length: Positive | None = None
    width: Positive | None = None
    count: PanelCount | None = None
    cuts: list[NonNegative] | None = None
    joint: NonNegative = 10.0
    thickness: Positive = 3.0
    material: str = "aluminium"
    materials: dict[str, str] = {}
    offset: Finite = 0.0
    tolerance: Positive = 1.0
    angle: Positive = 1.0
    choice: Literal["single", "joint", "thorough"] = "joint"
    ends: Positive | None = None
    radii: Radii | Count | None = None
    radii_step: Positive | None = None
    costs: dict[Literal["flat", "cylinder", "cone", "developable"], Positive] = {}
    layers: list[Layer] = []
    trim: bool | None = None

    @model_validator(mode="after")
    def _one_division(self) -> Panels:
        given = [name for name in ("length", "count", "cuts") if getattr(self, name) is not None]
        if len(given) > 1:
            raise ValueError(f"takes one of length, count and cuts, found {' and '.join(given)}")
        if self.cuts is not None and len(set(self.cuts)) < len(self.cuts):
            raise ValueError("cuts: holds a parameter twice")
        return self


class Layer(Table):
    """One more layer of panels at a distance from the model, positive outwards.

    Its name ends the marks of its panels, which are names of files.
    """

    name: Annotated[str, Field(pattern=r"^[\w.-]{1,40}$")]
    distance: Finite
    thickness: Positive
    material: str


class Cells(Table):
    """Box-shell cells between the model and its offset by `depth` (positive: outwards)."""

    depth: Finite = -200.0
    walls: bool = False
    wall_thickness: Positive = 4.0
    material: str = "steel"


class Beams(Table):
    """Curved beams along the edges, below the panels.

    Layout "mesh": straight beams from panel joint to panel joint, on a quad mesh.
    Between segments: end plates of a thickness, or a root gap and a V groove of `bevel` degrees.
    """

    section: Literal["I", "T", "box"] = "I"
    depth: Positive = 200.0
    standoff: NonNegative = 27.0
    web: Positive = 8.0
    flange_width: Positive = 180.0
    flange: Positive = 10.0
    material: str = "steel"
    edges: list[int] | None = None
    flanges: Literal["trajectory", "envelope"] = "trajectory"
    cuts: list[NonNegative] | None = None
    layout: Literal["curved", "mesh"] = "curved"
    end_plate: NonNegative = 0.0
    weld_gap: NonNegative = 0.0
    bevel: Annotated[float, Field(ge=0.0, le=120.0)] = 0.0


class Crossed(Beams):
    """Beams of a second strip model whose strips run across those of the first.

    `model` is the path of its ``strips.json`` (of an earlier build), relative to the project file.
    """

    model: str


class Connectors(Table):
    """Point fixings between panels and the outer flanges."""

    spacing: Positive = 800.0
    edge_distance: Positive = 45.0
    end_distance: Positive = 150.0
    standoff: Positive = 25.0
    reach: Positive = 8.0
    bolt: Literal["M8", "M10", "M12", "M16"] = "M10"
    slot: NonNegative = 0.0
    base_length: Positive = 100.0
    base_width: Positive = 50.0
    disc: Positive = 50.0


class Nesting(Table):
    """Nesting of the flat parts: all seconds together, or `steps` for repeatable layouts.

    `split`: panels, walls and beams' plates too long for every sheet are divided at rulings.
    """

    spacing: NonNegative = 6.0
    margin: NonNegative = 10.0
    rotations: Literal["grain", "steps", "free"] = "steps"
    seconds: Positive = 20.0
    steps: Count | None = None
    seed: int = 0
    split: bool = False


class Cutting(Table):
    """How outlines are written: version and curves of the DXF files."""

    version: Literal["R2010", "R2000", "R12"] = "R2010"
    curves: Literal["arcs", "splines", "polylines"] = "arcs"
    tolerance: Positive = 0.05
    layers: dict[str, LayerName] = {}

    @model_validator(mode="after")
    def _curves_of_the_version(self) -> Cutting:
        if self.version == "R12" and self.curves == "splines":
            raise ValueError('R12 has no splines: choose curves = "arcs", or version = "R2000"')
        return self


class Limits(Table):
    """Limits of the verdicts; one that is absent is reported without verdict.

    `covered_share` is the least share of the design surface that the strips have to cover; other
    limits are the most that a figure may be.
    """

    deviation_max_mm: Positive | None = None
    deviation_over_sag_limit: Positive | None = 1.2
    twist_max_deg: Positive | None = 0.02
    covered_share: Share | None = None
    kink_added_good_deg: Positive = 1.0
    kink_added_warn_deg: Positive = 3.0
    gap_max_mm: Positive = 2.0
    offset_distance_error_mm: Positive = 0.01
    conical_residual: Positive = 1e-4
    edge_length_error_mm: Positive = 0.02
    shared_edge_error_mm: Positive = 0.02
    area_error_rel: Positive = 1e-6
    refold_error_mm: Positive = 0.05
    volume_error_rel: Positive = 1e-6
    transport_mm: tuple[Positive, Positive, Positive] = (13600.0, 2480.0, 2500.0)
