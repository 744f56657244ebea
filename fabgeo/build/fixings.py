"""Point fixings between panels and beams: the same holes in flat parts, plates and products."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Mapping

from fabgeo.build.geometry import Design
from fabgeo.cad.assembly import Node
from fabgeo.cad.connectors import fixing_products, place_connectors
from fabgeo.cad.fasteners import metric
from fabgeo.cad.measure import volume
from fabgeo.errors import InputError
from fabgeo.project import Project
from fabgeo.structures.clashes import clashes
from fabgeo.structures.connectors import Fixing, Fixings, LocalHole, connect
from fabgeo.structures.parts import Beam, Plate

BASE_BOLT = 8.0  # M8 base bolts in slots of the flange
STEEL = 7.85e-6  # kg/mm3


def fixing_of(project: Project) -> Fixing:
    """The parameters of the project's point fixing."""
    asked = project.connectors
    if asked is None:
        raise InputError("[connectors]", "are not asked for")
    rod = float(asked.bolt.removeprefix("M"))
    base = _base(asked.base_length, asked.base_width)
    hole = metric(BASE_BOLT).clearance
    pitch = _pitch(base)
    return Fixing(
        spacing=asked.spacing,
        end_distance=asked.end_distance,
        edge_distance=asked.edge_distance,
        stand_off=asked.standoff,
        reach=asked.reach,
        rod=rod,
        base_bolt=BASE_BOLT,
        base_pitch=pitch,
        base_length=base[0],
        base_width=base[1],
        base_thickness=base[2],
        disc_diameter=asked.disc,
        disc_thickness=5.0,
        panel_holes=(LocalHole(diameter=metric(rod).clearance, slot=asked.slot),),
        flange_holes=tuple(
            LocalHole(x, 0.0, hole, 10.0, math.pi / 2.0) for x in (-pitch / 2.0, pitch / 2.0)
        ),
    )


def _base(length: float, width: float) -> tuple[float, float, float]:
    return (length, width, 6.0)


def _pitch(base: tuple[float, float, float]) -> float:
    return base[0] - 36.0


def fixings_of(project: Project, panels: tuple[Plate, ...], beams: tuple[Beam, ...]) -> Fixings:
    """Fixings placed along both edges of every panel, plates drilled."""
    return connect(panels, beams, fixing_of(project))


def complaints_of(found: Fixings) -> dict[str, tuple[str, str]]:
    """Panel mark to verdict and reason: places without fixing (warn), clashes (fail)."""
    out: dict[str, tuple[str, str]] = {}
    for place, reason in found.refused.items():
        panel = place.split(",")[0]
        out.setdefault(panel, ("warn", f"no fixing at {place.split(', ', 1)[1]}: it {reason}"))
    panels = {connector.mark: connector.panel for connector in found.connectors}
    for clash in clashes(found.connectors, found.products, found.panels, found.beams):
        panel = panels.get(clash.first, clash.first)
        what = f"{clash.first} and {clash.second}: {clash.reason} by {clash.depth:.1f} mm"
        out[panel] = ("fail", what)
    return out


def nodes_of(design: Design) -> list[Node]:
    """Every connector as a placed instance of its product."""
    return place_connectors(design.connectors, products_of(design))


def products_of(design: Design) -> dict[str, Node]:
    """The products by key; equal stand-offs are one product."""
    project = design.project
    if not design.connectors or project.panels is None or project.beams is None:
        return {}
    return fixing_products(
        design.products,
        panel=project.panels.thickness,
        flange=project.beams.flange,
        library=importlib.util.find_spec("bd_warehouse") is not None,
    )


def masses_of(products: Mapping[str, Node]) -> dict[str, float]:
    """Mass of each product in kg, all of steel."""
    return {key: STEEL * _volume(node) for key, node in products.items()}


def _volume(node: Node) -> float:
    product = node.instance_of or node
    own = volume(product.shape)[0] if product.shape is not None else 0.0
    return own + sum(_volume(child) for child in product.children)
