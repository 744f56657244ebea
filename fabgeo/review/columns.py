"""The schedules' columns: names fixed by the hand-over contract, units and number formats.

Glossary
--------
column
    (name, unit, decimals): decimals None for text, 0 for counts.
"""

from __future__ import annotations

from typing import NamedTuple


class Column(NamedTuple):
    """One column: its name in the CSV, the unit shown to people, decimals (None: text)."""

    name: str
    unit: str = ""
    decimals: int | None = None


def _columns(text: str) -> tuple[Column, ...]:
    """Columns from words: ``name:decimals``; the unit is read off the name's last part."""
    units = {"mm": "mm", "deg": "°", "m2": "m²", "m3": "m³", "m": "m", "kg": "kg"}
    result = []
    for word in text.split():
        name, _, decimals = word.partition(":")
        unit = units.get(name.rsplit("_", 1)[-1], "") if "_" in name else ""
        result.append(Column(name, unit, int(decimals) if decimals else None))
    return tuple(result)


PANELS = _columns(
    "mark strip:0 cell:0 class radius_min_mm:1 radius_max_mm:1 half_angle_deg:3 axis_or_apex "
    "fit_deviation_mm:4 surface_deviation_mm:3 kink_max_deg:4 kink_added_deg:4 "
    "kink_edge gap_max_mm:4 gap_edge flange_mm:4 twist_max_deg:5 developability_mm:5 "
    "material thickness_mm:2 flat_length_mm:2 flat_width_mm:2 area_m2:6 mass_kg:3 "
    "cog_x_mm:1 cog_y_mm:1 cog_z_mm:1 holes:0 connectors:0 sheet sheet_rotation_deg:3 "
    "forming verdict reason box_length_mm:1 box_width_mm:1 box_height_mm:1 "
    "transport erection_order:0 plank_sag_mm:3 plank_yield:4 edge_congruence_mm:4 "
    "slit_max_mm:1 slit_edges"
)
PLATES = _columns(
    "mark parent role length_mm:2 width_mm:2 thickness_mm:2 area_m2:6 mass_kg:3 material "
    "radius_min_mm:1 radius_max_mm:1 camber_mm:2 sheet sheet_rotation_deg:3 holes:0 "
    "verdict reason cog_x_mm:1 cog_y_mm:1 cog_z_mm:1 bevel_start_mm:2 bevel_end_mm:2"
)
BEAMS = _columns(
    "mark edge:0 length_mm:2 depth_min_mm:2 depth_max_mm:2 plates:0 mass_kg:3 "
    "cog_x_mm:1 cog_y_mm:1 cog_z_mm:1 box_length_mm:1 box_width_mm:1 box_height_mm:1 transport "
    "erection_order:0 verdict reason groove_deg:1 weld_gap_mm:2"
)
CELLS = _columns(
    "mark strip:0 cell:0 volume_m3:6 cog_x_mm:1 cog_y_mm:1 cog_z_mm:1 "
    "box_length_mm:1 box_width_mm:1 box_height_mm:1 transport erection_order:0 verdict reason"
)
CONNECTORS = _columns(
    "mark product panel beam x_mm:3 y_mm:3 z_mm:3 axis_x:6 axis_y:6 axis_z:6 mass_kg:3"
)
SHEETS = _columns(
    "sheet material thickness_mm:2 stock length_mm:1 width_mm:1 parts:0 marks utilisation:4 "
    "cut_length_mm:0 pierces:0 parts_mass_kg:2 sheet_mass_kg:2 file"
)
BOM = _columns("item material thickness_mm:2 count:0 area_m2:4 mass_kg:2 note")
SETOUT = _columns("point x:4 y:4 z:4 nx:8 ny:8 nz:8 role mark")

TABLES: dict[str, tuple[Column, ...]] = {
    "panels": PANELS,
    "plates": PLATES,
    "beams": BEAMS,
    "cells": CELLS,
    "connectors": CONNECTORS,
    "sheets": SHEETS,
    "bom": BOM,
}
