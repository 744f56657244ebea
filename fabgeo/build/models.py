"""STEP files and the glb file of a package, each by itself: at work side by side, found again.

A file is taken over from the package before where none of its parts changed. Where others work
on parts, they also write: the facade in one process, its families in the others.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed

from fabgeo.build.built import Built
from fabgeo.build.cache import Cache
from fabgeo.build.fixings import products_of
from fabgeo.build.folder import Folder
from fabgeo.build.geometry import Design
from fabgeo.build.solids import FAMILIES, tree_of
from fabgeo.cad.assembly import Node
from fabgeo.errors import InputError

FACADE = "facade"


@dataclass(frozen=True)
class _File:
    """One file to be written: the parts of its family, or of all."""

    path: Path
    design: Design
    built: dict[str, Built]
    family: str
    products: Mapping[str, Node]


def write_models(
    folder: Folder,
    design: Design,
    built: Mapping[str, Built],
    jobs: int | None = None,
    cache: Cache | None = None,
) -> None:
    """Write model/facade.step, a STEP file a family where there are several, and the glb file."""
    bare = _bare(design)
    families = [family for family in FAMILIES if any(_marks(bare, built, family))]
    if not families:
        return
    names = [f"{FACADE}.step", *(f"{f}.step" for f in families if len(families) > 1)]
    files = []
    for name in (*names, f"{FACADE}.glb"):
        family = name.split(".")[0]
        key = _key(cache or Cache(), bare, built, family)
        if folder.again(f"model/{name}", key):
            continue
        part, own = _part(bare, built, family)
        products = products_of(part)  # made once, in this process
        files.append(_File(folder.place(f"model/{name}"), part, own, family, products))
    Parallel(n_jobs=jobs, max_nbytes=None)(delayed(_write)(file) for file in files)


def _write(file: _File) -> None:
    from fabgeo.cad.glb import write_glb
    from fabgeo.cad.step import write_step

    tree = tree_of(
        file.design, file.built, meshes=file.path.suffix == ".glb", products=file.products
    )
    if file.family != FACADE:
        (tree,) = tree.children
    if file.path.suffix == ".glb":
        write_glb(file.path, tree)
    else:
        write_step(file.path, tree)


def _bare(design: Design) -> Design:
    """What trees are made of, without surface and fit: it goes to other processes."""
    nothing: Any = None
    return replace(
        design, surface=nothing, start=nothing, fit=nothing, model=nothing, pair=None, trims=None
    )


def _part(bare: Design, built: Mapping[str, Built], family: str) -> tuple[Design, dict[str, Built]]:
    """The design and its solids with one family left."""
    if family == FACADE:
        return bare, dict(built)
    gone: dict[str, Any] = {name: () for name in FAMILIES if name != family}
    marks = set(_marks(bare, built, family))
    return replace(bare, **gone), {m: made for m, made in built.items() if m in marks}


def _marks(bare: Design, built: Mapping[str, Built], family: str) -> Iterator[str]:
    """Marks of a family's parts that have a shape."""
    if family == "connectors":
        yield from (connector.mark for connector in bare.connectors)
        return
    parts: Any = getattr(bare, family)
    if family == "beams":
        parts = [plate for beam in bare.beams for plate in beam.plates]
    yield from (part.mark for part in parts if part.mark in built and built[part.mark].made)


def _key(cache: Cache, bare: Design, built: Mapping[str, Built], family: str) -> str:
    """Digest of what the file of a family holds."""
    shown = FAMILIES if family == FACADE else (family,)
    shapes = [
        (mark, built[mark].identity if mark in built else "")
        for one in shown
        for mark in _marks(bare, built, one)
    ]
    classes = [bare.choices[p.mark].cls for p in bare.panels] if "panels" in shown else []
    fixings: Any = None
    if "connectors" in shown and bare.connectors:
        asked = bare.project
        if asked.panels is None or asked.beams is None:
            raise InputError("[connectors]", "join [panels] to [beams]: both are needed")
        products = [
            repr([getattr(product, f.name) for f in fields(product)])
            for product in bare.products.values()
        ]
        fixings = (products, bare.connectors, asked.panels.thickness, asked.beams.flange)
    beams = [beam.mark for beam in bare.beams] if "beams" in shown else []
    return cache.key("model", bare.project.name, shapes, classes, beams, fixings)
