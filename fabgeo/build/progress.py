"""Stages of a build: their seconds, and news of them for whoever listens.

Glossary
--------
stage
    A named step of the way from surface to package; each is timed and has one progress bar.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from fabgeo.arrays import shown
from fabgeo.errors import InputError


@dataclass(frozen=True)
class Progress:
    """News of a stage: `done` of `total` steps (total 0: not known), and a word about it."""

    stage: str
    done: int
    total: int
    note: str = ""
    finished: bool = False


type Listener = Callable[[Progress], object]


class Clock:
    """Times stages and tells a listener."""

    def __init__(self, listener: Listener | None = None) -> None:
        if listener is not None and not callable(listener):
            raise InputError("listener", f"expected a function, found {shown(listener)}")
        self.seconds: dict[str, float] = {}
        self._listener = listener
        self._stage = ""
        self._done = 0
        self._total = 0

    @contextmanager
    def stage(self, name: str, total: int = 0) -> Iterator[None]:
        """Run one stage; its wall-clock seconds are added up under its name."""
        self._stage, self._done, self._total = name, 0, total
        self.tell("")
        begin = time.perf_counter()
        try:
            yield
        finally:
            spent = time.perf_counter() - begin
            self.seconds[name] = round(self.seconds.get(name, 0.0) + spent, 3)
        self.tell("", finished=True)

    def tell(
        self, note: str, done: int | None = None, total: int | None = None, finished: bool = False
    ) -> None:
        """News of the stage at work."""
        self._done = self._done if done is None else done
        self._total = self._total if total is None else total
        if finished:
            self._done = self._total
        if self._listener:
            self._listener(Progress(self._stage, self._done, self._total, note, finished))

    def each[T](self, items: Iterable[T]) -> Iterator[T]:
        """Pass items through, telling of each."""
        for count, item in enumerate(items, 1):
            yield item
            self.tell("", done=count)
