"""The product tree of a STEP text: names, placements, and which solids a product holds.

Glossary
--------
occurrence
    A product in its place in its parent, under the name of the usage (NAUO) or its own.
representation
    What holds a product's shape; others may be equated to it by a relationship.

Source: ISO 10303-44 (product structure), -43 (representations).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from fabgeo.arrays import Array
from fabgeo.cad.part21 import Entities
from fabgeo.cad.textcurves import frame_of
from fabgeo.errors import InputError


@dataclass(frozen=True)
class Occurrence:
    """One node of the tree.

    Attributes
    ----------
    name : str
        The occurrence's name; the product's where it has none.
    product : str
    path : tuple of str
        Names from the root to here.
    matrix : (4, 4) array
        From the product's coordinates to the root's.
    solids : tuple of int
        Numbers of the product's own MANIFOLD_SOLID_BREPs.
    children : tuple of Occurrence
    """

    name: str
    product: str
    path: tuple[str, ...]
    matrix: Array
    solids: tuple[int, ...]
    children: tuple[Occurrence, ...] = field(default=())

    def leaves(self) -> Iterator[Occurrence]:
        """All occurrences that hold solids, depth first."""
        if self.solids:
            yield self
        for child in self.children:
            yield from child.leaves()


def product_tree(file: Entities) -> Occurrence:
    """The tree of a file.

    Raises
    ------
    InputError
        If the file has no product, or more than one that nothing uses.
    """
    tree = _Tree(file)
    used = {child for uses in tree.uses.values() for _, child in uses}
    roots = [d for d in file.of_kind("PRODUCT_DEFINITION") if d not in used]
    if len(roots) != 1:
        raise InputError(file.where, f"holds {len(roots)} root products, expected one")
    return tree.occurrence(roots[0], "", (), np.eye(4))


class _Tree:
    def __init__(self, file: Entities) -> None:
        self.file = file
        self.uses: dict[int, list[tuple[int, int]]] = {}  # parent: (usage, child)
        for usage in file.of_kind("NEXT_ASSEMBLY_USAGE_OCCURRENCE"):
            _, _, _, parent, child, *_ = file.arguments(usage)
            self.uses.setdefault(parent, []).append((int(usage), int(child)))
        self.shapes: dict[int, int] = {}  # definition: representation
        for number in file.of_kind("SHAPE_DEFINITION_REPRESENTATION"):
            shape, representation = file.arguments(number)[:2]
            self.shapes[file.arguments(shape)[2]] = representation
        self.equal: dict[int, list[int]] = {}
        for number in file.of_kind("SHAPE_REPRESENTATION_RELATIONSHIP"):
            parts = file.parts(number)
            if len(parts) == 1:
                first, second = file.arguments(number)[2:4]
                self.equal.setdefault(first, []).append(second)
                self.equal.setdefault(second, []).append(first)
        self.places = self._places()

    def occurrence(
        self, definition: int, name: str, above: tuple[str, ...], matrix: Array
    ) -> Occurrence:
        product = self._name(definition)
        path = (*above, name or product)
        children = tuple(
            self.occurrence(
                child,
                self.file.arguments(usage)[1] or "",
                path,
                matrix @ self.places.get(usage, np.eye(4)),
            )
            for usage, child in self.uses.get(definition, [])
        )
        solids = tuple(self._solids(definition))
        return Occurrence(name or product, product, path, matrix, solids, children)

    def _name(self, definition: int) -> str:
        formation = self.file.arguments(definition)[2]
        product = self.file.arguments(self.file.arguments(formation)[2])
        return product[1] or product[0]

    def _solids(self, definition: int) -> Iterator[int]:
        start = self.shapes.get(definition)
        if start is None:
            return
        seen, queue = {start}, [start]
        while queue:
            at = queue.pop()
            for item in self.file.arguments(at)[1]:
                if self.file.kind(item) == "MANIFOLD_SOLID_BREP":
                    yield int(item)
            for other in self.equal.get(at, []):
                if other not in seen:
                    seen.add(other)
                    queue.append(other)

    def _places(self) -> dict[int, Array]:
        """Placement of every usage: child's coordinates to its parent's."""
        file, out = self.file, {}
        for number in file.of_kind("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION"):
            relation, shape = file.arguments(number)
            usage = int(file.arguments(shape)[2])
            parts = file.parts(relation)
            first, _ = parts["REPRESENTATION_RELATIONSHIP"][2:4]
            transform = parts["REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION"][0]
            a, b = (frame_of(file, n) for n in file.arguments(transform)[2:4])
            parent = file.arguments(usage)[3]
            if first == self.shapes.get(parent):
                a, b = b, a
            out[usage] = b @ np.linalg.inv(a)
        return out
