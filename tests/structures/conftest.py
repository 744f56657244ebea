"""The models that all tests of structures share."""

from __future__ import annotations

import numpy as np
import pytest
from structure_models import ANGLES, generic

from fabgeo.strips import exact
from fabgeo.strips.model import StripModel


@pytest.fixture(scope="session")
def conical() -> StripModel:
    return generic()


@pytest.fixture(scope="session")
def torus() -> StripModel:
    return exact.revolution(
        8000 + 5000 * np.cos(ANGLES), 5000 * np.sin(ANGLES), segments=24
    ).interpolant()
