"""Pictures of strip models: edges, rulings, worst places, curvature lines, fit history."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fabgeo.arrays import Array, cross
from fabgeo.strips.frames import frames
from fabgeo.strips.measures import Measures, Worst, measure, twist
from fabgeo.strips.model import StripModel

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SHOWN = {
    "twist_deg": ("twist", "deg", "tab:red"),
    "kink_across_deg": ("kink", "deg", "tab:orange"),
    "deviation_max": ("deviation", "mm", "tab:blue"),
    "radius_min": ("least radius", "mm", "tab:green"),
    "regression": ("regression", "", "tab:purple"),
}
_STAGES = {
    "twist_deg": "twist, deg",
    "kind_deg": "defect of the kind, deg",
    "deviation_over_sag": "deviation over the sag limit",
    "developability": "weight of developability",
}


def draw(
    model: StripModel,
    surface: Any = None,
    measures: Measures | None = None,
    path: str | Path | None = None,
    history: Sequence[Mapping[str, Any]] | None = None,
) -> Figure:
    """Draw a model with its worst places, and its fit history where it has one.

    Strips are coloured by their twist (blue: none), edges black, rulings grey; where a design
    surface is given, its principal directions are drawn as short crosses.

    Parameters
    ----------
    model : StripModel
    surface : DesignSurface, optional
    measures : Measures, optional
        Computed if not given.
    path : str or Path, optional
        Where to write a PNG; the figure is returned in any case (a notebook shows it).
    history : sequence of mappings, optional
        The fit's, `FitResult.history`; by default the one that the model was saved with.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    found = measure(model, surface, 4) if measures is None else measures
    if history is None:
        history = model.info.get("history", ())
    figure = Figure(figsize=(15, 8) if history else (11, 8), layout="constrained")
    FigureCanvasAgg(figure)
    axes: Any = figure.add_subplot(1, 2 if history else 1, 1, projection="3d")
    _surface(axes, figure, model)
    if surface is not None:
        _curvature(axes, surface, model)
    _worst_places(axes, model, found)
    if history:
        _history(figure.add_subplot(2, 2, 2), history)
        _lines(figure.add_subplot(2, 2, 4), found)
    if path is not None:
        figure.savefig(path, dpi=110)
    return figure


def _surface(axes: Any, figure: Any, model: StripModel) -> None:
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

    u = model.parameters(4)
    if model.closed_u:
        u = np.append(u, float(model.segments))
    f = frames(model, u)
    p0, p1 = f.sides(f.p)
    quads = np.stack([p0[:, :-1], p0[:, 1:], p1[:, 1:], p1[:, :-1]], axis=2)
    value = np.degrees(twist(f))
    value = (value[:, :-1] + value[:, 1:]) / 2.0
    scale = Normalize(0.0, max(float(value.max()), 1e-6))
    faces = colormaps["cividis"](scale(value.ravel()))
    normals = cross(quads[:, :, 1] - quads[:, :, 0], quads[:, :, 3] - quads[:, :, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-300)
    light = 0.7 + 0.3 * np.abs(normals @ np.array([0.4, 0.5, 0.77]))
    faces[:, :3] *= light.reshape(-1, 1)
    axes.add_collection3d(
        Poly3DCollection(quads.reshape(-1, 4, 3), facecolors=faces, edgecolors="none", alpha=0.9)
    )
    axes.add_collection3d(Line3DCollection(list(f.p), colors="black", linewidths=0.9))
    knots = slice(None, None, 4)
    rulings = np.stack([p0[:, knots], p1[:, knots]], axis=2).reshape(-1, 2, 3)
    axes.add_collection3d(Line3DCollection(list(rulings), colors="0.35", linewidths=0.3))
    low, high = f.p.min(axis=(0, 1)), f.p.max(axis=(0, 1))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(np.maximum(high - low, 0.05 * (high - low).max()))
    axes.set_title(f"{model.kind} model, {model.strips} strips x {model.segments} segments")
    figure.colorbar(
        ScalarMappable(scale, "cividis"), ax=axes, shrink=0.5, label="twist of the strip, deg"
    )


def _curvature(axes: Any, surface: Any, model: StripModel) -> None:
    """Principal directions on the surface: the larger curvature red, the smaller blue."""
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    points = surface.sample(250)
    _, directions = points.principal()
    low, high = surface.bounds
    length = float(np.linalg.norm(high - low)) / 90.0
    for k, colour in ((0, "tab:red"), (1, "tab:blue")):
        ends = [points.point + s * length * directions[:, k] for s in (-1.0, 1.0)]
        axes.add_collection3d(
            Line3DCollection(list(np.stack(ends, axis=1)), colors=colour, linewidths=0.8)
        )


def _place(model: StripModel, spot: Worst, on_edge: bool) -> Array:
    u = np.array([spot.u])
    first = model.edge(spot.strip, u)[0]
    return first if on_edge else (first + model.edge(spot.strip + 1, u)[0]) / 2.0


def _worst_places(axes: Any, model: StripModel, found: Measures) -> None:
    for name, (title, unit_name, colour) in _SHOWN.items():
        spot = getattr(found, name)
        if not isinstance(spot, Worst):
            continue
        x = _place(model, spot, name == "kink_across_deg")
        label = f"{title} {spot.value:.3g} {unit_name} (strip {spot.strip}, u {spot.u:.2f})"
        axes.scatter(*x, color=colour, s=45, label=label, depthshade=False)
    for fold in found.folds:
        axes.scatter(*_place(model, fold, False), color="black", marker="x", s=60, label="fold")
    axes.legend(loc="upper left", fontsize=8)


def _history(axes: Any, history: Sequence[Mapping[str, Any]]) -> None:
    """What a fit is after, stage by stage, on a logarithmic scale."""
    stages = np.arange(1, len(history) + 1)
    for name, label in _STAGES.items():
        values = np.array([float(row.get(name, np.nan)) for row in history])
        if np.any(values > 0.0):
            axes.semilogy(stages, np.where(values > 0.0, values, np.nan), ".-", label=label)
    axes.set(title="fit history", xlabel="stage")
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3)


def _lines(axes: Any, found: Measures) -> None:
    axes.axis("off")
    axes.text(0.0, 1.0, "\n".join(found.lines()), va="top", family="monospace", fontsize=8)
