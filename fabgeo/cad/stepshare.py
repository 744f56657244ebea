"""A STEP file divided among processes: each share has some solids, with the products they are of.

The kernel reads a file in one thread, and takes longer for each solid the more there are beside it
(measured: 4,200 solids in 36 shares take two thirds of the time that they take in two). In a share
the products of the others are left out with all that only they refer to; names, places, colours
and layers of its own stay as they are. Source: ISO 10303-21, ISO 10303-44 (product structure).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Self

import numpy as np

from fabgeo.arrays import IntArray
from fabgeo.cad.stepgraph import Mask, StepGraph

SHARE = 4_000_000  # bytes: a share's reading takes a second

_OTHERS = (b"/*", b"BREP_WITH_VOIDS", b"FACETED_BREP", b"SHELL_BASED_SURFACE_MODEL")
_LISTS = (
    "PRESENTATION_LAYER_ASSIGNMENT",
    "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION",
    "PRODUCT_RELATED_PRODUCT_CATEGORY",
)
_END = re.compile(rb"ENDSEC;\s*END-ISO-10303-21;")


def step_shares(path: Path, size: int = SHARE) -> Iterator[bytes]:
    """The texts of shares of about `size` bytes, those of the file's last solids first.

    The last are fixings, in one share with thousands of places: begun last, it would be waited for.

    The file itself, once, where it is no larger or can't be divided: shapes that are no plain
    solids, solids of no product, comments, statements that don't begin lines.
    """
    text = path.read_bytes()
    end = text.rfind(b"ENDSEC;")
    if len(text) <= size or not _END.match(text, max(end, 0)) or any(w in text for w in _OTHERS):
        yield text
        return
    tree = _Tree.of(StepGraph.of(text[:end]))
    if tree is None:
        yield text
        return
    for own in tree.divided(size):
        yield b"".join((*tree.share(own), text[end:]))


@dataclass(frozen=True)
class _Tree:
    """The products of a text, by places of its graph.

    Attributes
    ----------
    graph : StepGraph
    solids, shape, product : (s,) arrays
        The solids, the representation that holds each, the product definition that it belongs to.
    uses : (n, 2) array
        Product definitions, each with one that is placed in it.
    definitions, products : (d,) arrays
        All product definitions, and their products.
    lists : (l,) array
        Statements that are shorter without one of their references, and not left out.
    """

    graph: StepGraph
    solids: IntArray
    shape: IntArray
    product: IntArray
    uses: IntArray
    definitions: IntArray
    products: IntArray
    lists: IntArray

    @classmethod
    def of(cls, graph: StepGraph) -> Self | None:
        """The products of a graph; None unless it has solids, and each belongs to just one."""
        solids = graph.of_kind("MANIFOLD_SOLID_BREP")
        defined = graph.pairs(graph.of_kind("SHAPE_DEFINITION_REPRESENTATION"))
        uses = graph.pairs(graph.of_kind("NEXT_ASSEMBLY_USAGE_OCCURRENCE"))
        owner = graph.leading(defined[:, 0])
        row, target = graph.references(defined[:, 1])
        row, target = row[np.isin(target, solids)], target[np.isin(target, solids)]
        order = np.argsort(target)
        if not len(solids) or not np.array_equal(target[order], solids) or (owner < 0).any():
            return None
        definitions = np.unique(np.concatenate([owner, uses.ravel()]))
        return cls(
            graph,
            solids,
            defined[row[order], 1],
            owner[row[order]],
            uses,
            definitions,
            graph.leading(graph.leading(definitions)),
            np.concatenate([graph.of_kind(kind) for kind in _LISTS]),
        )

    def divided(self, size: int) -> Iterator[Mask]:
        """Solids (s,) of each share of about `size` bytes; those of one shape stay together."""
        at = self.graph.begin[self.solids]
        whole = int(self.graph.begin[-1] - at[0])
        count = max(1, round(whole / size))
        _, shape = np.unique(self.shape, return_inverse=True)
        share = np.full(len(at), count)
        np.minimum.at(share, shape, (at - at[0]) * count // whole)
        for k in np.unique(share[shape])[::-1]:
            yield share[shape] == k

    @cached_property
    def upper(self) -> IntArray:
        """Statements (c,) that depend on a solid or a product: what differs between shares."""
        made = self.products[self.products >= 0]
        return self.graph.depend_on(np.concatenate([self.solids, self.definitions, made]))

    @cached_property
    def index(self) -> IntArray:
        """Index in `upper` of each statement (k + 1,), -1 for the others (and for place -1)."""
        out = np.full(len(self.graph.numbers) + 1, -1)
        out[self.upper] = np.arange(len(self.upper))
        return out

    @cached_property
    def edges(self) -> tuple[IntArray, IntArray]:
        """References among `upper`, from and to."""
        row, target = self.graph.references(self.upper)
        to = self.index[target]
        return row[to >= 0], to[to >= 0]

    @cached_property
    def needs(self) -> IntArray:
        """Without how many of its references a statement (c,) is left out: of a list, all."""
        out = np.ones(len(self.upper), dtype=int)
        lists = self.index[self.lists]
        lists = lists[lists >= 0]
        out[lists] = np.bincount(self.edges[0], minlength=len(out))[lists]
        return out

    def share(self, own: Mask) -> Iterator[bytes]:
        """The text of some solids (s,), but for its end."""
        graph, (source, target) = self.graph, self.edges
        out = self._left_out(own)
        shorter = np.zeros_like(out)
        shorter[source[out[target]]] = True
        shorter &= ~out
        seen = np.zeros(len(graph.numbers), dtype=bool)
        seen[self.upper[out]] = True
        cut = graph.numbers[self.upper[target[out[target] & shorter[source]]]]
        places = graph.reached(graph.roots[~seen[graph.roots]], seen)
        return graph.pieces(places, self.upper[shorter], set(cut.tolist()))

    def _left_out(self, own: Mask) -> Mask:
        """Which of `upper` only others than these solids (s,) need."""
        kept = np.zeros(len(self.upper) + 1, dtype=bool)
        kept[self.index[self.product[own]]] = True
        parent, child = self.index[self.uses].T
        new = kept[child] & ~kept[parent]
        while new.any():
            kept[parent[new]] = True
            new = kept[child] & ~kept[parent]
        others = ~kept[self.index[self.definitions]]
        made = np.setdiff1d(self.products[others], self.products[~others])
        out = np.zeros(len(self.upper) + 1, dtype=bool)
        for some in (self.solids[~own], self.definitions[others], made):
            out[self.index[some]] = True
        out, (source, target) = out[:-1], self.edges
        while True:
            less = np.bincount(source[out[target]], minlength=len(out)) >= self.needs
            if not (less & ~out).any():
                return out
            out |= less
