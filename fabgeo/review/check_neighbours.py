"""Neighbouring panels measured between their solids: width of the joint, angle across it.

The figures stand in the report; what replacement adds to the fitted model's own kinks and gaps
can't be read off the files, so no verdict is given here.
"""

from __future__ import annotations

import numpy as np

from fabgeo.arrays import Array, cross, unit
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage


def check_neighbours(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """Note figures over all pairs of facing edges.

    joint_width_error_mm and edge_angle_max_deg are measured between the solids;
    shared_edge_error_mm is the difference of the flat lengths less that of the solids' edges.
    Edges face each other when their middles are less than three joints and 20 mm apart.
    """
    del findings
    panels = {row.get("mark", "") for row in package.tables["panels"]}
    edges = [
        (mark, number, edge, plate.centre)
        for mark, plate in measured.plates.items()
        if mark in panels
        for number, edge in enumerate(plate.edges)
    ]
    if len(edges) < 2:
        return
    from scipy.spatial import cKDTree

    joint = float(package.setting("panels", "joint", 0.0))
    middles = np.array([edge[len(edge) // 2] for _, _, edge, _ in edges])
    for i, j in sorted(cKDTree(middles).query_pairs(3.0 * joint + 20.0)):
        (one, k, a, centre_a), (two, m, b, centre_b) = edges[i], edges[j]
        if one == two:
            continue
        if one in measured.edge_errors and two in measured.edge_errors:
            error = measured.edge_errors[one][k] - measured.edge_errors[two][m]
            measured.worst("shared_edge_error_mm", abs(float(error)))
        inner = a[8:-8:8]
        width = _distances(inner, b)
        measured.worst("joint_width_error_mm", float(np.abs(width - joint).max()))
        angle = _angle(a, centre_a, b, centre_b)
        measured.worst("edge_angle_max_deg", float(np.degrees(angle)))


def _distances(points: Array, line: Array) -> Array:
    """Distances (k,) of points (k, 3) to a polyline (n, 3)."""
    start, step = line[:-1], np.diff(line, axis=0)
    away = points[:, None] - start
    t = np.clip(np.sum(away * step, axis=-1) / np.sum(step * step, axis=-1), 0.0, 1.0)
    return np.linalg.norm(away - t[..., None] * step, axis=-1).min(axis=1)


def _angle(a: Array, centre_a: Array, b: Array, centre_b: Array) -> float:
    """Angle between the planes of two panels at facing edges: each by its edge and its centre."""
    normals = []
    for edge, centre in ((a, centre_a), (b, centre_b)):
        middle = edge[len(edge) // 2]
        normals.append(unit(cross(edge[-1] - edge[0], centre - middle)))
    return float(np.arccos(np.clip(abs(float(normals[0] @ normals[1])), 0.0, 1.0)))
