"""STEP files of families hold what model/facade.step holds of them, statement by statement.

A statement has the same number in both (`fabgeo.cad.stepjoin`): their texts are compared by hashes,
without the kernel. A model that another program has written since has other statements for the same
solids: of it the marks are compared alone.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np

from fabgeo.arrays import IntArray
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage

FAMILIES = ("panels", "layers", "cells", "walls", "beams", "connectors")
CHUNK = 1 << 24  # bytes that are divided into statements at a time
ROOT, PLACE = 7, 6  # statements of facade.step's root, and of each family's place in it
TAIL = 8192  # bytes in which these are

MARKS = {"panels": "P-", "cells": "C-", "walls": "W-", "beams": "B-", "connectors": "K-"}
"""How the marks of a family begin."""

_SYSTEM = re.compile(rb"FILE_NAME\(.*?,\s*'(?P<system>(?:[^']|'')*)'\s*,\s*'[^']*'\s*\)\s*;", re.S)
_NAME = re.compile(rb"= (?:PRODUCT\(|NEXT_ASSEMBLY_USAGE_OCCURRENCE\('\d+',)'((?:[^']|'')*)'")


def check_families(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Compare the files of families with model/facade.step.

    Where a part of the model was itself found wrong, the file of its family is not named too.
    """
    if not package.step.is_file():
        return
    near = {name: package.step.with_name(f"{name}.step") for name in FAMILIES}
    system = _system(package.step)
    if any(path.is_file() and _system(path) != system for path in near.values()):
        _same_marks(near, measured, findings)
        return
    files = {name: package.step.with_name(f"{name}.step") for name in _families(package.step)}
    there = {name: path for name, path in files.items() if path.is_file()}
    for name in files.keys() - there.keys():
        findings.add(f"model/{name}.step", "file of a family", "present", "missing")
    differing = _differing(package.step, there)
    known = {found.part for found in findings.items}
    for name, marks in differing.items():
        if not marks & known:
            near = ", ".join(sorted(marks)[:3]) or "none"
            findings.add(f"model/{name}.step", "statements", "those of model/facade.step",
                         f"other ones, about {near}")  # fmt: skip


def _system(path: Path) -> bytes:
    """The program that a STEP file's header calls its origin."""
    with path.open("rb") as stream:
        found = _SYSTEM.search(stream.read(TAIL))
    return found["system"] if found else b""


def _same_marks(files: dict[str, Path], measured: Measured, findings: Findings) -> None:
    """Every family that has a file names in it the marks that the model has of it."""
    for name, start in MARKS.items():
        due = {mark for mark in measured.names if mark.startswith(start)}
        if files[name].is_file() and due:
            lost = due - _names(files[name], None)
            if lost:
                words = f"without {', '.join(sorted(lost)[:3])}"
                findings.add(f"model/{name}.step", "marks", "those of model/facade.step", words)


def _families(path: Path) -> list[str]:
    """The families that have files of their own: those of a model that has several."""
    with path.open("rb") as stream:
        stream.seek(max(path.stat().st_size - TAIL, 0))
        names = {name.decode(errors="replace") for name in _NAME.findall(stream.read())}
    found = [name for name in FAMILIES if name in names]
    return found if len(found) > 1 else []


def _differing(step: Path, files: dict[str, Path]) -> dict[str, set[str]]:
    """Names about which files differ from the model, by family; those alone that differ."""
    out: dict[str, set[str]] = {}
    if not files:
        return out
    whole = _hashes(step)
    order = np.argsort(whole)
    owner = np.full(len(whole), -1)
    for k, (name, path) in enumerate(files.items()):
        own = _hashes(path)
        place = order[np.minimum(np.searchsorted(whole, own, sorter=order), len(whole) - 1)]
        same = whole[place] == own
        owner[place[same]] = k
        if not same.all():
            out[name] = _names(path, np.flatnonzero(~same))
    alone = np.flatnonzero(owner < 0)[: -(ROOT + PLACE * len(files))]
    if len(alone) and not out:  # in no file: missing in that of what stands before
        before = np.maximum.accumulate(np.where(owner >= 0, np.arange(len(owner)), 0))
        for k, name in enumerate(files):
            lost = alone[owner[before[alone]] == k]
            if len(lost):
                out[name] = out.get(name, set()) | _names(step, lost)
    return out


def _hashes(path: Path) -> IntArray:
    """Of the statements (n,) of a STEP file's data, in order."""
    return np.fromiter(map(hash, _statements(path)), dtype=np.int64)


def _statements(path: Path) -> Iterator[bytes]:
    """The texts of a STEP file's data one by one; the end of the file is one as well."""
    with path.open("rb") as stream:
        rest = stream.read(CHUNK).partition(b"\nDATA;\n")[2]
        while chunk := stream.read(CHUNK):
            *whole, rest = (rest + chunk).split(b";\n")
            yield from whole
        yield from rest.split(b";\n")


def _names(path: Path, places: IntArray | None) -> set[str]:
    """The products that some statements are of, None: all; they name one, or follow that does."""
    name, names, at = b"", set[str](), None if places is None else set(places.tolist())
    for k, text in enumerate(islice(_statements(path), None if at is None else max(at) + 1)):
        if found := _NAME.search(text):
            name = found[1]
        if at is None or k in at:
            names.add(name.decode(errors="replace"))
    return names
