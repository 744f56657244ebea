"""The fifth stage: exact solids of all parts, measured, as one tree of named products."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

from fabgeo.arrays import Array, IntArray
from fabgeo.build.arguments import checked_jobs, checked_parts
from fabgeo.build.built import Built
from fabgeo.build.cache import Cache
from fabgeo.build.geometry import Design
from fabgeo.build.identity import shape_of
from fabgeo.build.parallel import Work, results
from fabgeo.build.products import nodes_of
from fabgeo.build.progress import Clock
from fabgeo.cad import kernel
from fabgeo.cad.assembly import CLASS_COLOURS, FAMILY_COLOURS, Colour, Node
from fabgeo.cad.measure import check_solid, volume
from fabgeo.cad.mesh import prism_mesh
from fabgeo.cad.solids import prism_solid
from fabgeo.errors import FabgeoError
from fabgeo.structures.holes import bored_volume
from fabgeo.structures.parts import Cell, Plate
from fabgeo.structures.prisms import plate_prism, prism_properties

__all__ = ["Built", "solids_of", "tree_of"]

type Part = Plate | Cell

SURE = 1e-8  # of a volume: beyond it the integral is repeated to the kernel's best
FAMILIES = ("panels", "layers", "cells", "walls", "beams", "connectors")


def solids_of(
    parts: Sequence[Part],
    jobs: int | None = None,
    clock: Clock | None = None,
    cache: Cache | None = None,
) -> dict[str, Built]:
    """Solids of plates and cells by mark, each checked; a part that fails is reported.

    Raises
    ------
    InputError
        Naming the argument that is something else.
    """
    parts, jobs = checked_parts("parts", parts, (Plate, Cell)), checked_jobs(jobs)
    clock, store = clock or Clock(), cache or Cache()
    work = Work("solid", _built, shape_of, _crashed)
    out = {}
    for part, built in zip(parts, clock.each(results(work, parts, jobs, store)), strict=True):
        file = store.file(work.kind, store.key(work.kind, shape_of(part)))
        out[built.mark] = replace(built, data=b"", file=file) if built.made and file else built
    return out


def _crashed(part: Part, reason: str) -> Built:
    return Built(part.mark, failure=f"{part.mark}: no solid: {reason}")


def _built(part: Part) -> Built:
    try:
        prism = part.prism if isinstance(part, Cell) else plate_prism(part)
        holes = () if isinstance(part, Cell) else part.holes
        shape = prism_solid(prism, holes=holes)
        # Adaptive integration takes long; 1e-3 asked for gives 1e-9, as the formula shows.
        report = check_solid(shape, 1e-3)
        expected = prism_properties(prism).volume - bored_volume(prism, holes)
        error = abs(report.volume - expected) / expected
        if error > SURE:
            total, centre = volume(shape)
            report = replace(report, volume=total, centre=centre)
            error = abs(total - expected) / expected
        return Built(part.mark, kernel.to_bytes(shape), report, error)
    except FabgeoError as error:
        return Built(part.mark, failure=str(error))


@dataclass(frozen=True)
class Leaf:
    """A part as it stands in the product tree: in its family, in a beam perhaps ("" if not)."""

    family: str
    beam: str
    part: Part
    colour: Colour
    layer: str


def leaves_of(design: Design, built: Mapping[str, Built]) -> Iterator[Leaf]:
    """Plates and cells that have a solid, family by family (handover.md)."""
    for plate in design.panels:
        yield from _made(
            Leaf("panels", "", plate, CLASS_COLOURS[design.choices[plate.mark].cls], "panels"),
            built,
        )
    groups: tuple[tuple[str, Sequence[Part], str], ...] = (
        ("layers", design.layers, "panels"),
        ("cells", design.cells, "cells"),
        ("walls", design.walls, "walls"),
    )
    for family, parts, layer in groups:
        for part in parts:
            yield from _made(Leaf(family, "", part, FAMILY_COLOURS[layer], layer), built)
    for beam in design.beams:
        for plate in beam.plates:
            leaf = Leaf("beams", beam.mark, plate, FAMILY_COLOURS["beams"], "beams")
            yield from _made(leaf, built)


def _made(leaf: Leaf, built: Mapping[str, Built]) -> Iterator[Leaf]:
    if leaf.part.mark in built and built[leaf.part.mark].made:
        yield leaf


def assemblies(leaves: Iterable[tuple[Leaf, Node]]) -> list[Node]:
    """One assembly a family, beams as assemblies of their own, from leaves with their nodes."""
    out = []
    for family, members in groupby(leaves, lambda pair: pair[0].family):
        children: list[Node] = []
        for beam, plates in groupby(members, lambda pair: pair[0].beam):
            nodes = [node for _, node in plates]
            children += [Node(beam, children=tuple(nodes))] if beam else nodes
        out.append(Node(family, children=tuple(children)))
    return out


def tree_of(design: Design, built: Mapping[str, Built]) -> Node:
    """The product tree of the package: panels, cells, walls, beams, connectors (handover.md)."""
    groups = assemblies(
        (leaf, solid_node(leaf, built[leaf.part.mark])) for leaf in leaves_of(design, built)
    )
    connectors = nodes_of(design)
    if connectors:
        groups.append(Node("connectors", children=tuple(connectors)))
    return Node(design.project.name, children=tuple(groups))


def solid_node(leaf: Leaf, built: Built) -> Node:
    """The part with its exact solid."""
    return Node(built.mark, built.shape(), colour=leaf.colour, layer=leaf.layer)


def mesh_of(part: Part) -> tuple[Array, IntArray]:
    """Triangles of a part from its formula: vertices and corners."""
    if isinstance(part, Cell):
        return prism_mesh(part.prism)
    return prism_mesh(plate_prism(part), holes=part.holes)
