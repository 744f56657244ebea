"""Flat parts and curves that the tests of this room share."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from fabgeo.arrays import Array
from fabgeo.panels.flat import BendLine, FlatEdge, FlatHole, FlatPart
from fabgeo.panels.unfold import flat_polygon

type Curve = Callable[[Array], Array]


def stack(*xy: Array | float) -> Array:
    return np.stack(np.broadcast_arrays(*xy), axis=-1)


def edge_of(curve: Curve, speed: Curve, count: int = 49, name: str = "first") -> FlatEdge:
    t = np.linspace(0.0, 1.0, count)
    x, w = np.polynomial.legendre.leggauss(12)
    nodes = t[:-1, None] + np.diff(t)[:, None] * (x + 1) / 2
    fast = np.linalg.norm(speed(nodes.ravel()), axis=-1).reshape(nodes.shape)
    arc = np.append(0.0, np.cumsum(fast @ w * np.diff(t) / 2))
    way = speed(t)
    return FlatEdge(name, curve(t), way / np.linalg.norm(way, axis=-1)[:, None], arc)


CURVES: dict[str, tuple[Curve, Curve]] = {
    "parabola": (lambda t: stack(2000 * t, 100 * t * t), lambda t: stack(2000.0, 200 * t)),
    "strong parabola": (lambda t: stack(2000 * t, 600 * t * t), lambda t: stack(2000.0, 1200 * t)),
    "half wave": (
        lambda t: stack(1500 * t, 100 * np.sin(3 * t)),
        lambda t: stack(1500.0, 300 * np.cos(3 * t)),
    ),
    "two waves": (
        lambda t: stack(3000 * t, 80 * np.sin(9 * t)),
        lambda t: stack(3000.0, 720 * np.cos(9 * t)),
    ),
    "s": (
        lambda t: stack(2000 * t, 300 * (t - 0.5) ** 3),
        lambda t: stack(2000.0, 900 * (t - 0.5) ** 2),
    ),
    "circle": (
        lambda t: stack(2000 * np.cos(t), 2000 * np.sin(t)),
        lambda t: stack(-2000 * np.sin(t), 2000 * np.cos(t)),
    ),
    "spiral": (
        lambda t: stack((1000 + 400 * t) * np.cos(1.5 * t), (1000 + 400 * t) * np.sin(1.5 * t)),
        lambda t: stack(
            400 * np.cos(1.5 * t) - 1.5 * (1000 + 400 * t) * np.sin(1.5 * t),
            400 * np.sin(1.5 * t) + 1.5 * (1000 + 400 * t) * np.cos(1.5 * t),
        ),
    ),
}


def wavy_part(mark: str = "P-00-00", material: str = "al") -> FlatPart:
    """1500 x 700 with one curved edge, a round hole, a slot and a bend line."""
    curve, speed = CURVES["half wave"]
    bottom = edge_of(curve, speed)
    p, q = bottom.points[0], bottom.points[-1]
    rest = flat_polygon("x", "y", 1.0, np.array([p, q, [1500.0, 700.0], [0.0, 700.0]])).outline[1:]
    holes = (
        FlatHole(np.array([300.0, 400.0]), 18.0),
        FlatHole(np.array([1100.0, 500.0]), 14.0, 20.0, 0.3),
    )
    bends = (BendLine(np.array([500.0, 100.0]), np.array([500.0, 700.0]), -3000.0),)
    area = 1500.0 * 700.0 - 1500.0 * 100.0 * (1 - np.cos(3.0)) / 3.0
    area -= np.pi * (18.0**2 + 14.0**2) / 4 + 14.0 * 20.0
    return FlatPart(mark, material, 3.0, (bottom, *rest), holes, bends, area=area, grain="along")


def shared_panels(folder: Path, count: int) -> list[FlatPart]:
    """The first panels of the shared nesting instance."""
    data = json.loads((folder / "nesting" / "panels-200.json").read_text())
    return [
        flat_polygon(f"P-{k:03d}", "al", 3.0, np.array(points), grain="along")
        for k, points in enumerate(data["parts"][:count])
    ]


def shared_strip(folder: Path, name: str) -> tuple[list[FlatPart], float]:
    """A published strip-packing instance: all copies of its items, and the strip's width."""
    data = json.loads((folder / "nesting" / f"{name}.json").read_text())
    parts = []
    grains = {(0.0, 180.0): "along", (0.0, 90.0, 180.0, 270.0): "steps"}
    for item in data["items"]:
        points, grain = np.array(item["shape"]["data"]), grains[tuple(item["allowed_orientations"])]
        if np.allclose(points[0], points[-1]):
            points = points[:-1]
        for copy in range(item["demand"]):
            parts.append(flat_polygon(f"{item['id']}.{copy}", "cloth", 1.0, points, grain=grain))
    return parts, float(data["strip_height"])
