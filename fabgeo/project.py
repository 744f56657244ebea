"""The project file: what `fabgeo build` is asked for, checked to the last key.

Lengths are millimetres, angles degrees, as people write them. Every table is optional but
[surface]; a stage whose table is absent is not asked for.
"""

from __future__ import annotations

import difflib
import re
import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from fabgeo.errors import InputError

type Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
type NonNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
type Finite = Annotated[float, Field(allow_inf_nan=False)]
type Count = Annotated[int, Field(ge=1)]
type Unit = Literal["mm", "cm", "m", "in", "ft"]
type Point = tuple[Finite, Finite, Finite]


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
    their length (start = "iso"; absent: only where no edge can end on the boundary). `cover`: the
    weight by which such ends are kept beyond the boundary. `give`: strips may give way towards
    cheaper panels, up to so many mm from the surface.
    """

    kind: Literal["general", "conical", "circular", "geodesic"] = "general"
    start: Literal[
        "auto", "iso", "principal", "sections", "mesh", "geodesic", "model", "network"
    ] = "auto"
    count: Count | None = None
    segments: Count | None = None
    direction: Literal["u", "v", "larger", "smaller"] | None = None
    seed: Point | None = None
    model: str | None = None
    boundary: Literal["auto", "edges", "ends", "all", "none"] = "auto"
    anchor: NonNegative = 1e-2
    cover: NonNegative = 0.0
    overhang: tuple[NonNegative, NonNegative] | None = None
    give: Positive | None = None


class Panels(Table):
    """Panels on the strips: length along the strip, joint, layers and class tolerances.

    `width` limits their width across: a strip that is wider anywhere is divided evenly along its
    rulings; strips are counted after that. `trim` cuts panels along the boundary of the surface
    where the model overhangs it; absent: yes, unless cells or beams go on below them. `materials`
    names the material of single panels by their marks, others are of `material`. `ends` is how far
    a simpler shape may move the ends of panels along the strip, mm; absent: the joint's width over
    walls, else 30. `radii` are those that cylinders may have, or how many different ones at most,
    `radii_step` what they are multiples of.
    """

    length: Positive | None = None
    width: Positive | None = None
    count: Count | None = None
    cuts: list[NonNegative] | None = None
    joint: NonNegative = 10.0
    thickness: Positive = 3.0
    material: str = "aluminium"
    materials: dict[str, str] = {}
    offset: Finite = 0.0
    tolerance: Positive = 1.0
    angle: Positive = 1.0
    choice: Literal["single", "joint"] = "joint"
    ends: Positive | None = None
    radii: list[Positive] | Count | None = None
    radii_step: Positive | None = None
    costs: dict[Literal["flat", "cylinder", "cone", "developable"], Positive] = {}
    layers: list[Layer] = []
    trim: bool | None = None


class Layer(Table):
    """One more layer of panels at a distance from the model, positive outwards."""

    name: str
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


class Material(Table):
    """Density in kg/m3, E and yield stress in N/mm2, smallest radius of the rolls in mm."""

    density: Positive
    E: Positive
    yield_stress: Positive
    rolls_radius: NonNegative = 0.0
    glass: bool = False


class StockSheet(Table):
    """A sheet size; `quantity` absent means as many as needed."""

    name: str = ""
    material: str
    thickness: Positive | None = None
    length: Positive
    width: Positive
    quantity: Count | None = None
    cost: Positive | None = None


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
    layers: dict[str, str] = {}


class Limits(Table):
    """Limits of the verdicts; one that is absent is reported without verdict."""

    deviation_max_mm: Positive | None = None
    deviation_over_sag_limit: Positive | None = 1.2
    twist_max_deg: Positive | None = 0.02
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


MATERIALS: dict[str, dict[str, float | bool]] = {
    # E and yield stress: EN 1993-1-1 table 3.1 (S355), EN 485-2 (5754-H22), EN 12150 glass.
    "steel": {"density": 7850.0, "E": 210000.0, "yield_stress": 355.0, "rolls_radius": 150.0},
    "aluminium": {"density": 2660.0, "E": 70000.0, "yield_stress": 130.0, "rolls_radius": 100.0},
    "glass": {"density": 2500.0, "E": 70000.0, "yield_stress": 23.3, "glass": True},
    "wood": {"density": 520.0, "E": 11000.0, "yield_stress": 24.0},
}

STOCK: list[dict[str, Any]] = [
    {"material": "aluminium", "length": 2500.0, "width": 1250.0},
    {"material": "aluminium", "length": 3000.0, "width": 1500.0},
    {"material": "aluminium", "length": 4000.0, "width": 2000.0},
    {"material": "steel", "length": 6000.0, "width": 2000.0},
    {"material": "steel", "length": 12000.0, "width": 2500.0},
    {"material": "glass", "length": 6000.0, "width": 3210.0},
    {"material": "wood", "length": 2500.0, "width": 1250.0},
]


class Project(Table):
    """A whole project file."""

    name: str = Field(default="facade", min_length=1, max_length=80)
    surface: Surface
    strips: Strips = Strips()
    panels: Panels | None = None
    cells: Cells | None = None
    beams: Beams | None = None
    crossed: Crossed | None = None
    connectors: Connectors | None = None
    nesting: Nesting | None = None
    cutting: Cutting = Cutting()
    limits: Limits = Limits()
    materials: dict[str, Material] = {}
    stock: list[StockSheet] = []
    drawings: bool = True
    ifc: bool = False

    @field_validator("name")
    @classmethod
    def _plain_name(cls, name: str) -> str:
        if not re.fullmatch(r"[\w .,()+-]+", name) or name.strip(" .") != name:
            raise ValueError("use letters, digits, spaces and . , ( ) + - only")
        return name

    @field_validator("materials", mode="before")
    @classmethod
    def _known_materials(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        return {k: {**MATERIALS[k], **v} if k in MATERIALS else v for k, v in given.items()}

    @model_validator(mode="after")
    def _belongs_together(self) -> Project:
        for path, material in _materials_used(self):
            if not re.fullmatch(r"[\w.-]+", material) or material.strip(".") != material:
                raise ValueError(f"{path}: material {material!r} may hold letters, digits, _ . -")
            if material not in self.materials and material not in MATERIALS:
                known = sorted({*self.materials, *MATERIALS})
                raise ValueError(f"{path}: unknown material {material!r}{_mean(material, known)}")
        if self.crossed and not self.beams:
            raise ValueError("[crossed] runs across [beams]: both are needed")
        if self.crossed and self.crossed.layout == "mesh":
            raise ValueError('crossed.layout: the second model\'s beams are "curved"')
        if self.connectors and not (self.panels and self.beams):
            raise ValueError("[connectors] join [panels] to [beams]: both are needed")
        if self.strips.start == "model" and self.strips.model is None:
            raise ValueError('strips.start = "model" needs strips.model, a path to strips.json')
        return self

    def material(self, name: str) -> Material:
        """The material of that name, the project's own before the known ones."""
        return self.materials.get(name) or Material.model_validate(MATERIALS[name])

    def stock_for(self, material: str, thickness: float) -> list[StockSheet]:
        """Sheets of a material and thickness: the project's, else common sizes."""
        given = [s for s in self.stock if s.material == material]
        fitting = [s for s in given if s.thickness in (None, thickness)]
        if given:
            return fitting
        return [StockSheet.model_validate(s) for s in STOCK if s["material"] == material]


