"""Structures of two layers (paper section 3, Fig. 7), as far as the project asks for them.

``[beams] layout = "mesh"``: straight beams on the quad mesh of the panels' corners, to which the
strips are attached at shared nodes. ``[crossed]``: the beams of a second strip model, whose smooth
direction runs across that of the first.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from fabgeo.build.geometry import Design, beam_rule, section_of
from fabgeo.build.model import outwards
from fabgeo.fitting.store import load_model
from fabgeo.strips.axes import axes
from fabgeo.strips.model import StripModel
from fabgeo.structures.beams import beams
from fabgeo.structures.crossed import crossing
from fabgeo.structures.mixed import attach, mesh_beams
from fabgeo.structures.parts import Beam
from fabgeo.surfaces.units import unit_of


def straightened(design: Design) -> Design:
    """The design with straight beams on the quad mesh of the panels' corners.

    Raises
    ------
    GeometryError
        If the model admits no beams, or a bay's web is not plane.
    """
    asked, model = design.project.beams, design.lanes
    if asked is None or asked.layout != "mesh":
        return design
    u = np.unique(np.round([x for patch in design.patches for x in (patch.u0, patch.u1)], 12))
    if design.project.panels is None:
        u = np.arange(model.segments + 1.0)  # the model's own spans
    found = attach(model, u)
    made = mesh_beams(found, axes(model)(u), section_of(asked), asked.edges)
    edge, at = found.gap_at
    remark = (
        f"beams on a quad mesh: {found.gap_max:.2f} mm between mesh and strips at most (edge "
        f"{edge}, u = {at:.2f}), {found.gap_rms:.2f} mm rms; mesh faces {found.planarity:.2g} mm "
        f"off plane; nodes shared within {found.node_error:.1g} mm"
    )
    return replace(design, beams=tuple(made), remarks=(*design.remarks, remark))


def crossed_by(design: Design, base: Path) -> Design:
    """The design with the beams of the second model, their edges numbered on from the first's.

    Parameters
    ----------
    base : Path
        Folder that the second model's path is relative to.

    Raises
    ------
    InputError, GeometryError
        If the second model can't be read, admits no beams, or does not run across the first.
    """
    asked = design.project.crossed
    if asked is None:
        return design
    inner, first = second_model(base / asked.model), design.lanes.edges
    found = crossing(design.lanes, inner)
    own = beams(inner, section_of(asked), beam_rule(design.project, asked), asked.edges)
    remark = (
        f"two crossed models: edges meet at {found.angle_min_deg:.1f} degrees or more, "
        f"{found.gap_min:.1f} to {found.gap_max:.1f} mm apart; beams of the second: B-{first:02d} "
        "and on"
    )
    made = (*design.beams, *(renumbered(beam, first) for beam in own))
    return replace(design, beams=made, remarks=(*design.remarks, remark))


def second_model(path: Path) -> StripModel:
    """A strip model of a ``strips.json`` in millimetres, turned outwards."""
    model = load_model(path)
    size = float(np.ptp(model.control.reshape(-1, 3), axis=0).max())
    unit = unit_of(str(path), size, str(model.info["unit"]))
    return outwards(model.with_control(model.control * unit.scale))


def renumbered(beam: Beam, first: int) -> Beam:
    """The beam under the number of its edge counted on from `first`."""
    _, _, number = beam.mark.split("-")
    edge = beam.edge + first
    mark = f"B-{edge:02d}-{number}"
    plates = [
        replace(plate, mark=mark + plate.mark.removeprefix(beam.mark), parent=mark)
        for plate in beam.plates
    ]
    return replace(beam, mark=mark, edge=edge, plates=tuple(plates))
