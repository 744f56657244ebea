"""Regular quad meshes as grids of vertices, and the smooth surface through such a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_interp_spline

from fabgeo.arrays import Array, IntArray, checked
from fabgeo.errors import InputError
from fabgeo.surfaces.bspline import BSplineChart
from fabgeo.surfaces.mesh import Mesh
from fabgeo.surfaces.parametric import ParametricSurface

SWING = 2.0  # times the extent of its points that a surface through them may have


@dataclass(frozen=True, eq=False)
class QuadGrid:
    """Vertex indices (rows, columns) of a regular quad mesh.

    Closed in a direction: the last row (column) is followed by the first, which isn't repeated.
    """

    index: IntArray
    closed_rows: bool
    closed_columns: bool


def quad_grid(mesh: Mesh) -> QuadGrid | None:
    """The grid of a mesh of quads; None if it has triangles, irregular vertices or holes."""
    if len(mesh.triangles) or not len(mesh.quads):
        return None
    walk = _Walk(mesh.quads)
    start = walk.start()
    lines: list[list[int]] = []
    line = walk.line(start) if start else None
    closed_columns = bool(line and line[-1][1] == line[0][0])
    closed_rows = False
    while line and len(lines) <= len(mesh.vertices):
        lines.append([a for a, _ in line] + ([] if closed_columns else [line[-1][1]]))
        across = [walk.across(*e) for e in line]
        inner = [(d, c) in walk.following for d, c in across]
        if not any(inner):
            far = [d for d, _ in across] + ([] if closed_columns else [across[-1][1]])
            lines.append(far)
            break
        if not all(inner):
            return None
        if across[0][0] == lines[0][0]:
            closed_rows = [d for d, _ in across] == lines[0][: len(across)]
            break
        line = across
    if not lines or len({len(x) for x in lines}) != 1:
        return None
    index = np.array(lines)
    rows, columns = index.shape
    quads = (rows if closed_rows else rows - 1) * (columns if closed_columns else columns - 1)
    whole = len(np.unique(index)) == index.size == len(mesh.vertices)
    return (
        QuadGrid(index, closed_rows, closed_columns) if whole and quads == len(mesh.quads) else None
    )


class _Walk:
    """Straight lines of edges over quads, by directed edges with their face on the left."""

    def __init__(self, quads: IntArray) -> None:
        self.following: dict[tuple[int, int], int] = {}  # (a, b) -> the corner after b
        self.faces_at: dict[int, int] = {}
        for face in quads.tolist():
            for k in range(4):
                self.following[face[k], face[(k + 1) % 4]] = face[(k + 2) % 4]
                self.faces_at[face[k]] = self.faces_at.get(face[k], 0) + 1

    def start(self) -> tuple[int, int] | None:
        """A boundary edge that leaves a corner; else any boundary edge; else any edge."""
        boundary = [e for e in self.following if (e[1], e[0]) not in self.following]
        corners = [e for e in boundary if self.faces_at[e[0]] == 1]
        return min(corners or boundary or list(self.following), default=None)

    def line(self, edge: tuple[int, int]) -> list[tuple[int, int]]:
        """Directed edges straight on from `edge`, until the boundary or back at the start."""
        line = [edge]
        a, b = edge
        while True:
            c = self.following[a, b]
            if (c, b) not in self.following:
                return line
            a, b = b, self.following[c, b]
            if (a, b) == edge or (a, b) not in self.following or len(line) > len(self.following):
                return line
            line.append((a, b))

    def across(self, a: int, b: int) -> tuple[int, int]:
        """The opposite edge of the quad on the left of (a, b), in the same direction."""
        c = self.following[a, b]
        return self.following[b, c], c


class GridSurface(ParametricSurface):
    """The bicubic B-spline surface through a grid of points: C2, exact at every point.

    Parameters are the mean chord lengths of the rows and of the columns; open directions end with
    the not-a-knot condition, closed ones are periodic. Directions with two or three points get
    degree one or two.

    Parameters
    ----------
    points : (rows, columns, 3) array
    closed_rows, closed_columns : bool
        The last row (column) is followed by the first, which isn't repeated.
    name : str
    mesh : Mesh, optional
        The mesh it came from.

    Raises
    ------
    InputError
        If the grid is too small, or so uneven that its surface swings far out between the points.
    """

    def __init__(
        self,
        points: Array,
        closed_rows: bool = False,
        closed_columns: bool = False,
        name: str = "grid",
        mesh: Mesh | None = None,
    ) -> None:
        self.grid = checked("grid", points, (None, None, 3))
        self.grid_closed = self.closed_i, self.closed_j = closed_rows, closed_columns
        self.mesh = mesh
        least = [3 if c else 2 for c in self.grid_closed]
        if self.grid.shape[0] < least[0] or self.grid.shape[1] < least[1]:
            raise InputError(name, f"a grid of {self.grid.shape[:2]} points is too small")
        chart = interpolating_chart(self.grid, closed_rows, closed_columns)
        super().__init__(name, [chart])
        extent = float(np.linalg.norm(np.ptp(self.grid.reshape(-1, 3), axis=0)))
        if self.size > SWING * extent:
            raise InputError(
                name,
                f"the smooth surface through its {extent:.4g} mm wide grid swings out to "
                f"{self.size:.4g} mm: the lines of the grid are too uneven",
                "look for points far off the others, or give triangles",
            )


def interpolating_chart(
    points: Array,
    closed_rows: bool,
    closed_columns: bool,
    rows: Array | None = None,
    columns: Array | None = None,
) -> BSplineChart:
    """The bicubic chart through points (rows, columns, 3), u along the rows' index.

    Parameters
    ----------
    rows, columns : arrays, optional
        Parameter values, one more than points where closed; default mean chord lengths.
    """
    along = _chords(points, closed_rows) if rows is None else rows
    across = _chords(np.swapaxes(points, 0, 1), closed_columns) if columns is None else columns
    knots_u, first, degree_u = _interpolate(along, points, closed_rows)
    knots_v, poles, degree_v = _interpolate(across, np.swapaxes(first, 0, 1), closed_columns)
    closed = (closed_rows, closed_columns)
    return BSplineChart(
        np.swapaxes(poles, 0, 1), knots_u, knots_v, degree_u, degree_v, None, closed
    )


def _chords(points: Array, closed: bool) -> Array:
    """Mean accumulated distances along the first axis."""
    steps = np.diff(points, axis=0, append=points[:1]) if closed else np.diff(points, axis=0)
    mean = np.linalg.norm(steps, axis=-1).mean(axis=1)
    if not (mean > 0.0).all():
        raise InputError("grid", "two neighbouring lines of the grid coincide", "remove one")
    return np.concatenate([[0.0], np.cumsum(mean)])


def _interpolate(at: Array, points: Array, closed: bool) -> tuple[Array, Array, int]:
    """Knots, coefficients and degree of the spline through points along the first axis."""
    if closed:
        points = np.concatenate([points, points[:1]])
        if len(points) < 5:  # too few for the periodic cubic: pass them twice, take one turn
            turns = np.concatenate([points[:-1], points[:-1], points])
            period = at[-1]
            at = np.concatenate([at[:-1] - period, at[:-1], at + period])
            spline = make_interp_spline(at, turns, 3, bc_type="periodic")
            inner = spline.t
            first = int(np.searchsorted(inner, 0.0))
            count = len(points) - 1
            keep = slice(first - 3, first + count + 4)
            return inner[keep], spline.c[first - 3 : first + count], 3
        spline = make_interp_spline(at, points, 3, bc_type="periodic")
        return spline.t, spline.c, 3
    degree = min(3, len(points) - 1)
    spline = make_interp_spline(at, points, degree)
    return spline.t, spline.c, degree