def _materials_used(project: Project) -> list[tuple[str, str]]:
    used = [(f"materials.{name}", name) for name in project.materials]
    used += [(f"stock[{k}]", sheet.material) for k, sheet in enumerate(project.stock)]
    for name in ("panels", "cells", "beams", "crossed"):
        table = getattr(project, name)
        if table is not None:
            used.append((name, table.material))
    if project.panels:
        used += [(f"panels.materials.{k}", name) for k, name in project.panels.materials.items()]
        used += [(f"panels.layers[{k}]", x.material) for k, x in enumerate(project.panels.layers)]
    return used


def read_project(path: Path | str) -> Project:
    """Read and check a project file.

    Raises
    ------
    InputError
        If the file is missing, is no TOML, or holds unknown keys or wrong values; all of them are
        named together, unknown keys with the nearest known one.
    """
    path = Path(path)
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(str(path), "no such file", "check the path, or run: fabgeo init") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), f"cannot be read as UTF-8 text: {error}") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(str(path), f"is not valid TOML: {error}", "mend that line") from None
    return parse_project(data, str(path))


def parse_project(data: dict[str, Any], where: str = "project") -> Project:
    """Check project data that is already parsed; see `read_project`."""
    try:
        return Project.model_validate(data)
    except ValidationError as error:
        lines = [_line(item) for item in error.errors()]
        raise InputError(where, "; ".join(lines), "mend the keys named") from None


def _line(item: Any) -> str:
    path = ".".join(str(part) for part in item["loc"])
    if item["type"] == "extra_forbidden":
        keys = _keys_at(item["loc"][:-1])
        return f"unknown key {path}{_mean(str(item['loc'][-1]), keys)}"
    if item["type"] == "missing":
        return f"[{path}] is missing" if "." not in path else f"{path} is missing"
    message = str(item["msg"]).removeprefix("Value error, ")
    found = "" if isinstance(item["input"], dict | list) else f", found {item['input']!r}"
    return (f"{path}: " if path else "") + message + found


def _keys_at(location: tuple[int | str, ...]) -> list[str]:
    table: Any = Project
    for part in location:
        if isinstance(part, int) or not hasattr(table, "model_fields"):
            continue
        field = table.model_fields.get(part)
        table = _table_in(field.annotation) if field else table
    return list(table.model_fields) if hasattr(table, "model_fields") else []


def _table_in(annotation: Any) -> Any:
    if isinstance(annotation, type) and issubclass(annotation, Table):
        return annotation
    inner = [_table_in(a) for a in getattr(annotation, "__args__", ())]
    return next((table for table in inner if table is not None), None)


def _mean(word: str, known: list[str]) -> str:
    close = difflib.get_close_matches(word, known, 1, 0.6)
    return f", did you mean {close[0]!r}?" if close else f", expected one of {', '.join(known)}"
