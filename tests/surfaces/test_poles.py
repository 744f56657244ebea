"""Formulas that run off to infinity between samples, and those that are only steep."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fabgeo.errors import InputError
from fabgeo.surfaces.formula import FormulaChart
from fabgeo.surfaces.poles import pole_of


def chart(z: str) -> FormulaChart:
    """A height z(u, v) over the unit square."""
    return FormulaChart("u", "v", z, (0.0, 1.0), (0.0, 1.0), {}, (False, False), 1000.0)


@pytest.mark.parametrize(
    "z",
    [
        "1/(u - 0.4999)",
        "1/(v - 0.4999)**2",
        "u*v + 1e-6/(u - 0.4999)",
        "log(abs(u - 0.4999))",
        "log(hypot(u - 0.4999, v - 0.3333))",
        "1/((u - 0.4999)**2 + (v - 0.3333)**2)",
        "1/(u*u + v*v - 0.5123)",
        "tan(1000*u + 0.2)",
        "sin(1/(u - 0.4999))",
        "sqrt((u - 0.4999)**2 - 1e-9)",  # no point between 0.49987 and 0.49993
    ],
)
def test_poles_between_samples_are_refused(z: str) -> None:
    with pytest.raises(InputError, match="formula z: has no finite value or derivative near"):
        chart(z)


@pytest.mark.parametrize(
    "z",
    [
        "0",
        "abs(u - 0.4999)",
        "hypot(u - 0.4999, v - 0.3333)",
        "abs(u - 0.4999)**1.5",
        "sqrt(abs(u - 0.4999))",
        "exp(-(1e4*(u - 0.4999))**2)",
        "atan(1e5*(u - 0.4999))",
        "1/((u - 0.4999)**2 + 1e-6)",
        "sin(300*u)*sin(211*v)",
    ],
)
def test_steep_formulas_are_no_poles(z: str) -> None:
    assert pole_of(chart(z)) is None


@settings(max_examples=20, deadline=None)
@given(
    at=st.floats(0.01, 0.99),
    lean=st.floats(-0.5, 0.5),
    strength=st.floats(1e-4, 1e3),
    power=st.integers(1, 3),
)
def test_poles_along_any_line_are_found(at, lean, strength, power) -> None:
    line = f"u - {at!r} - {lean!r}*(v - 0.5)"
    with pytest.raises(InputError, match=r"no finite value or derivative|reaches") as error:
        chart(f"u*v + {strength!r}/({line})**{power}")
    told = str(error.value)
    if "near" in told:
        u, v = (float(told.split(f"{name} = ")[1].split(",")[0].split(";")[0]) for name in "uv")
        assert np.abs(u - at - lean * (v - 0.5)) < 1e-5


@pytest.mark.parametrize("z", ["1e200*u", "1e13"])
def test_formulas_beyond_all_buildings_are_refused(z: str) -> None:
    with pytest.raises(InputError, match="formula z: reaches"):
        chart(z)
