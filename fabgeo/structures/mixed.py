"""Structures of two layers (paper section 3, Fig. 7): quad mesh with strips, crossed strips.

Glossary
--------
node
    A vertex of the quad mesh, shared with the strip model: edge curve i passes through the nodes
    (i, j) at given parameters.
gap
    Distance between the layers: from the straight mesh edge to the strip model's curve above it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from fabgeo import spline
from fabgeo.arrays import Array, BoolArray, IntArray, checked, cross, dot, unit
from fabgeo.errors import GeometryError
from fabgeo.strips.axes import axes
from fabgeo.strips.distances import project
from fabgeo.strips.frames import frames
from fabgeo.strips.model import StripModel
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.beams import BeamRule, Section, beams
from fabgeo.structures.parts import Beam, Plate, Role


@dataclass(frozen=True)
class Layered:
    """A quad mesh that carries beams, and a strip model attached to it at shared nodes.

    Attributes
    ----------
    nodes : (edges, k, 3) array
        Mesh vertices: row i lies on edge curve i at parameters `u`.
    u : (k,) array
    planarity : float
        Largest distance of the diagonals of a mesh face, mm (a developable strip whose end
        rulings are parallel to no plane leaves quads off plane).
    gap_max, gap_rms : float
        Distance between the mesh and the strip model, mm, measured densely along edge curves.
    gap_at : (int, float)
        Edge and parameter of the largest gap.
    node_error : float
        Distance between nodes and edge curves, mm.
    """

    nodes: Array
    u: Array
    planarity: float
    gap_max: float
    gap_rms: float
    gap_at: tuple[int, float]
    node_error: float


def attach(model: StripModel, u: Sequence[float] | Array) -> Layered:
    """The quad mesh on a strip model's ruling polygons at parameters u, and the layers' distance.

    Mesh rows run along the edge curves, columns along the ruling polygons u = const.
    """
    u = np.asarray(u, dtype=np.float64)
    if len(u) < 2 or np.any(np.diff(u) <= 0.0):
        raise GeometryError("attach", "expected two or more ascending parameters")
    return _layered(model, model.points(u), u)


def strips_on_mesh(nodes: Array, closed_i: bool = False) -> tuple[StripModel, Layered]:
    """The strip model whose edge curves interpolate a quad mesh's rows, and the layers' distance.

    One subdivision direction carries the panels: strips run along the mesh's rows (axis 1). The
    model interpolates the nodes; it is as developable as the mesh is planar and fine (measure it,
    and fit it with the nodes as mounting points where that isn't enough).

    Parameters
    ----------
    nodes : (edges, k, 3) array, k >= 4
    """
    nodes = checked("nodes", nodes, ("edges", "k", 3))
    model = StripModel(spline.interpolate(nodes), closed_i=closed_i)
    return model, _layered(model, nodes, np.arange(nodes.shape[1], dtype=np.float64))


def _layered(model: StripModel, nodes: Array, u: Array) -> Layered:
    fine = np.linspace(0.0, 1.0, 17)[1:-1]
    sites = (u[:-1, None] + fine * np.diff(u)[:, None]).ravel()
    x = model.points(sites).reshape(len(nodes), len(u) - 1, len(fine), 3)
    a, b = nodes[:, :-1], nodes[:, 1:]
    along = unit(b - a)[:, :, None]
    off = x - a[:, :, None]
    gap = np.linalg.norm(off - dot(off, along)[..., None] * along, axis=-1)
    row, cell, at = np.unravel_index(int(np.argmax(gap)), gap.shape)
    first, second = model.pairs(nodes)
    p, q, r, s = first[:, :-1], first[:, 1:], second[:, 1:], second[:, :-1]
    normal = unit(cross(r - p, s - q))
    return Layered(
        nodes=nodes,
        u=u,
        planarity=float(np.abs(dot(q - p, normal)).max()),
        gap_max=float(gap.max()),
        gap_rms=float(np.sqrt(np.mean(gap**2))),
        gap_at=(int(row), float(sites.reshape(len(u) - 1, -1)[cell, at])),
        node_error=float(np.linalg.norm(model.points(u) - nodes, axis=-1).max()),
    )


def mesh_beams(
    layered: Layered, normals: Array, section: Section, edges: Sequence[int] | None = None
) -> list[Beam]:
    """Straight beams along a mesh's rows: a plane web between two node axes, and flanges.

    The web of a bay is plane only if both node axes lie in one plane with the bay (torsion-free
    nodes, as the axes of conical and circular models are); otherwise the bay is refused.

    Parameters
    ----------
    normals : (edges, k, 3) array
        Node axes, e.g. ``axes(model)(layered.u)``.
    """
    levels = section.levels()
    n = unit(normals)
    made = []
    for i in range(len(layered.nodes)) if edges is None else edges:
        for j in range(layered.nodes.shape[1] - 1):
            mark = f"B-{i:02d}-{j + 1}"
            a, b = layered.nodes[i, j], layered.nodes[i, j + 1]
            t = unit(b - a)
            na, nb = n[i, j], n[i, j + 1]
            torsion = abs(float(dot(cross(t, na), nb)))
            if torsion > 2e-3:
                raise GeometryError(
                    mark,
                    f"its two node axes are twisted by {np.degrees(torsion):.2g} deg against each "
                    "other: its web is not plane",
                    "take the axes of a conical or circular model",
                )
            side = unit(cross(t, na + nb))
            up = cross(side, t)
            web = [
                _along(x, v, up, level)
                for level in (levels["web_in"], levels["web_out"])
                for x, v in ((a, na), (b, nb))
            ]
            plates = [_straight(f"{mark}-WEB", mark, "web", web, section.web, section)]
            flanges: list[tuple[str, Role, str, float, float]] = [
                ("FLO", "flange_outer", "flange_out", section.width_outer, section.flange_outer),
                ("FLI", "flange_inner", "flange_in", section.width_inner, section.flange_inner),
            ]
            for name, role, key, width, t_f in flanges:
                if t_f > 0.0:
                    ends = [_along(x, v, up, levels[key]) for x, v in ((a, na), (b, nb))]
                    half = width / 2.0 * side
                    corners = [ends[0] - half, ends[1] - half, ends[0] + half, ends[1] + half]
                    plates.append(_straight(f"{mark}-{name}", mark, role, corners, t_f, section))
            info = {"length": float(np.linalg.norm(b - a)), "camber": 0.0, "construction": "mesh"}
            made.append(
                Beam(mark, i, float(layered.u[j]), float(layered.u[j + 1]), tuple(plates), info)
            )
    return made


def _along(node: Array, axis: Array, up: Array, level: float) -> Array:
    """The point of a node's axis at a level measured along `up` (so that bays stay straight)."""
    return node + level / float(dot(axis, up)) * axis


def _straight(
    mark: str, parent: str, role: Role, corners: list[Array], thickness: float, section: Section
) -> Plate:
    s = (np.arange(4) / 3.0)[:, None]
    poles = np.stack(
        [corners[0] + s * (corners[1] - corners[0]), corners[2] + s * (corners[3] - corners[2])]
    )
    mid = RuledPatch(np.array([0.0] * 4 + [1.0] * 4), poles)
    return Plate(mark, parent, role, mid, thickness, section.material)


@dataclass(frozen=True)
class Crossed:
    """Two strip models crossed: beams of both, and how well they match.

    Attributes
    ----------
    outer, inner : list of Beam
    angle_min_deg : float
        Least angle between an edge of one and the nearest edge of the other: 90 where they
        cross squarely.
    gap_min, gap_max : float
        Distance between the two models, measured at samples of the outer one, mm.
    """

    outer: list[Beam]
    inner: list[Beam]
    angle_min_deg: float
    gap_min: float
    gap_max: float


def crossed(
    outer: StripModel,
    inner: StripModel,
    sections: tuple[Section, Section],
    rule: BeamRule | None = None,
) -> Crossed:
    """Beams of two crossed strip models, the smooth direction of one along the strips of the other.

    Raises
    ------
    GeometryError
        If a model admits no beams, or their edges run along rather than across each other.
    """
    f, g = frames(outer, outer.parameters(4)), frames(inner, inner.parameters(4))
    p0, p1 = g.sides(g.p)
    _, near = KDTree(((p0 + p1) / 2.0).reshape(-1, 3)).query(f.p.reshape(-1, 3))
    strip, column = np.divmod(near, len(g.u))
    p = f.p.reshape(-1, 3)
    gap, u, v = project(inner, p, strip, g.u[column], np.full(len(p), 0.5))
    over = _inside(inner, strip, u, v)
    if not over.any():
        raise GeometryError("crossed models", "don't lie over each other", "move one of them")
    s = _directions(inner, strip, u, v)
    angle = np.degrees(np.arccos(np.minimum(np.abs(dot(f.t.reshape(-1, 3), s)), 1.0)))
    angle = np.where(over, angle, 90.0)
    at = int(np.argmin(angle))
    if angle[at] < 30.0:
        edge, column = divmod(at, len(f.u))
        raise GeometryError(
            f"crossed models, outer edge {edge} at u = {f.u[column]:.3g}",
            f"edges of both models meet at {angle[at]:.1f} deg; expected 30 deg or more",
            "let the strips of one model run across those of the other",
        )
    gap = gap[over]
    return Crossed(
        beams(outer, sections[0], rule),
        beams(inner, sections[1], rule),
        float(angle.min()),
        float(gap.min()),
        float(gap.max()),
    )


def _inside(model: StripModel, strip: IntArray, u: Array, v: Array) -> BoolArray:
    """Which feet lie within the model, not on its free boundary."""
    inside = np.ones(len(u), dtype=bool)
    if not model.closed_u:
        inside &= (u > 0.0) & (u < model.segments)
    if not model.closed_i:
        inside &= ~((strip == 0) & (v <= 0.0)) & ~((strip == model.strips - 1) & (v >= 1.0))
    return inside


def _directions(model: StripModel, strip: IntArray, u: Array, v: Array) -> Array:
    """Unit u-directions of the model at strips, u, v (k,): the edges' direction there."""
    rows = np.arange(len(u))
    d0, d1 = model.pairs(model.points(u, 1))
    d0, d1 = d0[strip, rows], d1[strip, rows]
    return unit(d0 + v[:, None] * (d1 - d0))


@dataclass(frozen=True)
class Admits:
    """Which structures a model admits; a missing one has its reason."""

    panels: bool
    offsets: bool
    cells: bool
    beams: bool
    constant: str
    reason: str


def admits(model: StripModel) -> Admits:
    """What can be built on a model, by its measured properties.

    Conical: offsets at constant distance of rulings and planes, cells with plane walls, beams.
    Circular: offsets at constant distance of vertices, cells, beams. Geodesic and general models
    have no common axes of neighbouring strips: panels only.
    """
    try:
        field = axes(model)
    except GeometryError as refusal:
        why = "neighbouring strips have no common axis: no developable webs, no plane walls"
        if model.kind == "geodesic":
            why = "a geodesic model's bisector planes envelope no common axis strip"
        return Admits(True, False, False, False, "", f"{why} ({refusal.problem})")
    constant = "rulings and planes" if field.kind == "conical" else "vertices"
    return Admits(True, True, True, True, constant, "")
