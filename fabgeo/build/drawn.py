"""DXF files of parts and of nested sheets: drawn side by side, those that did not change kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from fabgeo.build.cache import Cache
from fabgeo.build.folder import Folder
from fabgeo.build.identity import identity
from fabgeo.panels.flat import FlatPart
from fabgeo.project import Project
from fabgeo.sheets.dxf import Drawn, DxfStyle, write_nests, write_parts
from fabgeo.sheets.stock import Nest

SUFFIXES = (".dxf", ".svg")


def write_flats(
    folder: Folder,
    project: Project,
    flats: Mapping[str, FlatPart],
    nests: list[Nest],
    jobs: int | None = None,
    cache: Cache | None = None,
) -> None:
    """Write cut/parts/<mark>.dxf of all parts and cut/nests of all sheets."""
    asked, store = project.cutting, cache or Cache()
    style = DxfStyle(
        version=asked.version, outline=asked.curves, tolerance=asked.tolerance, layers=asked.layers
    )
    shapes = {mark: identity(part) for mark, part in flats.items()}
    look = asked.model_dump()
    new = []
    for mark, part in flats.items():
        names = [f"cut/parts/{mark}.dxf"] + [f"cut/parts/{mark}.bends.csv"] * bool(part.bends)
        key = store.key("part.dxf", look, shapes[mark])
        if not _kept(folder, names, key):
            new.append(part)
    parts = {**flats, **_fresh(folder, new, style, jobs)}
    left = []
    for nest in nests:
        group = f"cut/nests/{nest.material}_{nest.thickness:g}mm"
        sheets = []
        for sheet in nest.sheets:
            own = [shapes[placement.mark] for placement in sheet.placements]
            key = store.key("sheet.dxf", look, sheet, own)
            if not _kept(folder, [f"{group}/{sheet.name}{suffix}" for suffix in SUFFIXES], key):
                sheets.append(sheet)
        left.append(replace(nest, sheets=tuple(sheets)))
    write_nests(left, parts, folder.staged / "cut" / "nests", style, jobs)


def _kept(folder: Folder, names: list[str], key: str) -> bool:
    """Whether all these files are taken over; else none of them is."""
    kept = [folder.again(name, key) for name in names]
    if not all(kept):
        for name in names:
            folder.place(name).unlink(missing_ok=True)
    return all(kept)


def _fresh(
    folder: Folder, parts: list[FlatPart], style: DxfStyle, jobs: int | None
) -> dict[str, Drawn]:
    return write_parts(parts, folder.staged / "cut" / "parts", style, jobs) if parts else {}
