"""Box-shell cells between a model and its offset (paper section 3, Fig. 6).

All edge curves and their offsets between two ruling polygons are interpolated at once on common
knots, so neighbouring cells share their faces to the last digit: the same knots, the same poles.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from fabgeo.arrays import Array
from fabgeo.strips.interpolated import Interpolated, interpolated, knots_between
from fabgeo.strips.model import Patch, StripModel
from fabgeo.strips.offset import Offset, offset
from fabgeo.structures.parts import Cell, Prism
from fabgeo.structures.prisms import refuse_folded


def cells(
    model: StripModel,
    patches: Sequence[Patch],
    distance: float,
    tolerance: float = 1e-3,
    pair: Offset | None = None,
) -> list[Cell]:
    """The cells of the box shell: four developable faces and two planar walls each.

    The prism's edge curves run p_i, p_{i+1}, p_{i+1} + d n, p_i + d n: face 0 lies on the model,
    face 2 on the offset, faces 1 and 3 on the axis strips of edges i + 1 and i.

    Raises
    ------
    GeometryError
        If the model has no offset (neither conical nor circular), or a cell folds.
    """
    pair = offset(model, distance, tolerance) if pair is None else pair

    def curves(u: Array) -> Array:
        p = model.points(u)
        return np.concatenate([p, p + distance * pair.axes(u)])

    @cache
    def between(u0: float, u1: float) -> Interpolated:
        knots = knots_between(u0, u1, multiplicity=2)
        return interpolated(curves, knots, tolerance, f"cells from u = {u0:.4g} to {u1:.4g}")

    return [_cell(model, patch, between(patch.u0, patch.u1)) for patch in patches]


def _cell(model: StripModel, patch: Patch, made: Interpolated) -> Cell:
    i, count = patch.strip, model.edges
    j = (i + 1) % count
    prism = Prism(f"C-{patch.tag}", made.knots, made.poles[[i, j, j + count, i + count]])
    refuse_folded(prism)
    return Cell(prism.mark, patch, prism)
