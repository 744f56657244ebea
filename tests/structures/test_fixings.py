"""Fixings, clashes, and layouts of two layers or two models."""

from __future__ import annotations

import numpy as np
import pytest
from structure_models import twist_deg

from fabgeo.arrays import dot
from fabgeo.errors import GeometryError
from fabgeo.strips import exact
from fabgeo.strips.axes import axes
from fabgeo.strips.model import StripModel
from fabgeo.structures.beams import BeamRule, Section, beams
from fabgeo.structures.clashes import clashes, clear_distance
from fabgeo.structures.connectors import connect
from fabgeo.structures.crossed import crossed
from fabgeo.structures.fixing import Fixing
from fabgeo.structures.mixed import attach, mesh_beams, strips_on_mesh
from fabgeo.structures.panels import Joint, Layer, panels
from fabgeo.structures.patches import CutRule, cut


def test_fixings_pierce_panel_and_flange_on_one_axis(conical: StripModel) -> None:
    patches = cut(conical, CutRule(length=1800.0))
    skin = panels(conical, patches, Layer("skin", 0.0, 10.0, "steel"), Joint(12.0, 12.0))
    section = Section(outer=-32.0, width_outer=260.0)
    frame = beams(conical, section, BeamRule(box=(5000.0, 2480.0, 2500.0)))
    made = connect(skin, frame, Fixing(edge_distance=55.0))
    assert len(made.connectors) > 50
    holes = {p.mark: p.holes for p in made.panels}
    flanges = {p.mark: p for b in made.beams for p in b.plates if p.role == "flange_outer"}
    assert sum(map(len, holes.values())) == len(made.connectors)
    assert sum(len(p.holes) for p in flanges.values()) == 2 * len(made.connectors)
    for connector in made.connectors:
        z, origin = connector.frame[:3, 2], connector.frame[:3, 3]
        hole = min(holes[connector.panel], key=lambda h: np.linalg.norm(h.centre - origin))
        off = hole.centre - origin
        assert np.linalg.norm(off - (off @ z) * z) < 1e-6
        product = made.products[connector.product]
        low, high = product.stand_off, product.stand_off + product.step
        assert low - 1e-6 <= off @ z - 5.0 <= high + 1e-6
    # Bolt axes of all holes in a flange meet its mid-surface: they lie on it within 0.1 mm.
    for plate in flanges.values():
        u = np.linspace(plate.mid.u0, plate.mid.u1, 4001)
        a, b = plate.mid.edges(u)
        for hole in plate.holes[:3]:
            v = dot(hole.centre - a, b - a) / dot(b - a, b - a)
            assert np.linalg.norm(a + v[:, None] * (b - a) - hole.centre, axis=-1).min() < 1.0
    found = clashes(made.connectors, made.products, made.panels, made.beams)
    assert all(c.first in {k.mark for k in made.connectors} for c in found)


def test_narrow_flange_and_far_panel_are_refused_by_name(conical: StripModel) -> None:
    patches = cut(conical, CutRule(count=3))
    skin = panels(conical, patches, Layer("skin", 0.0, 10.0, "steel"), Joint(12.0))
    narrow = connect(skin, beams(conical, Section(outer=-32.0, width_outer=100.0)), Fixing())
    assert not narrow.connectors
    assert all("wide" in reason for reason in narrow.refused.values())
    far = connect(skin, beams(conical, Section(outer=-200.0, width_outer=300.0)), Fixing())
    assert not far.connectors
    assert all("stand-off" in reason for reason in far.refused.values())
    assert all(where.startswith("P-") for where in far.refused)


def test_clear_distance_of_flange_and_panel(torus: StripModel) -> None:
    panel = panels(torus, cut(torus, CutRule(count=8)), Layer("skin", 0.0, 4.0, "steel"))[20]
    strip = int(panel.mark.split("-")[1])
    for outer, low, high in ((-27.0, 20.0, 25.2), (-1.0, -6.0, 0.0)):
        beam = beams(torus, Section(outer=outer, width_outer=100.0), BeamRule(), [strip])[0]
        flange = next(p for p in beam.plates if p.role == "flange_outer")
        assert low < clear_distance(panel, flange) < high  # 2 mm of panel, less where it tilts


def test_overlapping_fixings_are_found_and_named(conical: StripModel) -> None:
    patches = cut(conical, CutRule(count=2))
    skin = panels(conical, patches[:2], Layer("skin", 0.0, 10.0, "steel"), Joint(12.0))
    frame = beams(conical, Section(outer=-32.0, width_outer=260.0), edges=[1])
    made = connect(skin, frame, Fixing(spacing=90.0))
    found = clashes(made.connectors, made.products, made.panels, made.beams)
    assert any(c.reason == "fixings overlap" for c in found)


def test_layers_of_quad_mesh_and_strips(torus: StripModel) -> None:
    """On parallel circles the gap is the sagitta of the chord between two nodes."""
    u = np.linspace(0.0, 24.0, 9)
    layered = attach(torus, u)
    radius, angle = 13000.0, 1.2 / 8.0
    assert layered.gap_max == pytest.approx(radius * (1.0 - np.cos(angle / 2.0)), rel=1e-5)
    assert layered.node_error < 1e-9
    assert layered.planarity < 1e-6
    made = mesh_beams(layered, axes(torus)(u), Section(), edges=[2])
    assert len(made) == 8
    assert all(twist_deg(p.mid) < 0.01 for b in made for p in b.plates)
    model, again = strips_on_mesh(layered.nodes)
    assert again.node_error < 1e-6
    assert again.gap_max == pytest.approx(layered.gap_max, rel=1e-2)
    assert model.strips == torus.strips


def test_two_crossed_models(torus: StripModel) -> None:
    tubes = exact.meridians(
        8000.0, 5000.0, np.linspace(0.1, 1.1, 5), 0.05, 1.15, segments=24
    ).interpolant()
    made = crossed(torus, tubes, (Section(), Section(outer=-400.0)))
    assert made.angle_min_deg == pytest.approx(90.0, abs=0.01)
    assert made.outer
    assert made.inner
    with pytest.raises(GeometryError, match="meet at"):
        crossed(torus, torus, (Section(), Section()))
