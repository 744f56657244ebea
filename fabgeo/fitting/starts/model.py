"""Start from a previous model, resampled to other numbers of strips and segments."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fabgeo.arrays import checked_count
from fabgeo.errors import InputError
from fabgeo.fitting.starts.net import Net, model_through
from fabgeo.fitting.store import load_model
from fabgeo.strips.model import MOST_STRIPS, StripModel
from fabgeo.surfaces.base import DesignSurface


def model_start(
    surface: DesignSurface | None,
    strips: int | None,
    segments: int | None,
    direction: str | None = None,
    seed: StripModel | str | Path | None = None,
) -> tuple[StripModel, list[str]]:
    """A previous model (the `seed`, or its `strips.json`) with the strips and segments asked for.

    The same numbers give the same model; doubled segments give it exactly (knot refinement).
    """
    if seed is None:
        raise InputError("start 'model'", "expected the previous model as seed, found none")
    if not isinstance(seed, StripModel | str | Path):
        found = type(seed).__name__
        raise InputError("start 'model'", f"expected a model or the path of one, found {found}")
    previous = seed if isinstance(seed, StripModel) else load_model(seed)
    strips, segments = strips or previous.strips, segments or previous.segments
    model = previous
    while model.segments < segments and segments % (2 * model.segments) == 0:
        model = model.refined()
    if (model.strips, model.segments) == (strips, segments):
        return model, ["the previous model" + (", knots refined" if model is not previous else "")]
    net = net_of_model(model)
    least = 3 if net.closed_s else 1
    if strips < least:
        raise InputError("strips", f"expected at least {least}, found {strips}")
    checked_count("strips", strips, least, MOST_STRIPS)
    s, t = net.places(strips), even(segments, net.closed_t)
    model = model_through(net.sampled(s, t), net.closed_t, net.closed_s)
    note = (
        f"the previous model, {previous.strips} x {previous.segments} resampled to "
        f"{strips} x {segments}"
    )
    return model, [note]


def net_of_model(model: StripModel) -> Net:
    """The model's edge points at four parameters a segment, smooth across the strips."""
    return Net(model.points(model.parameters(4)), model.closed_i, model.closed_u)


def even(count: int, closed: bool) -> np.ndarray:
    """`count` + 1 even values from 0 to 1, without the last where closed."""
    values = np.linspace(0.0, 1.0, count + 1)
    return values[:-1] if closed else values
