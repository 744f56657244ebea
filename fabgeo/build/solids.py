"""The fifth stage: exact solids of all parts, measured, as one tree of named products."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from joblib import Parallel, delayed

from fabgeo.build.fixings import nodes_of
from fabgeo.build.geometry import Design
from fabgeo.build.progress import Clock
from fabgeo.cad import kernel
from fabgeo.cad.assembly import CLASS_COLOURS, FAMILY_COLOURS, Node
from fabgeo.cad.measure import SolidReport, check_solid
from fabgeo.cad.plates import plate_solid
from fabgeo.cad.solids import prism_solid
from fabgeo.errors import FabgeoError
from fabgeo.structures.parts import Cell, Plate
from fabgeo.structures.prisms import plate_prism, prism_properties

type Part = Plate | Cell


@dataclass(frozen=True)
class Built:
    """One solid as measured, or why there is none.

    Attributes
    ----------
    mark : str
    data : bytes
        The shape as the kernel's bytes; empty if it failed.
    report : SolidReport or None
    volume_error : float or None
        Relative difference of the solid's volume and the integral by formula (without holes).
    failure : str
    """

    mark: str
    data: bytes = b""
    report: SolidReport | None = None
    volume_error: float | None = None
    failure: str = ""


def solids_of(parts: Sequence[Part], jobs: int = 1, clock: Clock | None = None) -> dict[str, Built]:
    """Solids of plates and cells by mark, each checked; a part that fails is reported."""
    clock = clock or Clock()
    work = (delayed(_built)(part) for part in parts)
    made = Parallel(n_jobs=jobs, return_as="generator", batch_size=16)(work)
    return {built.mark: built for built in clock.each(made) if built is not None}


def _built(part: Part) -> Built:
    try:
        prism = part.prism if isinstance(part, Cell) else plate_prism(part)
        holes = () if isinstance(part, Cell) else part.holes
        shape = prism_solid(prism) if isinstance(part, Cell) else plate_solid(part)
        report = check_solid(shape)
        expected = prism_properties(prism).volume
        error = None if holes else abs(report.volume - expected) / expected
        return Built(part.mark, kernel.to_bytes(shape), report, error)
    except FabgeoError as error:
        return Built(part.mark, failure=str(error))


def tree_of(design: Design, built: dict[str, Built]) -> Node:
    """The assembly of the package: panels, cells, walls, beams, connectors (handover.md)."""
    groups = (
        Node("panels", children=tuple(_panels(design, built))),
        Node("layers", children=tuple(_parts(design.layers, built, "panels"))),
        Node("cells", children=tuple(_parts(design.cells, built, "cells"))),
        Node("walls", children=tuple(_parts(design.walls, built, "walls"))),
        Node("beams", children=tuple(_beams(design, built))),
        Node("connectors", children=tuple(nodes_of(design))),
    )
    return Node(design.project.name, children=tuple(g for g in groups if g.children))


def _panels(design: Design, built: dict[str, Built]) -> Iterator[Node]:
    for plate in design.panels:
        colour = CLASS_COLOURS[design.choices[plate.mark].cls]
        yield from _part(plate.mark, built, colour, "panels")


def _parts(parts: Sequence[Part], built: dict[str, Built], family: str) -> Iterator[Node]:
    for part in parts:
        yield from _part(part.mark, built, FAMILY_COLOURS[family], family)


def _beams(design: Design, built: dict[str, Built]) -> Iterator[Node]:
    for beam in design.beams:
        children = tuple(_parts(beam.plates, built, "beams"))
        if children:
            yield Node(beam.mark, children=children)


def _part(
    mark: str, built: dict[str, Built], colour: tuple[float, float, float], layer: str
) -> Iterator[Node]:
    found = built.get(mark)
    if found is not None and found.data:
        yield Node(mark, kernel.from_bytes(found.data), colour=colour, layer=layer)
