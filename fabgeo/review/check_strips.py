"""Panels against strips.json: they lie on the fitted strips, as far off as their rows state.

Glossary
--------
foot
    The nearest point of the strips; it counts where it lies within a strip, not on its outline.
"""

from __future__ import annotations

from itertools import chain, count, takewhile
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from fabgeo.arrays import Array
from fabgeo.errors import FabgeoError
from fabgeo.review.findings import Findings
from fabgeo.review.measured import Measured
from fabgeo.review.package import WrittenPackage, number

if TYPE_CHECKING:
    from fabgeo.strips.model import StripModel

type BoolArray = npt.NDArray[np.bool_]

NAME = "strips.json"
AWAY, SHARE = 0.05, 0.1  # mm, and of the stated deviation: 400 panels were 0.035 of it off at most
FEW = 2  # panels off their strips: with more of them, it is the strips that lie elsewhere
PLACES = 7  # along a panel
ACROSS = np.array([0.1, 0.5, 0.9])  # its long edges may reach beyond the strip where it is offset
DRAWN = 0.75, 30.0  # mm: what lies nearer an edge ends at a boundary, what lies farther at a lane
CELLS, FACES = 40, 60  # cells that tell the depth, and points on their inner faces at least
DEPTH = 0.1  # mm: of half of the points 1e-3 at most
JOINT = 0.5  # mm, beside half the stated gap: drawings-back of 2,966 edges were 0.4 of that off


def check_strips(package: WrittenPackage, measured: Measured, findings: Findings) -> None:
    """The strips' kind, how far panels are from the strips, and from the edges between these."""
    from fabgeo.fitting.store import load_model

    try:
        models = [load_model(package.folder / name) for name in model_names(package)]
    except FabgeoError:
        return  # `check_model` says so
    kind = package.setting("strips", "kind", None)
    for name, model in zip(model_names(package), models, strict=True):
        if kind is not None and model.kind != kind:
            findings.add(name, "kind", kind, model.kind)
    if len(models) == 1 and NAME not in {found.part for found in findings.items}:
        _deep(package, models[0], measured, findings)
    rows = {row.get("mark", ""): row for row in package.tables["panels"]}
    rails = {mark: measured.plates[mark].rails() for mark in rows if mark in measured.plates}
    known = {mark: pair for mark, pair in rails.items() if pair is not None}
    if not models or not known:
        return
    height = abs(float(package.setting("panels", "offset", 0.0)))
    off: dict[str, float] = {}
    for mark, distances in zip(known, _away(models, list(known.values())), strict=True):
        stated = number(rows[mark], "fit_deviation_mm")
        most = float(np.abs(distances - height).max()) if len(distances) else np.inf
        if stated is not None and not most <= stated + AWAY + SHARE * abs(stated):
            off[mark] = most
    alone = len(models) == 1 and not height
    if not (alone and _beside_edges(package, models[0], known, findings)):
        _report(rows, off, findings)


def model_names(package: WrittenPackage) -> list[str]:
    """The files of the model, or of models side by side, as far as they are there."""
    further = (f"strips-{k}.json" for k in count(2))
    return list(takewhile(lambda name: (package.folder / name).is_file(), chain([NAME], further)))


def _away(models: list[StripModel], rails: list[tuple[Array, Array]]) -> list[Array]:
    """Of every panel the distances of its places from the nearest model, those that count."""
    places = np.array([_places(*pair) for pair in rails])
    points = places.reshape(-1, 3)
    nearest = np.full(len(points), np.inf)
    counts = np.zeros(len(points), dtype=bool)
    for model in models:
        distance, within = _feet(model, points)
        nearer = distance < nearest
        nearest, counts = np.where(nearer, distance, nearest), np.where(nearer, within, counts)
    return [
        own[inside]
        for own, inside in zip(
            nearest.reshape(places.shape[:2]), counts.reshape(places.shape[:2]), strict=True
        )
    ]


def _places(a: Array, b: Array) -> Array:
    """Points (n, 3) of a panel's mid-surface."""
    at = np.linspace(0, len(a) - 1, PLACES).round().astype(int)
    v = ACROSS[:, None, None]
    return ((1.0 - v) * a[at] + v * b[at]).reshape(-1, 3)


