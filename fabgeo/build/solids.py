"""The fifth stage: exact solids of all parts, measured, as one tree of named products."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from fabgeo.build.built import Built
from fabgeo.build.cache import Cache
from fabgeo.build.fixings import nodes_of
from fabgeo.build.geometry import Design
from fabgeo.build.parallel import Work, results
from fabgeo.build.progress import Clock
from fabgeo.cad import kernel
from fabgeo.cad.assembly import CLASS_COLOURS, FAMILY_COLOURS, Colour, Node
from fabgeo.cad.measure import check_solid
from fabgeo.cad.mesh import prism_mesh
from fabgeo.cad.solids import prism_solid
from fabgeo.errors import FabgeoError
from fabgeo.structures.holes import bored_volume
from fabgeo.structures.parts import Cell, Plate
from fabgeo.structures.prisms import plate_prism, prism_properties

__all__ = ["Built", "solids_of", "tree_of"]

type Part = Plate | Cell

FAMILIES = ("panels", "layers", "cells", "walls", "beams", "connectors")


def solids_of(
    parts: Sequence[Part],
    jobs: int | None = None,
    clock: Clock | None = None,
    cache: Cache | None = None,
) -> dict[str, Built]:
    """Solids of plates and cells by mark, each checked; a part that fails is reported."""
    clock, store = clock or Clock(), cache or Cache()
    work = Work("solid", _built, _shape_of, _crashed)
    out = {}
    for part, built in zip(parts, clock.each(results(work, parts, jobs, store)), strict=True):
        file = store.file(work.kind, store.key(work.kind, _shape_of(part)))
        out[built.mark] = replace(built, data=b"", file=file) if built.made and file else built
    return out


def _shape_of(part: Part) -> Any:
    """What a solid depends on; not what it is made of."""
    if isinstance(part, Cell):
        return part.mark, part.prism
    return part.mark, part.mid, part.thickness, part.holes, part.bevel


def _crashed(part: Part, reason: str) -> Built:
    return Built(part.mark, failure=f"{part.mark}: no solid: {reason}")


def _built(part: Part) -> Built:
    try:
        prism = part.prism if isinstance(part, Cell) else plate_prism(part)
        holes = () if isinstance(part, Cell) else part.holes
        shape = prism_solid(prism, holes=holes)
        # Adaptive integration over trimmed skins is slow: 1e-3 asked for gives 1e-9 there.
        report = check_solid(shape, 1e-3) if holes else check_solid(shape)
        expected = prism_properties(prism).volume - bored_volume(prism, holes)
        error = abs(report.volume - expected) / expected
        return Built(part.mark, kernel.to_bytes(shape), report, error)
    except FabgeoError as error:
        return Built(part.mark, failure=str(error))


def tree_of(
    design: Design,
    built: dict[str, Built],
    meshes: bool = False,
    products: Mapping[str, Node] | None = None,
) -> Node:
    """The assembly of the package: panels, cells, walls, beams, connectors (handover.md).

    With `meshes` plates and cells are triangles from their formulas in place of solids.
    `products` are the connectors' (`fabgeo.build.fixings.products_of`), where they are made.
    """
    node = _meshed if meshes else _solid
    groups = (
        Node("panels", children=tuple(_panels(design, built, node))),
        Node("layers", children=tuple(_parts(design.layers, built, node, "panels"))),
        Node("cells", children=tuple(_parts(design.cells, built, node, "cells"))),
        Node("walls", children=tuple(_parts(design.walls, built, node, "walls"))),
        Node("beams", children=tuple(_beams(design, built, node))),
        Node("connectors", children=tuple(nodes_of(design, products))),
    )
    return Node(design.project.name, children=tuple(g for g in groups if g.children))


type _Maker = Callable[[Part, Built, Colour, str], Node]


def _panels(design: Design, built: dict[str, Built], node: _Maker) -> Iterator[Node]:
    for plate in design.panels:
        if plate.mark in built and built[plate.mark].made:
            colour = CLASS_COLOURS[design.choices[plate.mark].cls]
            yield node(plate, built[plate.mark], colour, "panels")


def _parts(
    parts: Sequence[Part], built: dict[str, Built], node: _Maker, family: str
) -> Iterator[Node]:
    for part in parts:
        if part.mark in built and built[part.mark].made:
            yield node(part, built[part.mark], FAMILY_COLOURS[family], family)


def _beams(design: Design, built: dict[str, Built], node: _Maker) -> Iterator[Node]:
    for beam in design.beams:
        children = tuple(_parts(beam.plates, built, node, "beams"))
        if children:
            yield Node(beam.mark, children=children)


def _solid(part: Part, built: Built, colour: Colour, layer: str) -> Node:
    return Node(part.mark, built.shape(), colour=colour, layer=layer)


def _meshed(part: Part, built: Built, colour: Colour, layer: str) -> Node:
    if isinstance(part, Cell):
        mesh = prism_mesh(part.prism)
    else:
        mesh = prism_mesh(plate_prism(part), holes=part.holes)
    return Node(built.mark, mesh=mesh, colour=colour, layer=layer)
