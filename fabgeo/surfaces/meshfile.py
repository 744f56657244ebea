"""Mesh files: OBJ and OFF (quads kept), 3MF, and STL and PLY through trimesh."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fabgeo.arrays import Array
from fabgeo.errors import InputError
from fabgeo.surfaces.mesh import Mesh, checked_mesh
from fabgeo.surfaces.threemf import read_3mf

LARGEST_FILE = 512 << 20
TRIMESH_SUFFIXES = (".stl", ".ply")
SUFFIXES = (".obj", ".off", ".3mf", *TRIMESH_SUFFIXES)


def read_mesh(path: str | Path, piece: str | int | None = None) -> Mesh:
    """A mesh from a file, in the file's own unit.

    Parameters
    ----------
    path : str or Path
        ``.obj``, ``.off`` (quads are kept), ``.stl``, ``.ply`` or ``.3mf``.
    piece : int or "largest", optional
        Which connected piece, if there are several.

    Raises
    ------
    InputError
        With file and line where there is one: for unreadable numbers, bad indices, and everything
        `mesh.checked_mesh` refuses.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(str(path), "there is no such file", "check the path")
    if path.stat().st_size > LARGEST_FILE:
        raise InputError(path.name, f"the file is larger than {LARGEST_FILE >> 20} MiB")
    suffix = path.suffix.lower()
    if suffix == ".obj":
        vertices, faces = parse_obj(path.name, path.read_text(errors="replace"))
    elif suffix == ".off":
        vertices, faces = parse_off(path.name, path.read_text(errors="replace"))
    elif suffix == ".3mf":
        vertices, faces = read_3mf(path)
    elif suffix in TRIMESH_SUFFIXES:
        vertices, faces = _by_trimesh(path)
    else:
        raise InputError(path.name, f"is not a mesh file ({', '.join(SUFFIXES)})")
    return checked_mesh(path.name, vertices, faces, piece)


def parse_obj(name: str, text: str) -> tuple[Array, list[list[int]]]:
    """Vertices and 0-based faces of a Wavefront OBJ text.

    Only ``v`` and ``f`` lines count; negative indices run backwards from the last vertex; a line
    that ends with a backslash goes on in the next. Polylines, free-form curves and surfaces,
    texture and normal indices are passed over.
    """
    vertices: list[tuple[float, float, float]] = []
    faces: list[list[int]] = []
    lines: list[int] = []
    for number, line in _lines(text):
        words = line.split()
        if words[0] == "v":
            vertices.append(_point(f"{name}, line {number}", words[1:4]))
        elif words[0] == "f":
            where = f"{name}, line {number}"
            face = [_index(where, word.split("/")[0]) for word in words[1:]]
            if 0 in face:
                raise InputError(
                    where, "a face refers to vertex 0; OBJ counts from 1", "add 1 to every index"
                )
            faces.append([i - 1 if i > 0 else len(vertices) + i for i in face])
            lines.append(number)
    for face, number in zip(faces, lines, strict=True):
        for i in face:
            if not 0 <= i < len(vertices):
                raise InputError(
                    f"{name}, line {number}",
                    f"a face refers to vertex {i + 1}, but there are {len(vertices)}",
                    "export the mesh again",
                )
    return np.array(vertices, dtype=np.float64).reshape(-1, 3), faces


def parse_off(name: str, text: str) -> tuple[Array, list[list[int]]]:
    """Vertices and 0-based faces of an OFF text; extra numbers (COFF, NOFF) are passed over."""
    lines = list(_lines(text))
    if not lines or not lines[0][1].split()[0].upper().endswith("OFF"):
        raise InputError(f"{name}, line 1", "expected the word OFF", "is it an OFF file?")
    words = lines[0][1].split()[1:]
    start = 1
    if not words:
        if len(lines) < 2:
            raise InputError(name, "ends before the counts of vertices and faces")
        words, start = lines[1][1].split(), 2
    counts = [_index(f"{name}, line {lines[start - 1][0]}", w) for w in words[:2]]
    if len(counts) < 2 or min(counts) < 0:
        raise InputError(
            f"{name}, line {lines[start - 1][0]}", "expected the counts of vertices and faces"
        )
    points, rest = lines[start : start + counts[0]], lines[start + counts[0] :]
    if len(points) < counts[0] or len(rest) < counts[1]:
        found = len(lines) - start
        raise InputError(
            name, f"announces {counts[0]} vertices and {counts[1]} faces, but has {found} lines"
        )
    vertices = [_point(f"{name}, line {n}", line.split()[:3]) for n, line in points]
    faces = []
    for number, line in rest[: counts[1]]:
        where = f"{name}, line {number}"
        entries = line.split()
        corners = _index(where, entries[0])
        if corners < 3 or len(entries) < corners + 1:
            raise InputError(where, f"expected a count and as many vertex indices, found {line!r}")
        faces.append([_index(where, w) for w in entries[1 : corners + 1]])
    return np.array(vertices, dtype=np.float64).reshape(-1, 3), faces


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Numbered lines without comments and blanks; backslash continuations joined."""
    held, first = "", 0
    for number, raw in enumerate(text.splitlines(), start=1):
        line = raw.split("#", 1)[0].strip()
        first = first or number
        if line.endswith("\\"):
            held += line[:-1] + " "
            continue
        if (held + line).strip():
            yield first, (held + line).strip()
        held, first = "", 0
    if held.strip():
        yield first, held.strip()


def _point(where: str, words: list[str]) -> tuple[float, float, float]:
    try:
        x, y, z = (float(w) for w in words)
    except ValueError:
        raise InputError(where, f"expected three coordinates, found {' '.join(words)!r}") from None
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        raise InputError(
            where, f"a coordinate is not finite: {' '.join(words)}", "remove or repair the vertex"
        )
    return x, y, z


def _index(where: str, word: str) -> int:
    try:
        value = int(word)
    except ValueError:
        raise InputError(where, f"expected a whole number, found {word!r}") from None
    if abs(value) > 1 << 40:
        raise InputError(where, f"the index {word} is far too large")
    return value


def _by_trimesh(path: Path) -> tuple[Array, list[list[int]]]:
    import trimesh

    try:
        loaded = trimesh.load_mesh(path, process=False)
        if isinstance(loaded, trimesh.Scene):
            loaded = loaded.to_mesh()
        vertices = np.asarray(loaded.vertices, dtype=np.float64)
        announced = _announced(path) if path.suffix.lower() == ".ply" else 0
        faces = np.asarray(loaded.faces, dtype=np.int64).reshape(-1, 3)
    except Exception as error:  # whatever a foreign reader raises over foreign bytes
        raise InputError(
            path.name, f"can't be read as {path.suffix[1:].upper()}: {error}", "export it again"
        ) from error
    if len(faces) < announced:
        raise InputError(
            path.name, f"announces {announced} faces, but has {len(faces)}", "export it again"
        )
    return vertices, faces.tolist()


def _announced(path: Path) -> int:
    """How many faces the header of a PLY file says that there are."""
    with path.open("rb") as file:
        header = file.read(1 << 16).partition(b"end_header")[0]
    found = re.search(rb"^\s*element\s+face\s+(\d{1,12})\s*$", header, re.MULTILINE)
    return int(found[1]) if found else 0
