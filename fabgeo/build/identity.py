"""What nouns are known by: digests worked out once and left with them, for nouns never change."""

from __future__ import annotations

from typing import Any

from fabgeo.build.plain import digest
from fabgeo.structures.parts import Cell, Plate


def identity(noun: Any) -> str:
    """Digest of all of a noun, or of what it was made from."""
    return _kept(noun, "_identity", noun)


def known_by(noun: Any, *origin: Any) -> None:
    """Let a noun be known by all that it was made from: shorter than itself."""
    object.__setattr__(noun, "_identity", digest(origin))


def shape_of(part: Plate | Cell) -> str:
    """Digest of what the solid of a part depends on; not of what it is made of."""
    if isinstance(part, Cell):
        return _kept(part, "_shape", (part.mark, part.prism))
    own = (part.mark, part.mid, part.thickness, part.holes, part.bevel)
    return _kept(part, "_shape", own)


def _kept(noun: Any, name: str, told_by: Any) -> str:
    own = vars(noun)
    if name not in own:
        object.__setattr__(noun, name, digest(told_by))
    return own[name]
