"""Point fixings between panels and beams: the same holes in flat parts, plates and products."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from functools import partial
from typing import Any

from fabgeo.build.cache import Cache
from fabgeo.build.identity import shape_of
from fabgeo.build.parallel import Work, results
from fabgeo.cad.fasteners import metric
from fabgeo.errors import InputError, PartError
from fabgeo.project import Project
from fabgeo.structures.beams import with_holes
from fabgeo.structures.clashes import Clash, between_fixings, with_plates
from fabgeo.structures.connectors import connect
from fabgeo.structures.fixing import Fixing, LocalHole
from fabgeo.structures.parts import Beam, Connector, Hole, Plate

BASE_BOLT = 8.0  # M8 base bolts in slots of the flange


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


def fixings_of(
    project: Project,
    panels: Sequence[Plate],
    beams: Sequence[Beam],
    jobs: int | None = None,
    cache: Cache | None = None,
    own: Fixing | None = None,
) -> dict[str, Any]:
    """Fixings along both edges of every panel, strip by strip: what a `Design` takes of them.

    `own` is the user's fixing in place of the project's. Panels and beams are drilled; complaints
    name, by panel mark, places without fixing (warn) and clashes (fail).
    """
    fixing = own or fixing_of(project)
    rows: dict[int, list[Plate]] = defaultdict(list)
    for panel in panels:
        rows[int(panel.mark.split("-")[1])].append(panel)
    last = max((beam.edge for beam in beams), default=0)
    work = Work("fixings", partial(_fixed, fixing=fixing), partial(_shapes, fixing), _crashed)
    strips = []
    for strip, row in sorted(rows.items()):
        edges = {strip, strip + 1, last} | ({0} if strip == last else set())
        strips.append((strip, row, [beam for beam in beams if beam.edge in edges]))
    found = list(results(work, strips, jobs, cache))
    connectors = [connector for one in found for connector in one["connectors"]]
    real = {k: high for one in found for k, high in one["products"].items()}
    products = {key: replace(fixing, stand_off=high) for key, high in real.items()}
    holes: dict[str, list[Hole]] = defaultdict(list)
    for one in found:
        for mark, bored in one["holes"].items():
            holes[mark] += bored
    clashes = [Clash(*each) for one in found for each in one["clashes"]]
    return {
        "connectors": tuple(connectors),
        "products": products,
        "panels": tuple(_drilled(panel, holes) for panel in panels),
        "beams": tuple(with_holes(b, [_drilled(p, holes) for p in b.plates]) for b in beams),
        "complaints": _complaints(
            [line for one in found for line in one["refused"].items()],
            between_fixings(connectors, products, panels) + clashes,
            connectors,
        ),
    }


type _Row = tuple[int, list[Plate], list[Beam]]


def _fixed(row: _Row, fixing: Fixing) -> dict[str, Any]:
    """One strip's fixings and their holes, as plain data."""
    _, panels, beams = row
    made = connect(panels, beams, fixing)
    plates = [*made.panels, *(plate for beam in made.beams for plate in beam.plates)]
    known = {p.mark: len(p.holes) for p in (*panels, *(p for b in beams for p in b.plates))}
    found = with_plates(made.connectors, made.products, made.panels, made.beams)
    return {
        "connectors": made.connectors,
        "products": {key: product.stand_off for key, product in made.products.items()},
        "holes": {p.mark: p.holes[known[p.mark] :] for p in plates if len(p.holes) > known[p.mark]},
        "refused": dict(made.refused),
        "clashes": [(c.first, c.second, c.reason, c.depth) for c in found],
    }


def _shapes(fixing: Fixing, row: _Row) -> Any:
    """What the fixings of a strip depend on; not what its parts are made of."""
    _, panels, beams = row
    plates = [*panels, *(plate for beam in beams for plate in beam.plates)]
    own = {f.name: getattr(fixing, f.name) for f in fields(fixing)}
    places = [(beam.mark, beam.edge) for beam in beams]
    return repr(own), places, [shape_of(plate) for plate in plates]


def _crashed(row: _Row, reason: str) -> dict[str, Any]:
    raise PartError(f"strip {row[0]}", f"could not get its fixings: {reason}", "please report it")


def _drilled(plate: Plate, holes: Mapping[str, Sequence[Hole]]) -> Plate:
    own = holes.get(plate.mark, ())
    return replace(plate, holes=(*plate.holes, *own)) if own else plate


def _complaints(
    refused: Sequence[tuple[str, str]], clashes: Sequence[Clash], connectors: Sequence[Connector]
) -> dict[str, tuple[str, str]]:
    """Panel mark to verdict and reason: places without fixing (warn), clashes (fail)."""
    out: dict[str, tuple[str, str]] = {}
    for place, reason in refused:
        panel = place.split(",")[0]
        out.setdefault(panel, ("warn", f"no fixing at {place.split(', ', 1)[1]}: it {reason}"))
    panels = {connector.mark: connector.panel for connector in connectors}
    for clash in clashes:
        panel = panels.get(clash.first, clash.first)
        what = f"{clash.first} and {clash.second}: {clash.reason} by {clash.depth:.1f} mm"
        out[panel] = ("fail", what)
    return out
