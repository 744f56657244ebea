"""Meshes of triangles and quads as they come from files: checked, welded, turned the same way.

Glossary
--------
loop
    A closed chain of boundary edges, as vertex indices.
regular
    All faces are quads and every vertex is where grid lines cross or end: the mesh is a grid.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from fabgeo.arrays import Array, IntArray, as_numbers, cross, set_frozen
from fabgeo.errors import InputError

WELD = 1e-7  # vertices closer than this part of the size are one
ABSURD = 1e15  # a coordinate beyond is as good as infinite: its square has no digits left
LEAST_RISE = 0.02  # of the area around a vertex, seen along its normal: faces 1 degree from upright


@dataclass(frozen=True, eq=False)
class Mesh:
    """A connected, oriented 2-manifold mesh (`checked_mesh` makes one).

    Attributes
    ----------
    vertices : (n, 3) array
    triangles : (t, 3) int array
    quads : (q, 4) int array
    """

    vertices: Array
    triangles: IntArray
    quads: IntArray

    def __post_init__(self) -> None:
        set_frozen(self, "vertices", (None, 3))

    @property
    def faces(self) -> list[tuple[int, ...]]:
        """All faces as tuples of vertex indices, quads first."""
        return [tuple(f) for f in (*self.quads.tolist(), *self.triangles.tolist())]

    @cached_property
    def triangulated(self) -> IntArray:
        """(t + 2 q, 3): triangles, and quads split along the shorter diagonal."""
        q, p = self.quads, self.vertices
        if not len(q):
            return self.triangles
        straight = np.linalg.norm(p[q[:, 0]] - p[q[:, 2]], axis=1)
        other = np.linalg.norm(p[q[:, 1]] - p[q[:, 3]], axis=1)
        turned = np.where((straight <= other)[:, None], q, np.roll(q, -1, axis=1))
        return np.concatenate([self.triangles, turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]])

    @cached_property
    def loops(self) -> tuple[IntArray, ...]:
        """Boundary loops as vertex indices, the mesh on their left."""
        following = {}
        directed = {e for f in self.faces for e in _edges(f)}
        for a, b in directed:
            if (b, a) not in directed:
                following[a] = b
        loops = []
        while following:
            start, b = following.popitem()
            loop = [start]
            while b != start:
                loop.append(b)
                b = following.pop(b)
            loops.append(np.array(loop))
        return tuple(sorted(loops, key=lambda x: (-len(x), int(x.min()))))


def _edges(face: Sequence[int]) -> list[tuple[int, int]]:
    return [(face[k - 1], face[k]) for k in range(len(face))]


def checked_mesh(
    name: str, vertices: Array, faces: Sequence[Sequence[int]], piece: str | int | None = None
) -> Mesh:
    """A mesh from vertices and 0-based faces of any number of corners.

    Vertices that coincide are welded, unused ones dropped, faces with more than four corners cut
    into triangles, and faces turned to agree with their neighbours.

    Parameters
    ----------
    piece : int or "largest", optional
        Which connected piece to take if there are several (0 has the most faces).

    Raises
    ------
    InputError
        If the mesh is empty, has bad indices, degenerate faces, edges with three faces, vertices
        where two sheets touch or faces fold back, several pieces, or can't be oriented.
    """
    vertices = as_numbers(f"{name}: vertices", vertices)
    if not len(faces) or not vertices.size:
        raise InputError(name, "the mesh is empty: it has no face", "export it with its faces")
    if vertices.shape[1:] != (3,):
        raise InputError(name, f"expected vertices (n, 3), found shape {vertices.shape}")
    absurd = ~(np.abs(vertices) < ABSURD).all(axis=1)
    if absurd.any():
        at = int(absurd.argmax())
        raise InputError(name, f"vertex {at} has a coordinate that is not finite", "remove it")
    _check_indices(name, len(vertices), faces)
    welded, vertices = _welded(vertices)
    faces = _checked_faces(name, vertices, [[int(welded[i]) for i in f] for f in faces])
    faces = _one_piece(name, len(vertices), faces, piece)
    faces = _oriented(name, vertices, faces)
    used, inverse = np.unique(np.concatenate(faces), return_inverse=True)
    renumbered = np.split(inverse, np.cumsum([len(f) for f in faces])[:-1])
    triangles = np.array([f for f in renumbered if len(f) == 3], dtype=np.int64).reshape(-1, 3)
    quads = np.array([f for f in renumbered if len(f) == 4], dtype=np.int64).reshape(-1, 4)
    mesh = Mesh(vertices[used], triangles, quads)
    _check_sheets(name, mesh)
    _check_folds(name, mesh)
    return mesh


def _check_indices(name: str, count: int, faces: Sequence[Sequence[int]]) -> None:
    try:
        flat = np.array([i for f in faces for i in f])
    except (TypeError, ValueError) as error:
        raise InputError(name, f"expected faces of vertex indices: {error}") from error
    if len(flat) and flat.dtype.kind not in "iu":
        raise InputError(name, "expected faces of whole vertex indices, found others")
    for k, face in enumerate(faces):
        if len(face) < 3:
            raise InputError(name, f"face {k} has {len(face)} corners", "remove it")
        for i in face:
            if not 0 <= i < count:
                one_based = flat.max() == count and flat.min() >= 1
                raise InputError(
                    name,
                    f"face {k} refers to vertex {i}, but there are {count} (0 to {count - 1})"
                    + (
                        "; the indices look 1-based, this format counts from 0" if one_based else ""
                    ),
                    "subtract 1 from every index" if one_based else "export the mesh again",
                )


def _welded(vertices: Array) -> tuple[IntArray, Array]:
    """For every old vertex its new index, and the new vertices."""
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    pairs = KDTree(vertices).query_pairs(WELD * size, output_type="ndarray")
    n = len(vertices)
    if not len(pairs):
        return np.arange(n), vertices
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    _, label = connected_components(graph, directed=False)
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    return rank[inverse], vertices[first[order]]


def _checked_faces(name: str, vertices: Array, faces: list[list[int]]) -> list[list[int]]:
    """Faces of three or four different corners and some area."""
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    checked: list[list[int]] = []
    for k, face in enumerate(faces):
        corners = [a for a, b in zip(face, face[-1:] + face[:-1], strict=True) if a != b]
        if len(set(corners)) != len(corners) or len(corners) < 3:
            where = np.round(vertices[face[0]], 6).tolist()
            raise InputError(
                name, f"face {k} at {where} is degenerate: corners coincide", "remove the face"
            )
        p = vertices[corners]
        area = np.linalg.norm(cross(p - p[0], np.roll(p, -1, axis=0) - p[0]).sum(axis=0)) / 2.0
        if area < 1e-14 * size * size:
            where = np.round(p[0], 6).tolist()
            raise InputError(name, f"face {k} at {where} has no area", "remove the face")
        if len(corners) <= 4:
            checked.append(corners)
        else:
            checked += [[corners[0], b, c] for b, c in pairwise(corners[1:])]
    return checked


def _one_piece(
    name: str, count: int, faces: list[list[int]], piece: str | int | None
) -> list[list[int]]:
    a = np.array([e[0] for f in faces for e in _edges(f)])
    b = np.array([e[1] for f in faces for e in _edges(f)])
    graph = coo_matrix((np.ones(len(a)), (a, b)), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    owner = np.array([label[f[0]] for f in faces])
    labels, sizes = np.unique(owner, return_counts=True)
    if len(labels) == 1:
        return faces
    order = np.argsort(-sizes, kind="stable")
    if piece is None:
        shown = ", ".join(str(int(s)) for s in sizes[order][:8])
        raise InputError(
            name,
            f"the mesh falls into {len(labels)} separate pieces of {shown} faces",
            "join them, export one alone, or choose one with piece = 0, 1, ... or 'largest'",
        )
    number = 0 if piece == "largest" else int(piece)
    if not 0 <= number < len(labels):
        raise InputError(name, f"has no piece {number}: it falls into {len(labels)} pieces")
    return [f for f, o in zip(faces, owner, strict=True) if o == labels[order[number]]]


def _oriented(name: str, vertices: Array, faces: list[list[int]]) -> list[list[int]]:
    """Faces turned so that neighbours run along their edge in opposite directions."""
    sharing: dict[tuple[int, int], list[int]] = defaultdict(list)
    for k, face in enumerate(faces):
        for a, b in _edges(face):
            sharing[min(a, b), max(a, b)].append(k)
    for (a, b), owners in sharing.items():
        if len(owners) > 2:
            ends = [np.round(vertices[i], 6).tolist() for i in (a, b)]
            raise InputError(
                name,
                f"the edge between vertices {a} and {b} ({ends[0]} to {ends[1]}) has "
                f"{len(owners)} faces: the mesh is not manifold",
                "remove the extra faces so that every edge has one or two",
            )
    directed = [set(_edges(face)) for face in faces]
    turn = [0] * len(faces)
    for seed in range(len(faces)):
        if turn[seed]:
            continue
        turn[seed], queue = 1, [seed]
        while queue:
            k = queue.pop()
            for a, b in _edges(faces[k]):
                for other in sharing[min(a, b), max(a, b)]:
                    if other == k:
                        continue
                    wanted = -turn[k] if (a, b) in directed[other] else turn[k]
                    if not turn[other]:
                        turn[other] = wanted
                        queue.append(other)
                    elif turn[other] != wanted:
                        raise InputError(
                            name,
                            f"the faces can't be turned to agree: at the edge between vertices {a} "
                            f"and {b} the surface is one-sided, like a Moebius band",
                            "cut it open along a line of edges",
                        )
    return [f if t > 0 else f[::-1] for f, t in zip(faces, turn, strict=True)]


def _check_sheets(name: str, mesh: Mesh) -> None:
    """Refuse vertices where two sheets touch: their faces do not form one fan."""
    spokes: dict[int, dict[int, int]] = defaultdict(dict)
    for face in mesh.faces:
        for k, corner in enumerate(face):
            spokes[corner][face[(k + 1) % len(face)]] = face[k - 1]
    for corner, fan in spokes.items():
        begins = set(fan) - set(fan.values())
        at = next(iter(begins)) if begins else next(iter(fan))
        seen = 0
        while at in fan and seen < len(fan):
            at = fan[at]
            seen += 1
        if seen != len(fan):
            where = np.round(mesh.vertices[corner], 6).tolist()
            raise InputError(
                name,
                f"two sheets touch at vertex {corner} {where} only: the boundary crosses itself",
                "separate the vertex or fill the gap",
            )


def _check_folds(name: str, mesh: Mesh) -> None:
    """Refuse vertices whose faces lie back on each other: there is no normal."""
    p, t = mesh.vertices, mesh.triangulated
    area = cross(p[t[:, 1]] - p[t[:, 0]], p[t[:, 2]] - p[t[:, 0]])
    total, sizes = np.zeros_like(p), np.zeros(len(p))
    for corner in t.T:
        np.add.at(total, corner, area)
        np.add.at(sizes, corner, np.linalg.norm(area, axis=1))
    folded = np.linalg.norm(total, axis=1) < LEAST_RISE * sizes
    if folded.any():
        at = int(np.argmax(folded))
        raise InputError(
            name,
            f"the faces around vertex {at} {np.round(p[at], 6).tolist()} fold back on each other",
            "move the vertex, or remove the faces that lie on others",
        )
