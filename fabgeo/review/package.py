"""A written package opened for checking: its schedules, its manifest, its files by mark."""

from __future__ import annotations

import csv
import json
from collections import defaultdict
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.review.manifest import NAME

WORDS = ("verdict", "reason", "sense", "label", "origin", "mark")
"""Entries of review.json that are no numbers."""


@dataclass
class WrittenPackage:
    """The files of a package, read on demand; nothing of the objects that wrote them.

    Attributes
    ----------
    folder : Path
    manifest : dict
        Contents of manifest.json.
    jobs : int, optional
        Processes to measure it with; None: as joblib's `parallel_config` says.
    """

    folder: Path
    manifest: dict[str, Any] = field(default_factory=dict)
    jobs: int | None = None

    def __getstate__(self) -> dict[str, Any]:
        """What goes to other processes: where it is and its settings, no tables, no hashes."""
        return {"folder": self.folder, "manifest": {"project": self.project}, "jobs": None}

    @classmethod
    def open(cls, folder: Path, jobs: int | None = None) -> WrittenPackage:
        """Open a folder.

        Raises
        ------
        InputError
            If it is no package: no manifest.json, or one that is no JSON.
        """
        path = folder / NAME
        if not path.is_file():
            raise InputError(str(folder), f"holds no {NAME}", "give the folder of a build")
        try:
            manifest = json.loads(path.read_text(encoding="utf-8"))
        except (ValueError, RecursionError) as error:
            raise InputError(str(path), f"is no JSON: {error}", "build again") from error
        if not isinstance(manifest, dict):
            raise InputError(str(path), "expected an object at its top", "build again")
        return cls(folder, manifest, jobs)

    @property
    def project(self) -> Mapping[str, Any]:
        """The project as read, from the manifest."""
        return _object(self.manifest.get("project"))

    def setting(self, table: str, key: str, default: Any) -> Any:
        """One setting of the project, such as the nests' spacing."""
        value = _object(self.project.get(table)).get(key)
        wrong = isinstance(default, float) and not isinstance(value, int | float)
        return default if value is None or wrong else value

    @cached_property
    def review_as_written(self) -> dict[str, Any]:
        """Contents of checks/review.json; empty if it is absent or broken."""
        try:
            text = (self.folder / "checks" / "review.json").read_text("utf-8")
            return _object(json.loads(text))
        except (OSError, ValueError, RecursionError):
            return {}

    @cached_property
    def review(self) -> dict[str, Any]:
        """Summary, limits, worst and parts of checks/review.json; empty if it has none of these.

        What is not of its kind in there, such as a word for a number, counts as missing.
        """
        found = self.review_as_written
        tables = {
            key: {name: _object(own) for name, own in _object(found.get(key)).items()}
            for key in ("limits", "worst", "parts")
        }
        return found and {
            "summary": _clean(_object(found.get("summary")), ()),
            **{key: {n: _clean(own, WORDS) for n, own in t.items()} for key, t in tables.items()},
        }

    def table(self, name: str) -> list[dict[str, str]]:
        """Rows of a schedule; empty if it is absent."""
        return csv_rows(self.folder / "schedules" / f"{name}.csv")

    @cached_property
    def tables(self) -> dict[str, list[dict[str, str]]]:
        """All schedules by name."""
        return {
            name: self.table(name)
            for name in ("panels", "plates", "beams", "cells", "connectors", "sheets", "bom")
        }

    @cached_property
    def cut_rows(self) -> dict[str, dict[str, str]]:
        """Schedule rows of everything that is cut flat, by mark."""
        rows = [*self.tables["panels"], *self.tables["plates"]]
        return {row.get("mark", ""): row for row in rows}

    @cached_property
    def part_files(self) -> dict[str, Path]:
        """cut/parts/<mark>.dxf by mark."""
        return {p.stem: p for p in sorted((self.folder / "cut" / "parts").glob("*.dxf"))}

    @cached_property
    def setout(self) -> dict[str, list[dict[str, str]]]:
        """Rows of setout/points.csv by mark."""
        own: dict[str, list[dict[str, str]]] = defaultdict(list)
        for row in csv_rows(self.folder / "setout" / "points.csv"):
            own[row.get("mark", "")].append(row)
        return own

    @property
    def outwards(self) -> dict[str, Array]:
        """Mean outward direction (3,) of every part with points in setout/points.csv."""
        found = {}
        for mark, rows in self.setout.items():
            values = [[number(row, key) for key in ("nx", "ny", "nz")] for row in rows]
            known = [value for value in values if None not in value]
            if known:
                found[mark] = np.array(known, dtype=float).mean(axis=0)
        return found

    @cached_property
    def sheet_files(self) -> list[Path]:
        """All nested sheets."""
        return sorted((self.folder / "cut" / "nests").glob("*/*.dxf"))

    @property
    def step(self) -> Path:
        """The model."""
        return self.folder / "model" / "facade.step"

    def layer(self, name: str) -> str:
        """The shop's name of a DXF layer."""
        return str(_object(self.setting("cutting", "layers", {})).get(name, name))


def _object(found: Any) -> dict[str, Any]:
    """What JSON holds where an object is expected; empty for anything else."""
    return found if isinstance(found, dict) else {}


def _clean(found: dict[str, Any], words: Collection[str]) -> dict[str, Any]:
    """Numbers and nulls of an object, and the text of its words."""
    kept = {k: v for k, v in found.items() if k not in words and isinstance(v, int | float | None)}
    return kept | {k: v for k, v in found.items() if k in words and isinstance(v, str)}


def csv_rows(path: Path) -> list[dict[str, str]]:
    """Rows of a CSV file by the names of its columns; empty if it is absent.

    Whatever is damaged stays a cell of text, which agrees with nothing.
    """
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", errors="replace", newline="") as stream:
        lines = csv.reader(stream)
        try:
            names = next(lines, [])
            return [
                dict(zip_longest(names, line[: len(names)], fillvalue="")) for line in lines if line
            ]
        except csv.Error:  # a cell without end
            return []


def number(row: Mapping[str, str], key: str) -> float | None:
    """A number of a schedule row; None where empty or missing."""
    text = (row.get(key) or "").strip()
    try:
        return float(text) if text else None
    except ValueError:
        return float("nan")
