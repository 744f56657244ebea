"""The pictures of README and gallery, drawn from the files of a written package.

    python docs/pictures.py outputs/great-court docs/great-court.png

Left the strip model with its rulings (strips.json), in the middle the parts as built (facade.glb;
panels coloured by their class), right one nested sheet (its DXF file).
"""

from __future__ import annotations

import argparse
import csv
import re
from pathlib import Path
from typing import Any

import ezdxf
import matplotlib
import numpy as np
import trimesh
from ezdxf import path as paths
from matplotlib.collections import LineCollection, PolyCollection

from fabgeo import load_model
from fabgeo.review.palette import CLASSES
from fabgeo.review.picture import view_of

matplotlib.use("Agg")
EYE = np.array([-0.55, -0.75, 0.62])
OPEN = 0.45  # of the strips are drawn without panels where there is something below
SUN = np.array([-0.3, -0.5, 0.85]) / np.linalg.norm([-0.3, -0.5, 0.85])


def shaded(axes: Any, triangles: np.ndarray, colours: np.ndarray) -> None:
    """Triangles (k, 3, 3) with colours (k, 3), seen along EYE, from far to near."""
    view = view_of(EYE)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    sizes = np.linalg.norm(normals, axis=1)
    facing = sizes > 0
    triangles, colours = triangles[facing], colours[facing]
    light = np.abs(normals[facing] @ SUN) / sizes[facing]
    seen = triangles @ view.T
    order = np.argsort(seen[:, :, 2].mean(axis=1))
    tones = np.clip(colours * (0.45 + 0.6 * light)[:, None], 0, 1)[order]
    axes.add_collection(
        PolyCollection(seen[order][:, :, :2], facecolors=tones, edgecolors=tones, linewidths=0.2)
    )
    _frame(axes, seen[:, :, :2].reshape(-1, 2))


def model_picture(axes: Any, path: Path) -> None:
    """Strips in two tones, every edge curve, and the rulings at the segments' ends."""
    model = load_model(path)
    u = model.parameters(12)
    here, ahead = model.pairs(model.points(u))
    quads = np.stack([here[:, :-1], here[:, 1:], ahead[:, 1:], ahead[:, :-1]], axis=2)
    triangles = quads[:, :, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
    tones = np.array([[0.62, 0.74, 0.84], [0.72, 0.82, 0.90]])[np.arange(len(quads)) % 2]
    shaded(axes, triangles, np.repeat(tones, quads.shape[1] * 2, axis=0))
    view = view_of(EYE)
    rulings = np.stack([here[:, ::6], ahead[:, ::6]], axis=2).reshape(-1, 2, 3)
    lines = [*(rulings @ view.T)[:, :, :2], *(model.points(u) @ view.T)[:, :, :2]]
    widths = [0.25] * len(rulings) + [0.7] * model.edges
    axes.add_collection(LineCollection(lines, colors="#22303c", linewidths=widths))


def parts_picture(axes: Any, folder: Path) -> None:
    """All solids; panels in the colour of their class, some left out where parts lie below."""
    with open(folder / "schedules/panels.csv", newline="", encoding="utf-8") as file:
        classes = {row["mark"]: row["class"] for row in csv.DictReader(file)}
    scene: Any = trimesh.load(folder / "model/facade.glb")
    last = max(int(mark.split("-")[1]) for mark in classes)
    below = any((folder / "schedules" / name).exists() for name in ("beams.csv", "cells.csv"))
    triangles, colours = [], []
    for node in scene.graph.nodes_geometry:
        turn, name = scene.graph[node]
        mesh = scene.geometry[name]
        corners = trimesh.transform_points(mesh.vertices, turn)[mesh.faces]
        mark = node.split("#")[0]
        if not re.match(r"[A-JL-Z]-\d", mark):
            continue  # fixings (K) are too small to be seen
        own = classes.get(mark)
        if own and below and int(mark.split("-")[1]) < OPEN * last:
            continue
        colour = matplotlib.colors.to_rgb(CLASSES[own]) if own else _material(mesh)
        triangles.append(corners[:, :, [0, 2, 1]] * [1, -1, 1])  # glTF's y is up
        colours.append(np.tile(colour, (len(corners), 1)))
    shaded(axes, np.concatenate(triangles), np.concatenate(colours))


def sheet_picture(axes: Any, path: Path) -> None:
    """Everything that is drawn on a sheet."""
    page = ezdxf.readfile(path).modelspace()
    lines = {"CUT": [], "other": []}
    for item in page.query("LWPOLYLINE POLYLINE LINE ARC CIRCLE SPLINE"):
        points = [(p.x, p.y) for p in paths.make_path(item).flattening(1.0)]
        lines["CUT" if "CUT" in item.dxf.layer.upper() else "other"].append(points)
    axes.add_collection(LineCollection(lines["other"], colors="#8a98a5", linewidths=0.5))
    axes.add_collection(LineCollection(lines["CUT"], colors="#b3261e", linewidths=0.8))
    _frame(axes, np.concatenate([np.array(x) for x in (*lines["CUT"], *lines["other"])]))


def _material(mesh: Any) -> tuple[float, ...]:
    return tuple(np.asarray(mesh.visual.material.baseColorFactor[:3], float) / 255)


def _frame(axes: Any, points: np.ndarray) -> None:
    low, high = points.min(axis=0), points.max(axis=0)
    slack = 0.03 * (high - low).max()
    axes.set(xlim=(low[0] - slack, high[0] + slack), ylim=(low[1] - slack, high[1] + slack))
    axes.set_aspect("equal")
    axes.axis("off")


def main() -> None:
    """Draw the picture of a package."""
    from matplotlib.figure import Figure

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("package", type=Path)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--sheet", default="*/SHEET-001.dxf", help="pattern below cut/nests")
    asked = parser.parse_args()
    figure = Figure(figsize=(15, 4.6), layout="constrained", facecolor="white")
    axes: Any = figure.subplots(1, 3, width_ratios=(1, 1, 0.85))
    sheet = sorted((asked.package / "cut/nests").glob(asked.sheet))[0]
    model_picture(axes[0], asked.package / "strips.json")
    parts_picture(axes[1], asked.package)
    sheet_picture(axes[2], sheet)
    for ax, text in zip(axes, ("strip model", "solids", f"cut file {sheet.stem}"), strict=True):
        ax.set_title(text, fontsize=11, color="#3a4753")
    figure.savefig(asked.picture, dpi=100)


if __name__ == "__main__":
    main()
