"""The tree of a product: named, coloured, layered nodes, with shapes that may be shared.

Glossary
--------
product
    A node that is placed many times: one geometry, one name, many instances.
instance
    A placed occurrence of a product, under a name of its own (its mark).
"""

# The kernel's binding ships no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from OCP.TopoDS import TopoDS_Shape

from fabgeo.arrays import Array, IntArray, set_frozen
from fabgeo.cad import kernel
from fabgeo.errors import InputError

type Colour = tuple[float, float, float]
"""Red, green, blue of sRGB in [0, 1]."""

FAMILY_COLOURS: dict[str, Colour] = {
    "panels": (0.72, 0.78, 0.84),
    "cells": (0.87, 0.80, 0.62),
    "beams": (0.36, 0.40, 0.46),
    "walls": (0.58, 0.55, 0.50),
    "connectors": (0.83, 0.45, 0.18),
}
CLASS_COLOURS: dict[str, Colour] = {
    "flat": (0.85, 0.88, 0.90),
    "cylinder": (0.36, 0.62, 0.80),
    "cone": (0.40, 0.72, 0.52),
    "developable": (0.93, 0.68, 0.30),
}


@dataclass(frozen=True, eq=False)
class Node:
    """One node of the tree: a part, an assembly of nodes, or a placed instance of a product.

    Attributes
    ----------
    name : str
        Any text; a part's mark.
    shape : TopoDS_Shape, optional
        The geometry of a part.
    children : tuple of Node
        The parts of an assembly.
    instance_of : Node, optional
        The product that is placed here; the same object in every instance.
    colour : (3,) tuple, optional
        sRGB in [0, 1].
    layer : str
        Name of the layer; "" for none.
    location : (4, 4) array, optional
        Rigid placement in the parent, in mm.
    mesh : (vertices (n, 3), triangles (m, 3)), optional
        Of a part, for viewing: beside its shape or, where nothing else is wanted, in its place.
    """

    name: str
    shape: TopoDS_Shape | None = None
    children: tuple[Node, ...] = ()
    instance_of: Node | None = None
    colour: Colour | None = None
    layer: str = ""
    location: Array | None = None
    mesh: tuple[Array, IntArray] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "children", tuple(self.children))
        if self.location is not None:
            set_frozen(self, "location", (4, 4))
        part = self.shape is not None or self.mesh is not None
        kinds = part + bool(self.children) + (self.instance_of is not None)
        if not self.name or kinds > 1:
            raise InputError(
                f"node {self.name!r}",
                "expected a name and at most one of shape (or mesh), children and instance_of",
            )
        if self.shape is not None and self.shape.IsNull():
            raise InputError(f"node {self.name!r}", "its shape is empty")

    def __getstate__(self) -> dict[str, Any]:
        """Shapes go to other processes as the kernel's bytes; shared nodes stay shared."""
        shape = None if self.shape is None else kernel.to_bytes(self.shape)
        return {**self.__dict__, "shape": shape}

    def __setstate__(self, state: dict[str, Any]) -> None:
        shape = None if state["shape"] is None else kernel.from_bytes(state["shape"])
        self.__dict__.update(state, shape=shape)

    def parts(self) -> Iterator[Node]:
        """All nodes that carry geometry: parts and instances, depth first."""
        if any(x is not None for x in (self.shape, self.mesh, self.instance_of)):
            yield self
        for child in self.children:
            yield from child.parts()
