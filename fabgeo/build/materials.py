"""What each panel is made of, and how it gets its shape in that material.

Shapes do not depend on the material: they are chosen first and kept when a material changes.
"""

from __future__ import annotations

import difflib
from dataclasses import replace

from fabgeo.build.geometry import Design
from fabgeo.build.skin import sheet_of
from fabgeo.errors import InputError
from fabgeo.panels.forming import forming_of


def in_materials(design: Design) -> Design:
    """The design with every panel in its material, and its forming route in it.

    Raises
    ------
    InputError
        If [panels.materials] names a panel that is not there.
    """
    asked = design.project.panels
    if asked is None:
        return design
    marks = [plate.mark for plate in design.panels]
    _refuse_strangers(asked.materials, marks)
    own = {mark: asked.materials.get(mark, asked.material) for mark in marks}
    sheets = {material: sheet_of(design.project, material) for material in set(own.values())}
    choices = {}
    for mark, choice in design.choices.items():
        sheet = sheets[own.get(mark, asked.material)]
        forming, note = forming_of(choice.cls, choice.radius_min_mm, sheet)
        reason = "; ".join(filter(None, [choice.reason, note]))
        choices[mark] = replace(choice, forming=forming, reason=reason)
    panels = tuple(replace(plate, material=own[plate.mark]) for plate in design.panels)
    return replace(design, panels=panels, choices=choices)


def _refuse_strangers(asked: dict[str, str], marks: list[str]) -> None:
    for mark in asked:
        if mark not in marks:
            near = difflib.get_close_matches(mark, marks, 1, 0.6)
            hint = f", did you mean {near[0]!r}?" if near else ""
            raise InputError("panels.materials", f"there is no panel {mark!r}{hint}")
