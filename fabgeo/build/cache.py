"""What a build leaves for the next one: results by the sha256 of everything they depend on.

Glossary
--------
key
    sha256 of a result's inputs, of fabgeo's own source and of the versions of its libraries: a
    result that is found is the one that would be made.
entry
    One file ``.fabgeo/cache/<kind>/<key>``: a checksum, then plain bytes (`fabgeo.build.plain`).
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from fabgeo.build.plain import digest, pack, unpack
from fabgeo.errors import InputError

LIBRARIES = (  # whose results are in entries and in files that are taken over
    *("numpy", "scipy", "pypardiso", "highspy", "packingsolver", "spyrrow", "shapely", "trimesh"),
    *("cadquery-ocp-novtk", "cadquery-ocp", "build123d", "bd_warehouse", "rhino3dm"),
    *("ezdxf", "hershey-fonts", "matplotlib", "reportlab"),
)
CHECKSUM = 32  # bytes


class Cache:
    """Results of earlier builds into a folder; without a folder nothing is kept.

    Parameters
    ----------
    folder : Path, optional
    fresh : bool
        Find nothing (results are kept all the same).

    Attributes
    ----------
    found, made : int
        Results that were there, and that were not.
    """

    def __init__(self, folder: Path | None = None, fresh: bool = False) -> None:
        self.folder = folder
        self.found = self.made = 0
        self._fresh = fresh
        self._used: set[tuple[str, str]] = set()

    def key(self, kind: str, *inputs: Any) -> str:
        """The key of a result of these inputs."""
        return digest(own_source(), kind, inputs)

    def get(self, kind: str, key: str) -> Any | None:
        """The result, or None where there is none or its file is damaged."""
        if self.folder is None:
            return None
        self._used.add((kind, key))
        if self._fresh:
            return None
        value = read_entry(self.folder / kind / key)
        self.found += value is not None
        return value

    def keep(self, kind: str, key: str) -> None:
        """Spare an entry from `prune` that this build had no need to read."""
        self._used.add((kind, key))

    def file(self, kind: str, key: str) -> Path | None:
        """The entry's file, if there is a folder."""
        return None if self.folder is None else self.folder / kind / key

    def put(self, kind: str, key: str, value: Any) -> None:
        """Keep a result; its file is there whole or not at all."""
        self.put_packed(kind, key, b"" if self.folder is None else pack(value))

    def put_packed(self, kind: str, key: str, data: bytes) -> None:
        """Keep a result as `pack` wrote it."""
        self.made += 1
        if self.folder is None:
            return
        path = self.folder / kind / key
        path.parent.mkdir(parents=True, exist_ok=True)
        beside = path.with_suffix(".part")
        try:
            beside.write_bytes(sha256(data).digest() + data)
            os.replace(beside, path)
        except OSError:
            beside.unlink(missing_ok=True)
            raise

    def once[T](self, kind: str, inputs: tuple[Any, ...], make: Callable[[], T]) -> T:
        """The result of these inputs, made if it is not there."""
        key = self.key(kind, *inputs)
        value = self.get(kind, key)
        if value is None:
            value = make()
            self.put(kind, key, value)
        return value

    def prune(self) -> None:
        """Remove what this build neither found nor made."""
        if self.folder is None:
            return
        for path in self.folder.glob("*/*"):
            if (path.parent.name, path.name) not in self._used:
                path.unlink(missing_ok=True)


def read_entry(path: Path) -> Any | None:
    """What an entry's file holds, or None where there is none or it is damaged."""
    try:
        data = path.read_bytes()
        if sha256(data[CHECKSUM:]).digest() != data[:CHECKSUM]:
            return None
        return unpack(data[CHECKSUM:], known=True)
    except (OSError, InputError):
        return None


@cache
def own_source() -> str:
    """sha256 of fabgeo's source and the versions of the libraries that make numbers."""
    root = Path(__file__).resolve().parent.parent
    sources = {p.relative_to(root).as_posix(): p.read_bytes() for p in root.rglob("*.py")}
    return digest([_version(name) for name in LIBRARIES], dict(sorted(sources.items())))


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""