def _deep(
    package: WrittenPackage, model: StripModel, measured: Measured, findings: Findings
) -> None:
    """Cells of a conical model reach as deep below its strips as the project says.

    Their inner faces are the strips' own, offset; above a fold inner corners have no foot.
    """
    asked = abs(float(package.setting("cells", "depth", 0.0)))
    marks = sorted(measured.cells)
    if model.kind != "conical" or not asked or not marks:
        return
    some = np.unique(np.linspace(0, len(marks) - 1, CELLS).round().astype(int)).tolist()
    distance, within = _feet(model, np.concatenate([measured.cells[marks[k]] for k in some]))
    deep = distance[within & (distance > 0.5 * float(distance.max(initial=0.0)))]
    found = float(np.median(deep)) if len(deep) >= FACES else asked
    if not abs(found - asked) <= DEPTH:
        findings.add("manifest.json", "cells.depth of the cells", found, asked)


def _feet(model: StripModel, points: Array) -> tuple[Array, BoolArray]:
    """Distances of points (k,) from the strips, and whether their feet count."""
    from scipy.spatial import KDTree

    from fabgeo.strips.distances import project

    u, v = model.parameters(8), np.linspace(0.0, 1.0, 9)
    first, second = model.pairs(model.points(u))
    grid = first[:, None] + v[:, None, None] * (second - first)[:, None]
    _, nearest = KDTree(grid.reshape(-1, 3)).query(points)
    strip, row, column = np.array(np.unravel_index(nearest, grid.shape[:3]))
    distance, u_there, v_there = project(model, points, strip, u[column], v[row])
    within = (v_there > 0.0) & (v_there < 1.0)
    if not model.closed_u:
        within &= (u_there > 0.0) & (u_there < model.segments)
    return distance, within


def _report(rows: dict[str, dict[str, str]], off: dict[str, float], findings: Findings) -> None:
    """Names the panels that lie elsewhere, or the strips where many do, or their figures differ.

    A panel that is wrong by itself was mostly named before, and is not named again.
    """
    named = {found.part for found in findings.items}
    rest = {mark: most for mark, most in off.items() if mark not in named}
    if len(rest) > (0 if NAME in named else FEW):
        mark = max(rest, key=lambda m: rest[m])
        found = f"{len(rest)} panels farther off, {mark} by {rest[mark]:.4g} mm"
        findings.add(NAME, "panels on its strips", "within their fit_deviation_mm", found)
        return
    for mark, most in rest.items():
        stated = f"at most {rows[mark]['fit_deviation_mm']}"
        findings.add(mark, "fit_deviation_mm by strips.json", stated, most)


def _beside_edges(
    package: WrittenPackage,
    model: StripModel,
    rails: dict[str, tuple[Array, Array]],
    findings: Findings,
) -> bool:
    """Whether strips lie elsewhere by the panels' long edges.

    These are drawn back by half the stated joint from the edges between strips; by more and by
    less where the strips lie elsewhere, all by other than stated where the joint is another.
    """
    joint = float(package.setting("panels", "joint", 0.0))
    edges = np.stack([edge[len(edge) // 2] for pair in rails.values() for edge in pair])
    curves = model.points(model.parameters(64))
    away = _from_lines(curves[:, :-1].reshape(-1, 3), curves[:, 1:].reshape(-1, 3), edges)
    drawn = 2.0 * away[(away > DRAWN[0]) & (away < DRAWN[1])]
    if not joint or len(drawn) < 8:
        return False
    gaps = [number(row, "gap_max_mm") or 0.0 for row in package.tables["panels"]]
    within = JOINT + 0.5 * float(np.median(gaps))
    low, middle, high = np.quantile(drawn, [0.25, 0.5, 0.75])
    if not high - low <= 2.0 * within:
        findings.add(NAME, "joints about its edges", f"{joint:g} wide", f"{low:.4g} to {high:.4g}")
        return True
    if not abs(middle - joint) <= within:
        findings.add("manifest.json", "panels.joint of the panels", float(middle), joint)
    return False


def _from_lines(begin: Array, end: Array, points: Array) -> Array:
    """Distances (k,) of points from the nearest of short lines."""
    from scipy.spatial import KDTree

    _, near = KDTree(0.5 * (begin + end)).query(points, 4)
    a, way = begin[near], end[near] - begin[near]
    apart = points[:, None] - a
    s = np.clip(np.sum(apart * way, -1) / np.sum(way * way, -1), 0.0, 1.0)[..., None]
    return np.linalg.norm(apart - s * way, axis=-1).min(axis=1)
