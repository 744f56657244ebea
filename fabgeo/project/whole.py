"""A whole project: all its tables, and what has to go together in them."""

from __future__ import annotations

import re
from typing import Any

from pydantic import Field, ValidationError, field_validator, model_validator

from fabgeo.arrays import checked_number, shown
from fabgeo.errors import InputError
from fabgeo.project.spelling import mean
from fabgeo.project.stock import MATERIALS, STOCK, Material, StockSheet
from fabgeo.project.tables import (
    Beams,
    Cells,
    Connectors,
    Crossed,
    Cutting,
    Limits,
    Nesting,
    Panels,
    Strips,
    Surface,
    Table,
)
from fabgeo.project.telling import told


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
    materials: dict[str, Material] = Field(default_factory=dict)
    stock: list[StockSheet] = Field(default_factory=list)
    drawings: bool = True
    ifc: bool = False

    def __init__(self, /, **data: Any) -> None:
        try:
            super().__init__(**data)
        except ValidationError as error:
            problem = told(error, type(self), data)
            raise InputError("project", problem, "mend the keys named") from None

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
        return {
            k: {**MATERIALS[k], **v} if k in MATERIALS and isinstance(v, dict) else v
            for k, v in given.items()
        }

    @model_validator(mode="after")
    def _belongs_together(self) -> Project:
        for path, material in _materials_used(self):
            if not re.fullmatch(r"[\w.-]+", material) or material.strip(".") != material:
                raise ValueError(f"{path}: material {material!r} may hold letters, digits, _ . -")
            if material not in self.materials and material not in MATERIALS:
                known = sorted({*self.materials, *MATERIALS})
                raise ValueError(f"{path}: unknown material {material!r}{mean(material, known)}")
        if self.crossed and not self.beams:
            raise ValueError("[crossed] runs across [beams]: both are needed")
        if self.crossed and self.crossed.layout == "mesh":
            raise ValueError('crossed.layout: the second model\'s beams are "curved"')
        if self.connectors and not (self.panels and self.beams):
            raise ValueError("[connectors] join [panels] to [beams]: both are needed")
        self._refuse_parts()
        if self.strips.start == "model" and self.strips.model is None:
            raise ValueError('strips.start = "model" needs strips.model, a path to strips.json')
        return self

    def _refuse_parts(self) -> None:
        """Several models side by side carry panels alone: no edge goes on from one to the next."""
        if self.strips.parts is None:
            return
        for name in ("cells", "beams"):
            if getattr(self, name) is not None:
                raise ValueError(
                    f"strips.parts: several models carry [panels] alone; leave [{name}] out, or "
                    "build one model, without strips.parts"
                )

    def material(self, name: str) -> Material:
        """The material of that name, the project's own before the known ones."""
        known = sorted({*self.materials, *MATERIALS})
        if not isinstance(name, str) or name not in known:
            more = mean(name, known) if isinstance(name, str) else ""
            raise InputError("project", f"unknown material {shown(name)}{more}")
        return self.materials.get(name) or Material.model_validate(MATERIALS[name])

    def stock_for(self, material: str, thickness: float) -> list[StockSheet]:
        """Sheets of a material and thickness: the project's, else common sizes."""
        self.material(material)
        checked_number("thickness", thickness, above=0.0)
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
