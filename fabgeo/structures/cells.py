"""Box-shell cells between a model and its offset (paper section 3, Fig. 6).

Every offset edge curve is computed once for the whole model and clipped exactly, so neighbouring
cells share their faces to the last digit: the same knots, the same poles.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fabgeo import spline
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
    return [_cell(pair, patch) for patch in patches]


def _cell(pair: Offset, patch: Patch) -> Cell:
    i = patch.strip
    j = (i + 1) % pair.base.edges if pair.base.closed_i else i + 1
    control = np.stack(
        [pair.base.control[i], pair.base.control[j], pair.model.control[j], pair.model.control[i]]
    )
    knots, poles = spline.clip(
        control, pair.base.closed_u, patch.u0 * pair.factor, patch.u1 * pair.factor
    )
    prism = Prism(f"C-{patch.tag}", knots, poles)
    refuse_folded(prism)
    return Cell(prism.mark, patch, prism)
