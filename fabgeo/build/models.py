"""STEP files and the glb file of a package, made piece by piece, side by side, and found again.

The kernel translates a few parts at a time, in other processes where the build has them; each
piece goes into the file of its family and into that of the facade (`fabgeo.cad.stepjoin`). A
file is taken over from the package before where none of its parts changed.

Glossary
--------
piece
    Parts of one family that are translated together.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import chain, groupby
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.build.built import Built
from fabgeo.build.cache import Cache
from fabgeo.build.folder import Folder
from fabgeo.build.geometry import Design
from fabgeo.build.identity import shape_of
from fabgeo.build.parallel import Work, keep, results
from fabgeo.build.products import made_of, nodes_of, products
from fabgeo.build.solids import Leaf, assemblies, leaves_of, mesh_of, solid_node
from fabgeo.cad.assembly import Node
from fabgeo.errors import GeometryError, InputError
from fabgeo.structures.parts import Connector

FACADE = "facade"
PARTS = 48  # in a piece; a beam stays whole


@dataclass(frozen=True)
class _Piece:
    """Parts of a family with their solids, or all connectors with their products."""

    family: str
    leaves: tuple[tuple[Leaf, Built], ...] = ()
    connectors: tuple[Connector, ...] = ()
    products: Callable[[], dict[str, Node]] | None = None
    made_of: Any = None

    @property
    def depends(self) -> Any:
        """What its file depends on."""
        shown = [
            (leaf.beam, b.mark, b.identity, leaf.colour, leaf.layer) for leaf, b in self.leaves
        ]
        return self.family, shown, self.connectors, self.made_of

    def node(self) -> Node:
        """Its tree, with an assembly of the family as root."""
        if self.products is not None:
            from fabgeo.cad.connectors import place_connectors

            placed = place_connectors(self.connectors, self.products())
            return Node(self.family, children=tuple(placed))
        (root,) = assemblies((leaf, solid_node(leaf, built)) for leaf, built in self.leaves)
        return root


def write_models(
    folder: Folder,
    design: Design,
    built: Mapping[str, Built],
    jobs: int | None = None,
    cache: Cache | None = None,
) -> None:
    """Write model/facade.step, a STEP file a family where there are several, and the glb file."""
    store = cache or Cache()
    leaves = list(leaves_of(design, built))
    pieces = [*_pieces(leaves, built), *_fixings(design)]
    if not pieces:
        return
    _write_steps(folder, design.project.name, pieces, jobs, store)
    key = store.key("glb", design.project.name, [piece.depends for piece in pieces])
    if folder.again(f"model/{FACADE}.glb", key):
        keep(_MESHES, leaves, store)
    else:
        _write_glb(folder.place(f"model/{FACADE}.glb"), design, leaves, jobs, store)


def _pieces(leaves: Iterable[Leaf], built: Mapping[str, Built]) -> Iterator[_Piece]:
    for family, members in groupby(leaves, lambda leaf: leaf.family):
        piece: list[tuple[Leaf, Built]] = []
        for _, plates in groupby(members, lambda leaf: leaf.beam or leaf.part.mark):
            if len(piece) >= PARTS:
                yield _Piece(family, tuple(piece))
                piece = []
            piece += [(leaf, built[leaf.part.mark]) for leaf in plates]
        yield _Piece(family, tuple(piece))


def _fixings(design: Design) -> Iterator[_Piece]:
    """All connectors in one piece: equal ones are placed instances of one product."""
    if not design.connectors:
        return
    asked = design.project
    if asked.panels is None or asked.beams is None:
        raise InputError("[connectors]", "join [panels] to [beams]: both are needed")
    make = partial(products, (design.products, asked.panels.thickness, asked.beams.flange))
    if any(fixing.maker is not None for fixing in design.products.values()):
        make = partial(dict, make())  # a user's function may not cross to another process
    yield _Piece("connectors", (), tuple(design.connectors), make, made_of(design))


def _write_steps(
    folder: Folder, name: str, pieces: list[_Piece], jobs: int | None, store: Cache
) -> None:
    """The files of all families and of each, unless all are as they were."""
    from fabgeo.cad.stepjoin import StepJoin

    families = list(dict.fromkeys(piece.family for piece in pieces))
    files = [f"model/{file}.step" for file in (FACADE, *(families if len(families) > 1 else ()))]
    key = store.key("model", name, [piece.depends for piece in pieces])
    taken = [folder.again(file, key) for file in files]
    if all(taken):
        return keep(_STEPS, pieces, store)
    whole, *each = (folder.place(file) for file in files)
    fixings = [piece for piece in pieces if piece.products is not None]  # one that takes long
    others = [piece for piece in pieces if piece.products is None]
    made = results(_STEPS, [*fixings, *others], jobs, store)
    first = [(piece, next(made)) for piece in fixings]
    with StepJoin(whole, name, dict(zip(families, each, strict=False))) as joined:
        for piece, data in chain(zip(others, made, strict=True), first):
            joined.add(piece.family, zlib.decompress(data))


def _translated(piece: _Piece) -> bytes:
    from fabgeo.cad.step import step_bytes

    return zlib.compress(step_bytes(piece.node()), 1)


def _crashed(piece: _Piece, reason: str) -> bytes:
    marks = ", ".join(built.mark for _, built in piece.leaves[:3])
    raise GeometryError(f"model/{FACADE}.step", f"{piece.family} from {marks}: {reason}")


def _write_glb(
    path: Path, design: Design, leaves: list[Leaf], jobs: int | None, store: Cache
) -> None:
    from fabgeo.cad.glb import write_glb

    meshes = results(_MESHES, leaves, jobs, store)
    nodes = (
        (leaf, Node(leaf.part.mark, mesh=mesh, colour=leaf.colour, layer=leaf.layer))
        for leaf, mesh in zip(leaves, meshes, strict=True)
    )
    groups = assemblies(nodes)
    connectors = nodes_of(design)
    if connectors:
        groups.append(Node("connectors", children=tuple(connectors)))
    write_glb(path, Node(design.project.name, children=tuple(groups)))


def _meshed(leaf: Leaf) -> Any:
    points, triangles = mesh_of(leaf.part)
    return points.astype(np.float32), triangles.astype(np.uint32)  # as the file holds them


def _no_mesh(leaf: Leaf, reason: str) -> Any:
    raise GeometryError(leaf.part.mark, f"no picture of it: {reason}")


_STEPS = Work("step", _translated, lambda piece: piece.depends, _crashed)
_MESHES = Work("mesh", _meshed, lambda leaf: shape_of(leaf.part), _no_mesh)
