"""Faces of a STEP file that are turned inside out, found in its text alone.

A kernel heals such a face while it reads; a shop's reader may not. A face's outer loop runs
counter-clockwise about its normal: the vector area of the loop's vertices must point the way that
the surface's normal and the face's sense say.
"""

from __future__ import annotations

import re

import numpy as np

from fabgeo.arrays import Array, cross

ENTITY = re.compile(r"#(\d+)\s*=\s*([A-Z0-9_]+)\s*\(([^;]*)\)\s*;", re.DOTALL)
REFERENCE = re.compile(r"#(\d+)")


class StepText:
    """Entities of a STEP file by number: their kind and their arguments as text."""

    def __init__(self, text: str) -> None:
        self.entities: dict[int, tuple[str, str]] = {}
        for found in ENTITY.finditer(text):
            self.entities[int(found[1])] = (found[2], found[3])

    def kind(self, number: int) -> str:
        """The kind of an entity; "" for one that is written another way."""
        return self.entities.get(number, ("", ""))[0]

    def references(self, number: int) -> list[int]:
        """Numbers that an entity refers to, in order."""
        return [int(n) for n in REFERENCE.findall(self.entities.get(number, ("", ""))[1])]

    def forward(self, number: int) -> bool:
        """The entity's last logical value."""
        return self.entities[number][1].rsplit(".", 2)[-2] == "T"

    def vector(self, number: int) -> Array:
        """Coordinates of a point or a direction."""
        numbers = self.entities[number][1].rsplit("(", 1)[1].rstrip(" )\r\n")
        return np.array([float(value) for value in numbers.split(",")])

    def of_kind(self, kind: str) -> list[int]:
        """Numbers of all entities of a kind."""
        return [n for n, (own, _) in self.entities.items() if own == kind]


def turned_faces(text: str) -> dict[str, int]:
    """Number of turned faces of a STEP text by product name; products without any are left out."""
    step = StepText(text)
    found: dict[str, int] = {}
    for representation in step.of_kind("ADVANCED_BREP_SHAPE_REPRESENTATION"):
        solids = [n for n in step.references(representation) if "BREP" in step.kind(n)]
        faces = [f for solid in solids for shell in step.references(solid)[:1]
                 for f in step.references(shell)]  # fmt: skip
        bad = sum(_is_turned(step, face) for face in faces)
        if bad:
            found[_product(step, representation)] = bad
    return found


def _is_turned(step: StepText, face: int) -> bool:
    """Whether loop and normal disagree; surfaces without a simple mean normal are passed over."""
    *bounds, surface = step.references(face)
    normal = _normal(step, surface)
    if normal is None:
        return False
    areas = [_vector_area(step, bound) for bound in bounds]
    area = max(areas, key=lambda vector: float(np.linalg.norm(vector)), default=np.zeros(3))
    size = float(np.linalg.norm(area) * np.linalg.norm(normal))
    cosine = float(area @ normal) / size if size > 0.0 else 0.0
    return cosine * (1.0 if step.forward(face) else -1.0) < -0.2


def _vector_area(step: StepText, bound: int) -> Array:
    """Newell's sum over the vertices of a loop, in the bound's sense."""
    corners = []
    for oriented in step.references(step.references(bound)[0]):
        edge = step.references(oriented)[0]
        first, second = step.references(edge)[:2]
        start = first if step.forward(oriented) else second
        corners.append(step.vector(step.references(start)[0]))
    points = np.array(corners)
    if len(points) < 3:
        return np.zeros(3)
    area = 0.5 * cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    return area if step.forward(bound) else -area


def _normal(step: StepText, surface: int) -> Array | None:
    kind = step.kind(surface)
    if kind == "PLANE":
        place = step.references(surface)[0]
        return step.vector(step.references(place)[1])
    if kind != "B_SPLINE_SURFACE_WITH_KNOTS":
        return None
    rows = re.findall(r"\((#[^()]*)\)", step.entities[surface][1])
    poles = np.array([[step.vector(int(n)) for n in REFERENCE.findall(row)] for row in rows])
    return cross((poles[-1] - poles[0]).sum(axis=0), (poles[:, -1] - poles[:, 0]).sum(axis=0))


def _product(step: StepText, representation: int) -> str:
    """Name of the product that a shape representation defines."""
    for definition in step.of_kind("SHAPE_DEFINITION_REPRESENTATION"):
        shape, own = step.references(definition)
        if own != representation:
            continue
        number = shape
        for _ in range(3):  # shape, definition, formation
            number = step.references(number)[0]
        words = re.match(r"\s*'((?:[^']|'')*)'", step.entities[number][1])
        return words[1] if words else f"#{number}"
    return f"#{representation}"
