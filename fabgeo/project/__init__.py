"""The project file: what `fabgeo build` is asked for, checked to the last key.

Every table is optional but [surface]; a stage whose table is absent is not asked for.
"""

from fabgeo.project.reading import parse_project, read_project
from fabgeo.project.stock import Material, StockSheet
from fabgeo.project.tables import (
    Beams,
    Cells,
    Connectors,
    Crossed,
    Cutting,
    Layer,
    Limits,
    Nesting,
    Panels,
    Strips,
    Surface,
)
from fabgeo.project.whole import Project

__all__ = [
    "Beams",
    "Cells",
    "Connectors",
    "Crossed",
    "Cutting",
    "Layer",
    "Limits",
    "Material",
    "Nesting",
    "Panels",
    "Project",
    "StockSheet",
    "Strips",
    "Surface",
    "parse_project",
    "read_project",
]
