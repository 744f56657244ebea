"""Hexagon bolts, washers and nuts: plain exact ones, or those of bd_warehouse.

Sources: ISO 4017 (hexagon head screws), ISO 4032 (nuts), ISO 7089 (washers), ISO 273 (clearance
holes, medium). Threads are drawn as plain shanks of the nominal diameter.
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from OCP.TopoDS import TopoDS_Shape, TopoDS_Solid

from fabgeo.cad import kernel
from fabgeo.cad.primitives import cut, cylinder, fuse, hexagon, tube
from fabgeo.errors import InputError, MissingExtraError


@dataclass(frozen=True)
class Metric:
    """Dimensions of one thread size in mm."""

    size: float
    flats: float
    head: float
    nut: float
    washer: tuple[float, float, float]
    """Outer diameter, inner diameter, thickness."""
    clearance: float
    pitch: float


METRIC = {
    m.size: m
    for m in (
        Metric(6, 10, 4.0, 5.2, (12, 6.4, 1.6), 6.6, 1.0),
        Metric(8, 13, 5.3, 6.8, (16, 8.4, 1.6), 9.0, 1.25),
        Metric(10, 16, 6.4, 8.4, (20, 10.5, 2.0), 11.0, 1.5),
        Metric(12, 18, 7.5, 10.8, (24, 13.0, 2.5), 13.5, 1.75),
        Metric(16, 24, 10.0, 14.8, (30, 17.0, 3.0), 17.5, 2.0),
        Metric(20, 30, 12.5, 18.0, (37, 21.0, 3.0), 22.0, 2.5),
    )
}


def metric(size: float) -> Metric:
    """The dimensions of M`size`.

    Raises
    ------
    InputError
        If the size is not in the table.
    """
    try:
        return METRIC[float(size)]
    except KeyError:
        sizes = ", ".join(f"M{s:g}" for s in METRIC)
        raise InputError(f"bolt M{size:g}", f"expected one of {sizes}") from None


def bolt(size: float, length: float) -> TopoDS_Solid:
    """Hexagon head screw: shank from z = 0 down to -length, head on top."""
    m = metric(size)
    return fuse([cylinder(m.size, -length, 0.0), hexagon(m.flats, 0.0, m.head)], f"bolt M{size:g}")


def nut(size: float) -> TopoDS_Solid:
    """Hexagon nut from z = 0 up to its height; its bore is the nominal diameter."""
    m = metric(size)
    return cut(
        hexagon(m.flats, 0.0, m.nut), [cylinder(m.size, -1.0, m.nut + 1.0)], f"nut M{size:g}"
    )


def washer(size: float) -> TopoDS_Solid:
    """Washer from z = 0 up to its thickness."""
    outer, inner, thickness = metric(size).washer
    return tube(outer, inner, 0.0, thickness)


@lru_cache(maxsize=64)
def from_library(kind: str, size: float, length: float = 0.0) -> TopoDS_Shape:
    """A bolt, nut or washer of bd_warehouse (simple: no thread), placed like the plain ones.

    Raises
    ------
    MissingExtraError
        Without the extra ``fasteners``.
    """
    try:
        from bd_warehouse import fastener
    except ImportError as error:
        raise MissingExtraError("fasteners", "fasteners") from error
    m = metric(size)
    thread = f"M{m.size:g}-{m.pitch:g}"
    if kind == "bolt":
        made = fastener.HexHeadScrew(thread, length, "iso4017", simple=True)
    elif kind == "nut":
        made = fastener.HexNut(thread, "iso4032", simple=True)
    else:
        made = fastener.PlainWasher(f"M{m.size:g}", "iso7089")
    solids = kernel.solids(made.wrapped)
    return solids[0] if len(solids) == 1 else made.wrapped
