"""A STEP file divided among processes: every share has the whole product tree, and some solids.

The kernel reads a file in one thread, and most of that time goes into its solids. In a share the
solids of the others are stand-ins without faces, and what only these refer to is left out; names,
places, colours and layers stay as they are. Source: ISO 10303-21.

Glossary
--------
statement
    ``#12 = CARTESIAN_POINT(...);``, which begins a line.
stand-in
    A solid whose shell has no faces: the kernel makes it a part without any shape.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
import numpy.typing as npt

from fabgeo.arrays import IntArray
from fabgeo.cad.stepnumbers import numbers_at

type Mask = npt.NDArray[np.bool_]

_SOLID = re.compile(rb"^#(\d+) ?= ?(MANIFOLD_SOLID_BREP ?\([^;]*,\s*)#\d+\s*\);", re.M)
_OTHERS = re.compile(rb"/\*|\b(?:BREP_WITH_VOIDS|FACETED_BREP|SHELL_BASED_SURFACE_MODEL)\b")
_END = re.compile(rb"^ENDSEC;\s*END-ISO-10303-21;", re.M)


def step_shares(path: Path, count: int) -> Iterator[bytes]:
    """The texts of `count` shares, equally long, with the solids in the file's order.

    The file itself, once, where it can't be divided: few solids, shapes that are no plain solids,
    comments, statements that don't begin lines.
    """
    text = path.read_bytes()
    found = list(_SOLID.finditer(text))
    solids = np.array([int(solid[1]) for solid in found])
    end = _END.search(text)
    if count < 2 or len(solids) < 2 * count or end is None or _OTHERS.search(text):
        yield text
        return
    graph = _Graph.of(text[: end.start()])
    own = graph.mask(solids)
    if own.sum() != len(solids):
        yield text
        return
    others = graph.without(own).reached(~graph.reached(own)) | own
    shell = int(graph.numbers.max()) + 1
    at = np.array([solid.start() for solid in found])
    cuts = np.searchsorted(at, at[0] + (end.start() - at[0]) * np.arange(1, count) / count)
    for some in np.split(solids, cuts):
        share = graph.text(others | graph.reached(graph.mask(some)))
        mine = set(some.tolist())

        def solid(found: re.Match[bytes], mine: set[int] = mine) -> bytes:
            own = int(found[1]) in mine
            return found[0] if own else b"#%s = %s#%d);" % (found[1], found[2], shell)

        empty = b"#%d = CLOSED_SHELL('',());\n" % shell
        yield _SOLID.sub(solid, share) + empty + text[end.start() :]


@dataclass(frozen=True)
class _Graph:
    """Statements of a text and what they refer to.

    Attributes
    ----------
    bytes : (n,) array
        The text.
    begin : (k,) array
        Where statements begin; what stands before the first belongs to none.
    numbers : (k,) array
        Their numbers.
    source, target : (m,) array
        References from statement to statement, by place in `numbers`.
    """

    bytes: npt.NDArray[np.uint8]
    begin: IntArray
    numbers: IntArray
    source: IntArray
    target: IntArray

    @classmethod
    def of(cls, data: bytes) -> Self:
        """The graph of a text."""
        text = np.frombuffer(data, dtype=np.uint8)
        mark = np.flatnonzero(text == ord("#"))
        number, width = numbers_at(text, mark + 1)
        after = mark + 1 + width
        after += text[np.minimum(after, len(text) - 1)] == ord(" ")
        defines = text[np.minimum(after, len(text) - 1)] == ord("=")
        defines &= text[np.maximum(mark - 1, 0)] == ord("\n")
        begin, numbers = mark[defines], number[defines]
        place = np.full(int(number.max(initial=0)) + 1, -1)
        place[numbers] = np.arange(len(numbers))
        source = np.cumsum(defines)[~defines] - 1
        target = place[number[~defines]]
        known = (target >= 0) & (source >= 0)
        return cls(text, begin, numbers, source[known], target[known])

    def mask(self, numbers: IntArray) -> Mask:
        """Which statements have one of the numbers."""
        return np.isin(self.numbers, numbers)

    def without(self, cut: Mask) -> _Graph:
        """The graph without references to some statements."""
        keep = ~cut[self.target]
        return _Graph(self.bytes, self.begin, self.numbers, self.source[keep], self.target[keep])

    def reached(self, seeds: Mask) -> Mask:
        """Statements that some refer to, directly or through others, and these themselves."""
        seen, new = seeds.copy(), seeds
        while new.any():
            hit = np.zeros_like(seen)
            hit[self.target[new[self.source]]] = True
            new = hit & ~seen
            seen |= new
        return seen

    def text(self, keep: Mask) -> bytes:
        """What stands before the first statement, and some of the statements."""
        size = np.diff(np.append(self.begin, len(self.bytes)))
        return (
            self.bytes[: self.begin[0]].tobytes()
            + self.bytes[self.begin[0] :][np.repeat(keep, size)].tobytes()
        )
