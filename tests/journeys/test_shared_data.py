"""Surfaces that nobody here made: fitted from their own quads, or refused with the reason."""

from __future__ import annotations

from pathlib import Path

import pytest

import fabgeo
from fabgeo.fitting.starts import Start

pytestmark = pytest.mark.slow


def started(shared_data: Path, name: str, **options: object) -> tuple[object, Start]:
    surface = fabgeo.read_surface(
        shared_data / "surfaces" / name, unit="m" if name.endswith("obj") else None
    )
    return surface, fabgeo.start(surface, **options)  # type: ignore[arg-type]


def test_a_conical_mesh_becomes_a_conical_model(shared_data: Path) -> None:
    surface, start = started(shared_data, "conical1.obj", method="mesh")
    result = fabgeo.fit(start.reference, start.model, "conical")
    found = fabgeo.measure(result.model, surface)
    assert found.twist_deg.value <= 0.005, result.reason
    assert found.conicality is not None
    assert found.conicality.value <= 1e-4
    assert not found.folds
    pair = fabgeo.offset(result.model, -200.0)
    assert pair.errors.ruling <= 1e-5 * 200.0
    assert pair.errors.plane <= 1e-5 * 200.0


def test_a_principal_mesh_on_a_minimal_surface_becomes_circular(shared_data: Path) -> None:
    surface, start = started(shared_data, "enneper2.obj", method="mesh")
    result = fabgeo.fit(start.reference, start.model, "circular")
    found = fabgeo.measure(result.model, surface)
    assert result.status == "converged", result.reason
    assert found.twist_deg.value <= 0.02
    assert found.circularity.value <= 1.8e-4  # 0.01 degrees
    assert found.deviation_over_sag_limit is not None
    assert found.deviation_over_sag_limit <= 1.2


def test_a_single_curved_roof_is_met_exactly(shared_data: Path) -> None:
    surface, start = started(shared_data, "barrel.obj", method="mesh")
    found = fabgeo.measure(fabgeo.fit(surface, start.model).model, surface)
    assert found.twist_deg.value <= 1e-4
    assert found.deviation_max is not None
    assert found.deviation_max.value <= 0.01
    assert found.deviation_over_sag_limit is not None
    assert found.deviation_over_sag_limit <= 1.2  # though its rulings have no sag


@pytest.mark.parametrize("name", ["half-hull.step", "v2_Stearman.3dm", "tubemesh.obj"])
def test_hard_surfaces_converge_or_are_refused_by_place(shared_data: Path, name: str) -> None:
    if name.endswith("3dm"):
        pytest.importorskip("rhino3dm")
    try:
        surface, start = started(shared_data, name, strips=12)
        result = fabgeo.fit(start.reference, start.model)
    except fabgeo.FabgeoError as error:
        told = str(error)
    else:
        found = fabgeo.measure(result.model, surface)
        if result.status == "converged":
            assert found.twist_deg.value <= 0.02
            assert not found.folds
            return
        told = result.reason
    assert "strip" in told or "start" in told
    assert "u =" in told
