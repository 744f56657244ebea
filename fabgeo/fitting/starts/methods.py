"""Every method of a start by its name: called, checked for its options, and noted on the model."""

from __future__ import annotations

from collections.abc import Callable
from difflib import get_close_matches
from inspect import signature
from typing import Any

import numpy as np

from fabgeo.errors import InputError
from fabgeo.fitting.starts.geodesic import geodesic_start
from fabgeo.fitting.starts.iso import iso_start
from fabgeo.fitting.starts.mesh import mesh_start
from fabgeo.fitting.starts.model import model_start
from fabgeo.fitting.starts.network import network_start
from fabgeo.fitting.starts.principal import principal_start
from fabgeo.fitting.starts.sections import sections_start
from fabgeo.strips.model import StripModel
from fabgeo.surfaces.base import DesignSurface

# Every method: (surface, strips, segments, direction, seed, **options) -> model, notes.
STARTS: dict[str, Callable[..., tuple[StripModel, list[str]]]] = {
    "iso": iso_start,
    "principal": principal_start,
    "sections": sections_start,
    "mesh": mesh_start,
    "geodesic": geodesic_start,
    "network": network_start,
    "model": model_start,
}
SHARED = ("sag", "conjugate", "project", "ends")  # options of `draw.model_of_net`


def called(
    method: str,
    surface: DesignSurface,
    strips: int | None,
    segments: int | None,
    direction: str | None,
    seed: Any,
    options: dict[str, Any],
) -> tuple[StripModel, list[str]]:
    """The model by one method, and its notes.

    Raises
    ------
    InputError
        For options that the method does not have.
    """
    function = STARTS[method]
    known = [k for k, p in signature(function).parameters.items() if p.kind is not p.VAR_KEYWORD]
    for name in options:
        if name not in known and name not in SHARED:
            near = get_close_matches(name, [*known, *SHARED], 1)
            cure = f"did you mean '{near[0]}'?" if near else ""
            raise InputError("start options", f"'{method}' has no option '{name}'", cure)
    return function(surface, strips, segments, direction, seed, **options)


def told(model: StripModel, method: str, direction: Any, notes: list[str]) -> StripModel:
    """The model with a note of how it came about."""
    direction = direction if isinstance(direction, str | None) else np.asarray(direction).tolist()
    info = {**model.info, "start": {"method": method, "direction": direction, "notes": notes}}
    return model.with_control(model.control, info=info)
