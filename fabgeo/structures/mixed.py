"""Strips attached to a quad mesh of beams (paper section 3, Fig. 7), and what models admit.

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

from fabgeo import spline
from fabgeo.arrays import Array, checked, cross, dot, unit
from fabgeo.errors import GeometryError
from fabgeo.strips.axes import axes
from fabgeo.strips.model import StripModel, check_model
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.beamline import Section
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
            span = float(layered.u[j]), float(layered.u[j + 1])
            a, b = layered.nodes[i, j], layered.nodes[i, j + 1]
            t = unit(b - a)
            na, nb = n[i, j], n[i, j + 1]
            torsion = abs(float(dot(cross(t, na), nb)))
            if torsion > 2e-3:
                raise GeometryError(
                    mark,
                    f"its two node axes are twisted by {np.degrees(torsion):.2g} deg against each "
                    "other: its web is not plane",
                    "cut shorter panels, on a conical or circular model",
                )
            side = unit(cross(t, na + nb))
            up = cross(side, t)
            web = [
                _along(x, v, up, level)
                for level in (levels["web_in"], levels["web_out"])
                for x, v in ((a, na), (b, nb))
            ]
            plates = [_straight(f"{mark}-WEB", mark, "web", web, section.web, section, span)]
            flanges: list[tuple[str, Role, str, float, float]] = [
                ("FLO", "flange_outer", "flange_out", section.width_outer, section.flange_outer),
                ("FLI", "flange_inner", "flange_in", section.width_inner, section.flange_inner),
            ]
            for name, role, key, width, t_f in flanges:
                if t_f > 0.0:
                    ends = [_along(x, v, up, levels[key]) for x, v in ((a, na), (b, nb))]
                    half = width / 2.0 * side
                    corners = [ends[0] - half, ends[1] - half, ends[0] + half, ends[1] + half]
                    plate = f"{mark}-{name}"
                    plates.append(_straight(plate, mark, role, corners, t_f, section, span))
            info = {
                "length": float(np.linalg.norm(b - a)),
                "camber": 0.0,
                "construction": "mesh",
                "depth_min": section.depth,
                "depth_max": section.depth,
            }
            made.append(Beam(mark, i, *span, tuple(plates), info))
    return made


def _along(node: Array, axis: Array, up: Array, level: float) -> Array:
    """The point of a node's axis at a level measured along `up` (so that bays stay straight)."""
    return node + level / float(dot(axis, up)) * axis


def _straight(
    mark: str,
    parent: str,
    role: Role,
    corners: list[Array],
    thickness: float,
    section: Section,
    span: tuple[float, float],
) -> Plate:
    s = (np.arange(4) / 3.0)[:, None]
    poles = np.stack(
        [corners[0] + s * (corners[1] - corners[0]), corners[2] + s * (corners[3] - corners[2])]
    )
    mid = RuledPatch(np.repeat(np.array(span), 4), poles)
    return Plate(mark, parent, role, mid, thickness, section.material)


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
    check_model("admits", model)
    try:
        field = axes(model)
    except GeometryError as refusal:
        why = "neighbouring strips have no common axis: no developable webs, no plane walls"
        if model.kind == "geodesic":
            why = "a geodesic model's bisector planes envelope no common axis strip"
        return Admits(True, False, False, False, "", f"{why} ({refusal.problem})")
    constant = "rulings and planes" if field.kind == "conical" else "vertices"
    return Admits(True, True, True, True, constant, "")
