"""The skin: panels with their neighbours, the shapes they are made as, further layers.

Glossary
--------
gross panel
    A panel up to the edge curves: what classes, gaps and kinks are measured on.
net panel
    The same with its joints taken off, on the shape that it is made as: what is cut.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from fabgeo.build.fitted import Fitted
from fabgeo.errors import GeometryError
from fabgeo.panels.classify import PanelChoice, classify, distinct_radii
from fabgeo.panels.forming import Sheet
from fabgeo.panels.limits import Costs, Tolerances
from fabgeo.panels.remeasured import measured_again
from fabgeo.panels.samples import PanelInput, Side
from fabgeo.project import Project
from fabgeo.strips.model import Patch
from fabgeo.structures import panels as layers
from fabgeo.structures.beams import plate_radii
from fabgeo.structures.parts import Plate

SPRINGING = Sheet(young=1e-9)  # springs to any radius: shapes are chosen before materials


def panels_of(
    project: Project,
    models: Sequence[Fitted],
    patches: Sequence[Patch],
    jobs: int | None = None,
) -> tuple[tuple[Plate, ...], dict[str, PanelChoice], str, dict[str, float]]:
    """Net panels on the shapes that they are made as, why, and what choosing them together saves.

    The saving in words, and as figures. See `fabgeo.build.materials` for how they are formed;
    `jobs` processes help to choose.
    """
    asked = project.panels
    if asked is None:
        return (), {}, "", {}
    layer = layers.Layer("panel", asked.offset, asked.thickness, asked.material)
    net = plates_of(models, patches, layer, asked.joint)
    inputs = inputs_of(project, models, patches)
    tolerances = limits_of(project)
    costs = Costs(**asked.costs)
    if asked.choice != "single":
        from fabgeo.panels.choose import choose

        few, step = asked.radii, asked.radii_step
        joint = choose(
            inputs,
            tolerances,
            costs,
            SPRINGING,
            radii=few,
            radii_step=step,
            jobs=jobs,
            thorough=asked.choice == "thorough",
        )
        choices, saved, figures = list(joint.panels), f"panels: {joint}", joint.figures
    else:
        choices, saved = classify(inputs, tolerances, costs, SPRINGING), ""
        figures = {}
    shapes = [choice.shape for choice in choices]
    made = _on_shapes(net, choices, costs, asked.joint / 2.0)
    if any(choice.shape is not shape for choice, shape in zip(choices, shapes, strict=True)):
        choices = measured_again(choices, inputs)  # neighbours meet fitted panels there
    figures["panels_cost"] = sum(choice.cost for choice in choices)
    figures["panels_radii"] = float(distinct_radii(choices))
    return tuple(made), {choice.mark: choice for choice in choices}, saved, figures


def _on_shapes(
    net: Sequence[Plate], choices: list[PanelChoice], costs: Costs, half: float
) -> list[Plate]:
    """Net panels on the shapes chosen; where one can't be cut on its shape it stays as fitted.

    `half` is what joints take off each of their two panels, mm.
    """
    made = []
    for k, (plate, choice) in enumerate(zip(net, choices, strict=True)):
        first, last = (half if side in plate.shared else 0.0 for side in ("start", "end"))
        try:
            made.append(replace(plate, mid=choice.on_shape(plate.mid, (first, last))))
        except GeometryError as error:
            choices[k] = choice.as_fitted(f"{choice.cls}: {error.problem}", costs.developable)
            made.append(plate)
        if choices[k].cls == "developable":  # of the panel as cut, seen more densely than to choose
            least, largest = plate_radii(made[k].mid)
            choices[k] = replace(choices[k], radius_min_mm=least, radius_max_mm=largest)
    return made


def plates_of(
    models: Sequence[Fitted],
    patches: Sequence[Patch],
    layer: layers.Layer,
    joint: float = 0.0,
    suffix: str = "",
) -> list[Plate]:
    """Panels of one layer on all models, one a patch, in the order of the patches."""
    out: list[Plate] = []
    for own in models:
        on_it = [patches[k] for k in own.own(patches)]
        taken = layers.Joint(joint, joint, seams=own.seams)
        out += layers.panels(own.lanes, on_it, layer, taken, suffix=suffix, first=own.first)
    return out


def inputs_of(
    project: Project, models: Sequence[Fitted], patches: Sequence[Patch]
) -> list[PanelInput]:
    """Gross panels with their neighbours: what classes are chosen on."""
    asked = project.panels
    if asked is None:
        return []
    layer = layers.Layer("panel", asked.offset, asked.thickness, asked.material)
    gross = plates_of(models, patches, layer)
    return [PanelInput(p.mark, p.mid, _sides(p.shared)) for p in gross]


def limits_of(project: Project) -> Tolerances:
    """What the panels' replacement may deviate by."""
    asked = project.panels
    if asked is None:
        return Tolerances()
    ends = asked.ends
    if ends is None and project.cells and project.cells.walls and asked.joint > 0.0:
        ends = asked.joint  # a joint stays above its wall
    own = {} if ends is None else {"ends_mm": ends}
    return Tolerances(asked.tolerance, asked.angle, project.limits.gap_max_mm, **own)


def _sides(shared: Mapping[str, str]) -> dict[Side, str | tuple[str, ...]]:
    sides: tuple[Side, ...] = ("first", "second", "start", "end")
    return {side: shared[side] for side in sides if side in shared}


def sheet_of(project: Project, material: str | None = None) -> Sheet:
    """What forming needs to know of a material, by default the panels'."""
    asked = project.panels
    if asked is None:
        return Sheet()
    known = project.material(material or asked.material)
    return Sheet(
        thickness=asked.thickness,
        young=known.E,
        strength=known.yield_stress,
        rolls=known.rolls_radius,
        glass=known.glass,
    )


def layers_of(
    project: Project, models: Sequence[Fitted], patches: Sequence[Patch]
) -> tuple[Plate, ...]:
    """Panels of the further layers, marks with the layer's name behind."""
    if project.panels is None:
        return ()
    return tuple(
        plate
        for asked in project.panels.layers
        for plate in plates_of(
            models,
            patches,
            layers.Layer(asked.name, asked.distance, asked.thickness, asked.material),
            project.panels.joint,
            suffix=f"-{asked.name.upper()}",
        )
    )
