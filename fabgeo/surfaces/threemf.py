"""3MF files: the triangles of everything that a file builds, placed as it says.

An archive of XML. It is foreign data: an archive that unpacks to too much, and document types
(the way of entities that multiply), are refused; nothing is unpacked to the disk.

Source: 3MF Core Specification 1.3, sections 3 and 4.
"""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path
from typing import Any
from xml.parsers import expat

import numpy as np

from fabgeo.arrays import Array, IntArray
from fabgeo.errors import InputError

LARGEST_UNZIPPED = 1 << 30
MODEL = "3D/3dmodel.model"
DEEPEST = 20  # components within components
MOST_TRIANGLES = 20_000_000
MOST_COMPONENTS = 1_000_000  # placed: few that hold each other several times are more than stars
FALLBACK = "export it again"
PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # all that OPC allows (ISO/IEC 29500-2)
UNITS = ("micron", "millimeter", "centimeter", "inch", "foot", "meter")


def read_3mf(path: Path) -> tuple[Array, list[list[int]]]:
    """Vertices (n, 3) in the file's unit and triangles of a 3MF file's model.

    Raises
    ------
    InputError
        If the file is no 3MF file, is damaged, or unpacks to more than is bearable.
    """
    found = _Reader(path.name)
    parser = expat.ParserCreate()
    parser.StartElementHandler = found.start
    parser.StartDoctypeDeclHandler = found.refuse
    try:
        with zipfile.ZipFile(path) as archive:
            names = [name for name in archive.namelist() if name.lower().endswith(".model")]
            if not names:
                raise InputError(path.name, "holds no 3MF model", FALLBACK)
            info = archive.getinfo(MODEL if MODEL in names else names[0])
            if info.compress_type not in PACKED:
                raise InputError(path.name, "is packed as 3MF files never are", FALLBACK)
            if info.file_size > LARGEST_UNZIPPED:
                size = info.file_size >> 20
                raise InputError(path.name, f"unpacks to {size} MiB: more than is bearable")
            with archive.open(info) as stream:
                parser.ParseFile(stream)
        meshes = list(found.built())
    except InputError:
        raise
    except zipfile.BadZipFile as error:
        problem = "is not a 3MF file (no sound zip archive)"
        raise InputError(path.name, problem, FALLBACK) from error
    except (expat.ExpatError, ValueError, KeyError, IndexError, EOFError) as error:
        raise InputError(path.name, f"can't be read as 3MF: {error!r}", FALLBACK) from error
    except (OSError, NotImplementedError, RuntimeError, OverflowError, zlib.error) as error:
        raise InputError(path.name, f"can't be unpacked: {error}", FALLBACK) from error
    if not meshes:
        raise InputError(path.name, "builds no mesh", FALLBACK)
    starts = np.cumsum([0, *(len(points) for points, _ in meshes)])
    triangles = [faces + start for (_, faces), start in zip(meshes, starts, strict=False)]
    return np.concatenate([points for points, _ in meshes]), np.concatenate(triangles).tolist()


class _Reader:
    """What has been read of the model so far."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.points: dict[str, list[tuple[float, ...]]] = {}
        self.faces: dict[str, list[tuple[int, ...]]] = {}
        self.parts: dict[str, list[tuple[str, Array]]] = {}
        self.items: list[tuple[str, Array]] = []
        self.object = ""
        self.placed = self.triangles = 0

    def refuse(self, *_: Any) -> None:
        raise InputError(self.name, "holds a document type declaration", FALLBACK)

    def start(self, tag: str, words: dict[str, str]) -> None:
        tag = tag.rpartition(":")[2]
        if tag == "model" and words.get("unit", "millimeter") not in UNITS:
            raise InputError(
                self.name, f"unknown unit {words['unit']!r}", f"use {', '.join(UNITS)}"
            )
        if tag == "object":
            self.object = words["id"]
            self.points[self.object], self.faces[self.object] = [], []
            self.parts[self.object] = []
        elif tag == "vertex":
            self.points[self.object].append(tuple(float(words[axis]) for axis in "xyz"))
        elif tag == "triangle":
            self.faces[self.object].append(tuple(int(words[v]) for v in ("v1", "v2", "v3")))
        elif tag == "component":
            self.parts[self.object].append((words["objectid"], _transform(words)))
        elif tag == "item":
            self.items.append((words["objectid"], _transform(words)))

    def built(self) -> list[tuple[Array, IntArray]]:
        """Points and triangles of every built item, its components placed."""
        out: list[tuple[Array, IntArray]] = []
        for key, move in self.items:
            self._add(key, move, out, 0)
        return out

    def _add(self, key: str, move: Array, out: list[tuple[Array, IntArray]], depth: int) -> None:
        points, faces = self.points[key], self.faces[key]
        self.placed += 1
        self.triangles += len(faces)
        beyond = self.placed > MOST_COMPONENTS or self.triangles > MOST_TRIANGLES
        if depth > DEEPEST or beyond:
            raise InputError(self.name, "holds components in components without end", FALLBACK)
        if faces:
            placed = np.array(points, dtype=np.float64).reshape(-1, 3) @ move[:3] + move[3]
            numbers = np.array(faces, dtype=np.int64)
            if numbers.min() < 0 or numbers.max() >= len(placed):
                raise InputError(self.name, "a triangle names a vertex that is not there")
            out.append((placed, numbers))
        for part, own in self.parts[key]:
            linear = own[:3] @ move[:3]
            self._add(part, np.vstack([linear, own[3] @ move[:3] + move[3]]), out, depth + 1)


def _transform(words: dict[str, str]) -> Array:
    """The 4 x 3 matrix of a placement; points are rows."""
    text = words.get("transform")
    if text is None:
        return np.vstack([np.eye(3), np.zeros(3)])
    return np.array([float(number) for number in text.split()], dtype=np.float64).reshape(4, 3)
