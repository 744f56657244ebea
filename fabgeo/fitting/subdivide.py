"""Strip subdivision across: every strip becomes two, the surface stays the same."""

from __future__ import annotations

import numpy as np

from fabgeo.strips.model import StripModel


def subdivide(model: StripModel) -> StripModel:
    """Halve every strip along the middles of its rulings.

    The middle curve of a ruled strip is the spline of the averaged control points, so nothing
    moves: a fit from here starts at the coarse model's own figures, at a quarter of its sag limit.
    """
    b = model.control
    first, second = model.pairs(b)
    middle = (first + second) / 2.0
    count = model.edges + model.strips
    control = np.empty((count, *b.shape[1:]))
    control[0::2], control[1::2] = b, middle
    return model.with_control(control)
