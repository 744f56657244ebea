"""The colours of a STEP file in one order, whatever order the kernel's hash tables had.

The kernel writes presentation (styles) behind all geometry, part by part in the order of memory
addresses. Here the entities of that tail are numbered afresh, in the order of what they refer to.

Glossary
--------
tail
    All entities from the first presentation on; nothing before refers into it.
expansion
    An entity's text with every entity of the tail that it refers to written out in full.
"""

from __future__ import annotations

import re

BEGIN = b" = MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION("
END = b"ENDSEC;\nEND-ISO-10303-21;"
_ENTITY = re.compile(rb"#(\d+) = (.*?);\n", re.DOTALL)
_REFERENCE = re.compile(rb"#(\d+)")


def ordered(data: bytes) -> bytes:
    """The bytes of a file with its tail in order; the same bytes if there is none."""
    found = data.find(BEGIN)
    if found < 0:
        return data
    begin, end = data.rindex(b"\n", 0, found) + 1, data.rindex(END)
    texts = {int(n): text for n, text in _ENTITY.findall(data[begin:end])}
    if not texts or b"".join(_written(n, t) for n, t in texts.items()) != data[begin:end]:
        return data
    return data[:begin] + _renumbered(texts) + data[end:]


def _renumbered(texts: dict[int, bytes]) -> bytes:
    inner = {n: [r for r in _references(t) if r in texts] for n, t in texts.items()}
    used = {r for references in inner.values() for r in references}
    roots = sorted((_expansion(n, texts), n) for n in texts if n not in used)
    order: dict[int, int] = {}
    for _, root in roots:
        _visit(root, inner, order, min(texts))

    def renumber(found: re.Match[bytes]) -> bytes:
        number = int(found[1])
        return b"#%d" % order.get(number, number)

    return b"".join(_written(order[n], _REFERENCE.sub(renumber, texts[n])) for n in order)


def _visit(entity: int, inner: dict[int, list[int]], order: dict[int, int], first: int) -> None:
    if entity not in order:
        order[entity] = first + len(order)
        for reference in inner[entity]:
            _visit(reference, inner, order, first)


def _expansion(entity: int, texts: dict[int, bytes]) -> bytes:
    def expand(found: re.Match[bytes]) -> bytes:
        number = int(found[1])
        return _expansion(number, texts) if number in texts else b"#%012d" % number

    return _REFERENCE.sub(expand, b"".join(texts[entity].split()))


def _references(text: bytes) -> list[int]:
    return [int(n) for n in _REFERENCE.findall(text)]


def _written(number: int, text: bytes) -> bytes:
    return b"#%d = %s;\n" % (number, text)
