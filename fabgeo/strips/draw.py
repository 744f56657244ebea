"""Pictures of strip models: edges, rulings, worst places, curvature lines, fit history."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fabgeo.arrays import Array, as_numbers, checked_path, cross
from fabgeo.errors import InputError
from fabgeo.strips.frames import frames
from fabgeo.strips.measures import Measures, Worst, measure, twist
from fabgeo.strips.model import StripModel, check_model
from fabgeo.surfaces.base import size_of
from fabgeo.surfaces.trace import both_ways, trace_principal

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SHOWN = {
    "twist_deg": ("twist", "deg", "tab:red"),
    "kink_across_deg": ("kink", "deg", "tab:orange"),
    "deviation_max": ("deviation", "mm", "tab:blue"),
    "radius_min": ("least radius", "mm", "tab:green"),
    "regression": ("regression", "", "tab:purple"),
}
LEAST_SCALE = 0.002  # degrees of twist at the end of the scale of colours, at least
SEEDS, PIECES = 120, 4  # curvature lines drawn, and steps of each to both sides
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
    surface is given, pieces of its curvature lines (red: the larger curvature) and its boundary.

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

    Raises
    ------
    InputError
        If one of them is something else, or the picture cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    check_model("draw", model)
    found = measure(model, surface, 4) if measures is None else measures
    if not isinstance(found, Measures):
        raise InputError("draw", "expected measures of the model", "pass fabgeo.measure(...)")
    if history is None:
        history = model.info.get("history", ())
    records = isinstance(history, Sequence) and all(isinstance(row, Mapping) for row in history)
    if not records:
        raise InputError("draw", "expected a history of records", "pass FitResult.history")
    figure = Figure(figsize=(16, 8) if history else (11, 8), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(2, 2 if history else 1, width_ratios=(3, 2) if history else (1,))
    axes: Any = figure.add_subplot(grid[:, 0], projection="3d", computed_zorder=False)
    _strips(axes, figure, model)
    if surface is not None:
        _curvature(axes, surface)
    _worst_places(axes, model, found)
    if history:
        _history(figure.add_subplot(grid[0, 1]), history)
        _lines(figure.add_subplot(grid[1, 1]), found)
    if path is not None:
        target = checked_path("draw", path)
        try:
            figure.savefig(target, dpi=110)
        except (OSError, ValueError) as error:
            raise InputError(str(target), f"cannot be drawn to: {error}", "name a .png") from error
    return figure


def _strips(axes: Any, figure: Any, model: StripModel) -> None:
    """Strips by their twist, with edges and the rulings at knots."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.ticker import MaxNLocator
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

    u = model.parameters(4)
    if model.closed_u:
        u = np.append(u, float(model.segments))
    f = frames(model, u)
    p0, p1 = f.sides(f.p)
    quads = np.stack([p0[:, :-1], p0[:, 1:], p1[:, 1:], p1[:, :-1]], axis=2)
    value = np.degrees(twist(f))
    value = (value[:, :-1] + value[:, 1:]) / 2.0
    scale = Normalize(0.0, max(float(value.max()), LEAST_SCALE))
    faces = colormaps["cividis"](scale(value.ravel()))
    normals = cross(quads[:, :, 1] - quads[:, :, 0], quads[:, :, 3] - quads[:, :, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-300)
    light = 0.7 + 0.3 * np.abs(normals @ np.array([0.4, 0.5, 0.77]))
    faces[:, :3] *= light.reshape(-1, 1)
    axes.add_collection3d(
        Poly3DCollection(
            quads.reshape(-1, 4, 3), facecolors=faces, edgecolors=faces, linewidths=0.2
        )
    )
    knots = slice(None, None, 4)
    rulings = np.stack([p0[:, knots], p1[:, knots]], axis=2).reshape(-1, 2, 3)
    axes.add_collection3d(Line3DCollection(list(rulings), colors="0.75", linewidths=0.4, zorder=2))
    axes.add_collection3d(Line3DCollection(list(f.p), colors="black", linewidths=0.9, zorder=3))
    low, high = f.p.min(axis=(0, 1)), f.p.max(axis=(0, 1))
    if not (high - low).max() > 0.0:
        raise InputError("draw", "the model has no size: all its points lie in one place")
    size = np.maximum(high - low, 0.05 * (high - low).max())
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], low[2] + size[2]))
    axes.set_box_aspect(size)
    for axis, length in zip((axes.xaxis, axes.yaxis, axes.zaxis), size, strict=True):
        axis.set_major_locator(MaxNLocator(max(int(6.0 * length / size.max()), 1)))
        axis.set_tick_params(labelsize=8)
    axes.set_title(f"{model.kind} model, {model.strips} strips x {model.segments} segments")
    figure.colorbar(
        ScalarMappable(scale, "cividis"),
        ax=axes,
        location="bottom",
        shrink=0.5,
        pad=0.0,
        label="twist of the strip, deg",
        ticks=MaxNLocator(4),
    )


def _curvature(axes: Any, surface: Any) -> None:
    """Pieces of curvature lines: the larger curvature red, the smaller blue; the boundary."""
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    at = surface.sample(SEEDS)
    _, directions = at.principal()
    step = size_of(surface) / 25.0 / PIECES

    def traced(points: Array, along: Array) -> Array:
        return trace_principal(surface, points, along, step, PIECES)

    for k, colour in ((0, "tab:red"), (1, "tab:cyan")):
        lines, _ = both_ways(traced, at.point, directions[:, k])
        axes.add_collection3d(Line3DCollection(list(lines), colors=colour, linewidths=1, zorder=4))
    for loop in surface.loops:
        axes.plot(*np.concatenate([loop, loop[:1]]).T, color="white", linewidth=2.5, zorder=4)
        axes.plot(*np.concatenate([loop, loop[:1]]).T, color="tab:green", linewidth=1.2, zorder=5)


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
        axes.scatter(
            *x, color=colour, s=60, edgecolors="white", label=label, depthshade=False, zorder=6
        )
    for fold in found.folds:
        axes.scatter(
            *_place(model, fold, False), color="black", marker="x", s=60, label="fold", zorder=6
        )
    axes.legend(loc="upper left", fontsize=8)


def _history(axes: Any, history: Sequence[Mapping[str, Any]]) -> None:
    """What a fit is after, stage by stage, on a logarithmic scale."""
    from matplotlib.ticker import MaxNLocator

    stages = np.arange(1, len(history) + 1)
    for name, label in _STAGES.items():
        values = as_numbers(f"draw: {name}", [row.get(name, np.nan) for row in history])
        if values.ndim != 1:
            raise InputError(f"draw: {name}", "expected one number a stage")
        if np.any(values > 0.0):
            axes.semilogy(stages, np.where(values > 0.0, values, np.nan), ".-", label=label)
    axes.set(title="fit history", xlabel="stage")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    if axes.has_data():
        axes.legend(fontsize=8)
    axes.grid(alpha=0.3)


def _lines(axes: Any, found: Measures) -> None:
    axes.axis("off")
    axes.text(0.0, 1.0, "\n".join(found.lines()), va="top", family="monospace", fontsize=8)
