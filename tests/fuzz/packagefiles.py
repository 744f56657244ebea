"""The files of a small package, one of which is damaged, and the check of the package with it."""

from __future__ import annotations

import io
import shutil
import tempfile
import zipfile
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

PROJECT = {
    "name": "x",
    "surface": {
        **{"unit": "m", "u": [0.0, 3.0], "v": [0.0, 2.0]},
        **{"x": "u", "y": "v", "z": "0.04*u*u - 0.06*v*v"},
    },
    "strips": {"kind": "conical", "start": "principal", "count": 2, "segments": 4},
    "panels": {"length": 1600.0, "joint": 10.0, "tolerance": 3.0},
    "cells": {"depth": -180.0},
    "beams": {"standoff": 27.0, "depth": 100.0, "flange_width": 180.0},
    "connectors": {"spacing": 900.0},
    "nesting": {"seconds": 0.5},
}
UNREAD = (".html", ".pdf", ".svg", ".glb", ".ifc")  # but for their hashes


@cache
def _package() -> tempfile.TemporaryDirectory[str]:
    import fabgeo

    folder = tempfile.TemporaryDirectory()
    fabgeo.build_package(PROJECT, folder.name, jobs=1)
    shutil.rmtree(Path(folder.name, ".fabgeo"), ignore_errors=True)
    return folder


def package_files() -> list[bytes]:
    """A line with a file's name, then what it holds; the workbook once more, not compressed."""
    folder = Path(_package().name)
    found = [p for p in sorted(folder.rglob("*")) if p.is_file() and p.suffix not in UNREAD]
    out = [f"{p.relative_to(folder)}\n".encode() + p.read_bytes() for p in found]
    book, stream = folder / "schedules" / "fabgeo.xlsx", io.BytesIO()
    with zipfile.ZipFile(book) as old, zipfile.ZipFile(stream, "w") as plain:
        for info in old.infolist():
            plain.writestr(info.filename, old.read(info))
    return [*out, f"{book.relative_to(folder)}\n".encode() + stream.getvalue()]


@cache
def _read_once() -> Callable[..., Any]:
    """`read_isolated`, which measures the solids of a sound model only once."""
    from fabgeo.cad.isolated import read_isolated

    sound = Path(_package().name, "model", "facade.step").read_bytes()
    first: list[Any] = []

    def read(path: Path, function: Callable[..., Any], task: object, text: bytes) -> Any:
        if text != sound:
            return read_isolated(path, function, task, text)
        if not first:
            first.append(read_isolated(path, function, task, text))
        return deepcopy(first[0])

    return read


def check_damaged(path: Path) -> None:
    """Check the package with one file as this one says."""
    from fabgeo.cad import isolated
    from fabgeo.review.check import check_package

    name, _, data = path.read_bytes().partition(b"\n")
    with tempfile.TemporaryDirectory() as folder:
        copy = shutil.copytree(_package().name, folder, dirs_exist_ok=True)
        if name in {str(p.relative_to(copy)).encode() for p in Path(copy).rglob("*.*")}:
            Path(copy, name.decode()).write_bytes(data)
        with patch.object(isolated, "read_isolated", _read_once()):
            report = check_package(Path(copy), jobs=1)
        stopped = [f for f in report.findings if f.what.startswith("files for the check of")]
        assert not stopped, stopped  # what no step foresaw
        assert list(report.lines())
        assert report.as_dict()
