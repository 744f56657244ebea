"""What nouns are known by: digests worked out once and left with them, for nouns never change."""

from __future__ import annotations

from typing import Any

from fabgeo.build.plain import digest
from fabgeo.panels.flat import FlatPart
from fabgeo.structures.parts import Cell, Plate


def identity(noun: Any) -> str:
    """Digest of all of a noun, or of what it was made from."""
    return _kept(noun, "_identity", noun)


def known_by(flat: FlatPart, origin: str, material: str) -> None:
    """Let a flat part be known by what it was made from: shorter than itself."""
    object.__setattr__(flat, "_shape", origin)
    object.__setattr__(flat, "_identity", digest(origin, material))


def shape_of(part: Plate | Cell | FlatPart) -> str:
    """Digest of what the solid of a part, or its outline, depends on; not of its material."""
    if isinstance(part, FlatPart):
        return _kept(part, "_shape", (part.outline, part.thickness))
    if isinstance(part, Cell):
        return _kept(part, "_shape", (part.mark, part.prism))
    own = (part.mark, part.mid, part.thickness, part.holes, part.bevel)
    return _kept(part, "_shape", own)


def _kept(noun: Any, name: str, told_by: Any) -> str:
    own = vars(noun)
    if name not in own:
        object.__setattr__(noun, name, digest(told_by))
    return own[name]
