"""Materials and the sheets they are bought in: the project's own, else those known here."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from fabgeo.project.tables import Count, NonNegative, Positive, Table


class Material(Table):
    """Density in kg/m3, E and yield stress in N/mm2, smallest radius of the rolls in mm."""

    density: Positive
    E: Positive
    yield_stress: Positive
    rolls_radius: NonNegative = 0.0
    glass: bool = False


class StockSheet(Table):
    """A sheet size; `quantity` absent means as many as needed."""

    name: Annotated[str, Field(pattern=r"^[^\x00-\x1f]{0,80}$")] = ""
    material: str
    thickness: Positive | None = None
    length: Positive
    width: Positive
    quantity: Count | None = None
    cost: Positive | None = None


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
