"""What refers to what in a STEP file's text, without reading what it means.

Source: ISO 10303-21.

Glossary
--------
statement
    ``#12 = CARTESIAN_POINT(...);``, which begins a line.
place
    A statement's index in the order of the text.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
import numpy.typing as npt

from fabgeo.arrays import IntArray
from fabgeo.cad.stepnumbers import numbers_at

type Mask = npt.NDArray[np.bool_]

_LIST = re.compile(rb"\((\s*#\d+\s*(?:,\s*#\d+\s*)*)\)")
_NUMBER = re.compile(rb"#(\d+)")


@dataclass(frozen=True)
class StepGraph:
    """Statements of a text and what they refer to.

    Attributes
    ----------
    text : bytes
    begin : (k + 1,) array
        Where statements begin, and the end of the text; what stands before the first is the head.
    numbers : (k,) array
        Their numbers.
    first : (k + 1,) array
        Where a statement's references begin in `target`, and their count.
    target : (m,) array
        What statements refer to, by place, in the order of the text.
    """

    text: bytes
    begin: IntArray
    numbers: IntArray
    first: IntArray
    target: IntArray

    @classmethod
    def of(cls, text: bytes) -> Self:
        """The graph of a text."""
        data = np.frombuffer(text, dtype=np.uint8)
        mark = np.flatnonzero(data == ord("#"))
        number, width = numbers_at(data, mark + 1)
        after = mark + 1 + width
        after += data[np.minimum(after, len(data) - 1)] == ord(" ")
        defines = data[np.minimum(after, len(data) - 1)] == ord("=")
        defines &= data[np.maximum(mark - 1, 0)] == ord("\n")
        begin, numbers = mark[defines], number[defines]
        place = np.full(int(number.max(initial=0)) + 1, -1)
        place[numbers] = np.arange(len(numbers))
        source = np.cumsum(defines)[~defines] - 1
        target = place[number[~defines]]
        known = (target >= 0) & (source >= 0)
        first = np.searchsorted(source[known], np.arange(len(numbers) + 1))
        return cls(text, np.append(begin, len(text)), numbers, first, target[known])

    def of_kind(self, kind: str) -> IntArray:
        """Places of the statements of a kind."""
        word, found = kind.encode(), []
        at = self.text.find(word)
        while at >= 0:
            found.append(at)
            at = self.text.find(word, at + len(word))
        place = _distinct(np.searchsorted(self.begin, np.array(found, dtype=int), side="right") - 1)
        place = place[place >= 0]
        starts = re.compile(rb"#\d+ ?= ?%s ?\(" % word)
        begins = [bool(starts.match(self.text, at)) for at in self.begin[place].tolist()]
        return place[np.array(begins, dtype=bool)]

    def pairs(self, places: IntArray) -> IntArray:
        """What statements (n,) refer to (p, 2), of those that refer to two others."""
        both = places[self.first[places + 1] - self.first[places] == 2]
        return self.target[self.first[both][:, None] + [0, 1]]

    def leading(self, places: IntArray) -> IntArray:
        """The first that each statement refers to; -1 where it refers to none, or is -1."""
        some = (places >= 0) & (self.first[places + 1] > self.first[places])
        out = np.full(len(places), -1)
        out[some] = self.target[self.first[places[some]]]
        return out

    def references(self, places: IntArray) -> tuple[IntArray, IntArray]:
        """All that statements (n,) refer to (r,): the row of each in `places`, and its place."""
        count = self.first[places + 1] - self.first[places]
        row = np.repeat(np.arange(len(places)), count)
        skip = np.cumsum(count) - count
        return row, self.target[np.arange(len(row)) + (self.first[places] - skip)[row]]

    @cached_property
    def roots(self) -> IntArray:
        """Statements that none refers to."""
        free = np.ones(len(self.numbers), dtype=bool)
        free[self.target] = False
        return np.flatnonzero(free)

    @cached_property
    def source(self) -> IntArray:
        """The statement of each reference."""
        return np.repeat(np.arange(len(self.numbers)), np.diff(self.first))

    def depend_on(self, places: IntArray) -> IntArray:
        """Statements that refer to some, directly or through others, and these themselves."""
        seen = np.zeros(len(self.numbers), dtype=bool)
        seen[places] = True
        new = seen.copy()
        while new.any():
            hit = np.zeros_like(seen)
            hit[self.source[new[self.target]]] = True
            new = hit & ~seen
            seen |= new
        return np.flatnonzero(seen)

    def reached(self, seeds: IntArray, seen: Mask) -> IntArray:
        """Places that seeds refer to, directly or through others, and these themselves.

        What is `seen` (k,) is gone past; the rest is marked in it.
        """
        found, new = [seeds], seeds
        seen[seeds] = True
        while len(new):
            new = self.references(new)[1]
            new = _distinct(new[~seen[new]])
            seen[new] = True
            found.append(new)
        return np.sort(np.concatenate(found))

    def pieces(self, places: IntArray, lists: IntArray, cut: Collection[int]) -> Iterator[bytes]:
        """The head, then statements (n,) in order; `lists` of them leave out the numbers `cut`."""
        yield self.text[: self.begin[0]]
        shorter = np.isin(places, lists)
        starts = (np.diff(places) > 1) | shorter[1:] | shorter[:-1]
        at = np.append(0, np.flatnonzero(starts) + 1)
        runs = zip(places[at], places[np.append(at[1:], len(places)) - 1], shorter[at], strict=True)
        for one, last, shorten in runs:
            run = self.text[self.begin[one] : self.begin[last + 1]]
            yield _without(run, cut) if shorten else run


def _distinct(values: IntArray) -> IntArray:
    """The values once each, in order; `np.unique` takes ten times as long for millions."""
    values = np.sort(values)
    return values[np.append(True, values[1:] != values[:-1])] if len(values) else values


def _without(statement: bytes, cut: Collection[int]) -> bytes:
    """The statement with its lists less some numbers."""

    def rest(found: re.Match[bytes]) -> bytes:
        own = [b"#" + number for number in _NUMBER.findall(found[1]) if int(number) not in cut]
        return b"(" + b",".join(own) + b")"

    return _LIST.sub(rest, statement)
