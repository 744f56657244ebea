"""The second judge: solids measured from the STEP text alone, without any CAD kernel.

It shares no code with the writer: every boundary is walked along its 3D curves, every curve point
is looked up on the face's surface (the gap), and the volume is a boundary integral.

Glossary
--------
paired
    Every edge of a shell is used exactly twice, once in each sense: the shell is closed.
gap
    Largest distance of a boundary's points from the face's surface, and of vertices from the
    ends of their edges.
genus
    Number of through holes, from Euler's V - E + F - R = 2 (1 - genus), R inner loops.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fabgeo.arrays import Array, dot
from fabgeo.cad.part21 import Entities
from fabgeo.cad.steptree import Occurrence, product_tree
from fabgeo.cad.textcurves import Curve, curve_of, point_of
from fabgeo.cad.textsurfaces import surface_of
from fabgeo.errors import InputError

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)


@dataclass(frozen=True)
class TextSolid:
    """One solid of the file, in its product's own coordinates.

    Attributes
    ----------
    product : str
        Name of its product.
    entity : int
        Number of its MANIFOLD_SOLID_BREP.
    vertices, edges, faces, inner_loops : int
    paired : bool
    genus : float
        Through holes; not a whole number if the topology is broken.
    gap : float
        mm.
    volume : float
        mm3, positive if the shell is oriented outwards.
    surfaces : dict
        Number of faces on each kind of surface, by the entity's name.
    """

    product: str
    entity: int
    vertices: int
    edges: int
    faces: int
    inner_loops: int
    paired: bool
    genus: float
    gap: float
    volume: float
    surfaces: dict[str, int]

    @property
    def sound(self) -> bool:
        """Closed, of whole genus and positive volume, and no gap beyond 1e-3 mm."""
        whole = self.genus >= 0.0 and self.genus == round(self.genus)
        return self.paired and whole and self.volume > 0.0 and self.gap <= 1e-3


@dataclass(frozen=True)
class StepText:
    """What a STEP text holds: its solids by product and its product tree.

    Attributes
    ----------
    schema : str
        The header's schema.
    solids : tuple of TextSolid
        Each once, however often its product is placed.
    tree : Occurrence
        The root of the product tree.
    """

    schema: str
    solids: tuple[TextSolid, ...]
    tree: Occurrence

    def parts(self) -> list[tuple[Occurrence, TextSolid]]:
        """Every placed part that holds a solid, with that solid."""
        known: dict[int, list[TextSolid]] = {}
        for solid in self.solids:
            known.setdefault(solid.entity, []).append(solid)
        return [
            (leaf, solid)
            for leaf in self.tree.leaves()
            for entity in leaf.solids
            for solid in known[entity]
        ]


def read_step_text(path: str | os.PathLike[str]) -> StepText:
    """Read and measure a STEP file of planes, cylinders, cones and B-splines, without a kernel.

    Raises
    ------
    InputError
        If the file is no STEP file or holds curves or surfaces of other kinds.
    """
    file = Entities.read(path)
    tree = product_tree(file)
    owners = {entity: leaf.product for leaf in tree.leaves() for entity in leaf.solids}
    solids = tuple(
        _Solid(file, number).measured(owners.get(number, ""))
        for number in file.of_kind("MANIFOLD_SOLID_BREP")
    )
    schema = file.header.split("FILE_SCHEMA", 1)[-1].strip(" (\n'").split("'", 1)[0]
    return StepText(schema.strip(), solids, tree)


@dataclass(frozen=True)
class _Walk:
    """Quadrature points of an edge along its own sense: points, tangents times weights."""

    points: Array
    steps: Array
    start: int
    end: int
    gap: float


class _Solid:
    def __init__(self, file: Entities, number: int) -> None:
        self.file, self.number = file, number
        self.walks: dict[int, _Walk] = {}
        self.uses: Counter[int] = Counter()
        self.senses: Counter[int] = Counter()
        self.surfaces: Counter[str] = Counter()
        self.gap = 0.0
        self.loops = 0
        self.about = np.zeros(3)

    def measured(self, product: str) -> TextSolid:
        shell = self.file.arguments(self.number)[1]
        faces = self.file.arguments(shell)[1]
        self.about = self._some_point(faces[0])  # near by, so that small volumes keep digits
        volume = sum(self._face(face) for face in faces) / 3.0
        corners = {v for walk in self.walks.values() for v in (walk.start, walk.end)}
        inner = self.loops - len(faces)
        euler = len(corners) - len(self.walks) + len(faces) - inner
        return TextSolid(
            product=product,
            entity=self.number,
            vertices=len(corners),
            edges=len(self.walks),
            faces=len(faces),
            inner_loops=inner,
            paired=all(self.uses[e] == 2 and self.senses[e] == 0 for e in self.walks),
            genus=1.0 - euler / 2.0,
            gap=max([self.gap, *(walk.gap for walk in self.walks.values())]),
            volume=float(volume),
            surfaces=dict(self.surfaces),
        )

    def _face(self, number: int) -> float:
        """Three times the volume between a face and the origin; counts its boundary's edges."""
        _, bounds, geometry, _ = self.file.arguments(number)
        kind = self.file.kind(geometry)
        self.surfaces[kind.split("+")[0]] += 1
        surface = surface_of(self.file, geometry)
        points, steps = [], []
        for bound in bounds:
            self.loops += 1
            for edge, sign in self._uses(bound):
                walk = self._walk(edge)
                self.uses[edge] += 1
                self.senses[edge] += sign
                points.append(walk.points)
                steps.append(sign * walk.steps)
        if not points:
            raise InputError(f"{self.file.where}, #{number}", "is a face without edges")
        x, dx = np.concatenate(points), np.concatenate(steps)
        uv = surface.parameters(x)
        on, xu, xv = surface.at(uv)
        self.gap = max(self.gap, float(np.linalg.norm(x - on, axis=1).max()))
        # du from dx = x_u du + x_v dv.
        a, b, c = dot(xu, xu), dot(xu, xv), dot(xv, xv)
        du = (c * dot(dx, xu) - b * dot(dx, xv)) / (a * c - b * b)
        return -float(surface.moment(uv, self.about) @ du)

    def _some_point(self, face: int) -> Array:
        edge, _ = next(self._uses(self.file.arguments(face)[1][0]))
        return point_of(self.file, self.file.arguments(edge)[1])

    def _uses(self, bound: int) -> Iterator[tuple[int, int]]:
        _, loop, forward = self.file.arguments(bound)
        if self.file.kind(loop) != "EDGE_LOOP":
            return
        edges = self.file.arguments(loop)[1]
        for oriented in edges if forward == "T" else edges[::-1]:
            _, _, _, edge, sense = self.file.arguments(oriented)
            yield edge, 1 if (sense == "T") == (forward == "T") else -1

    def _walk(self, number: int) -> _Walk:
        known = self.walks.get(number)
        if known is not None:
            return known
        _, start, end, geometry, same = self.file.arguments(number)
        ends = [point_of(self.file, v) for v in (start, end)]
        curve = curve_of(self.file, geometry)
        first, last = ends if same == "T" else ends[::-1]
        points, steps, gap = _quadrature(curve, first, last)
        walk = _Walk(points, steps if same == "T" else -steps, int(start), int(end), gap)
        self.walks[number] = walk
        return walk


def _quadrature(curve: Curve, start: Array, end: Array) -> tuple[Array, Array, float]:
    """Gauss points of a curve, tangent times weight there, and how far its ends miss."""
    breaks = curve.breaks(start, end)
    half = np.diff(breaks)[:, None] / 2.0
    t = (breaks[:-1, None] + half * (_NODES + 1.0)).ravel()
    points, slopes = curve.at(t)
    ends, _ = curve.at(breaks[[0, -1]])
    gap = float(max(np.linalg.norm(ends[0] - start), np.linalg.norm(ends[1] - end)))
    return points, slopes * (half * _WEIGHTS).reshape(-1, 1), gap


__all__ = ["Occurrence", "StepText", "TextSolid", "read_step_text"]
