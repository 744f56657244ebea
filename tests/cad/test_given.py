"""Surfaces that a script holds: the same points whatever they are given as."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import fabgeo
from fabgeo.errors import InputError


def bowl(x: Any, y: Any) -> Any:
    return 3000.0 - 4e-5 * x**2 - 1e-5 * y**2


def grid(nx: int = 9, ny: int = 11) -> NDArray[np.float64]:
    x, y = np.meshgrid(np.linspace(-3e3, 3e3, nx), np.linspace(-4e3, 4e3, ny), indexing="ij")
    return np.stack([x, y, bowl(x, y)], axis=-1)


def face() -> Any:
    b3d = pytest.importorskip("build123d")
    points = [[b3d.Vector(*p) for p in row] for row in grid()]
    return b3d.Face.make_surface_from_array_of_points(points, tol=1e-3)


def quads() -> tuple[NDArray[np.float64], list[list[int]]]:
    points = grid()
    rows, columns, _ = points.shape
    corners = [
        [i * columns + j, (i + 1) * columns + j, (i + 1) * columns + j + 1, i * columns + j + 1]
        for i in range(rows - 1)
        for j in range(columns - 1)
    ]
    return points.reshape(-1, 3), corners


def workplane() -> Any:
    cq = pytest.importorskip("cadquery", reason="needs the extra cadquery")
    return cq.Workplane(obj=cq.Face(face().wrapped))


@pytest.mark.parametrize("make", [face, grid, quads, workplane, lambda: face().wrapped])
def test_closest_points_lie_on_the_same_bowl(make: Any) -> None:
    surface = fabgeo.as_surface(make())
    found = surface.closest(grid(5, 5).reshape(-1, 3) + np.array([11.0, 7.0, 150.0]))
    x, y, z = found.point.T
    assert np.abs(z - bowl(x, y)).max() <= 0.05
    assert len(surface.loops) == 1


def test_a_unit_scales_and_design_surfaces_stay_as_they_are() -> None:
    surface = fabgeo.as_surface(grid() / 1000.0, unit="m")
    assert np.ptp(surface.bounds, axis=0)[:2] == pytest.approx([6000.0, 8000.0])
    assert fabgeo.as_surface(surface) is surface


@pytest.mark.parametrize("given", [42, np.zeros((4, 3)), [1, 2, 3]])
def test_what_is_no_surface_is_refused(given: Any) -> None:
    with pytest.raises(InputError, match="build123d"):
        fabgeo.as_surface(given)


def test_millimetres_are_not_metres() -> None:
    with pytest.raises(InputError, match="unit"):
        fabgeo.as_surface(grid() / 1e6)
