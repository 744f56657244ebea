"""Random conical projects: every part a valid solid, or refused by name and with the reason."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from fabgeo.cad.measure import check_solid
from fabgeo.cad.plates import plate_solid
from fabgeo.cad.solids import prism_solid
from fabgeo.errors import GeometryError, InputError, PartError
from fabgeo.strips import exact
from fabgeo.strips.circular import conical_curves
from fabgeo.strips.model import StripModel
from fabgeo.structures.beams import BeamRule, Section, beams
from fabgeo.structures.cells import cells
from fabgeo.structures.connectors import connect
from fabgeo.structures.fixing import Fixing
from fabgeo.structures.holes import bored_volume
from fabgeo.structures.panels import Joint, Layer, panels
from fabgeo.structures.parts import Cell, Plate
from fabgeo.structures.patches import CutRule, cut
from fabgeo.structures.prisms import plate_prism, prism_properties


def _model(rng: np.random.Generator) -> StripModel:
    angles = np.linspace(0.0, rng.uniform(0.3, 1.4), int(rng.integers(4, 12)))
    r = rng.uniform(2000.0, 9000.0)
    profile = np.stack([r * np.cos(angles), r * np.sin(angles)], axis=1)
    base = rng.uniform(6000.0, 12_000.0)
    model = exact.moulding(base, rng.uniform(-0.1, 0.1) * base, profile)
    if rng.uniform() < 0.6:
        centre = rng.uniform(-1.0, 0.0, 3) * (12_000.0, 3000.0, 9000.0) - (4000.0, 0.0, 2000.0)
        model = exact.inverted(model, centre, rng.uniform(10_000.0, 20_000.0))
        made = conical_curves(model)
        model = exact.ExactModel(made.curves, made.edges, model.segments, kind="conical")
    return model.interpolant(4)


def _project(seed: int) -> Iterator[Plate | Cell]:
    """The parts of one random project."""
    rng = np.random.default_rng(seed)
    strips = _model(rng)
    patches = cut(strips, CutRule(length=rng.uniform(600.0, 4000.0)))
    yield from cells(strips, patches, rng.uniform(-1.0, 1.0) * rng.choice([300, 3000, 12_000]))
    joint = Joint(rng.uniform(0.0, 30.0), rng.uniform(0.0, 30.0))
    layer = Layer("a", rng.uniform(-99, 99), 12.0, "steel")
    skin = panels(strips, patches, layer, joint)
    depth, web = rng.uniform(100.0, 600.0), rng.uniform(6.0, 20.0)
    low = layer.height - 6.0 - rng.uniform(15.0, 45.0)  # stand-offs in and out of reach
    section = Section(outer=low, depth=depth, web=web, width_outer=220.0)
    joined = ({"end_plate": 15.0}, {"gap": 3.0, "bevel": 60.0})[int(rng.integers(2))]
    made = beams(strips, section, BeamRule(**joined), edges=[0, strips.edges // 2])
    fixed = connect(skin, made, Fixing(spacing=rng.uniform(300.0, 900.0)))
    yield from fixed.panels
    for beam in fixed.beams:
        yield from beam.plates


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_random_conical_project_is_valid_or_refused(seed: int) -> None:
    print(f"seed {seed}")
    solids = holes = 0
    refusal = None
    try:
        for part in _project(seed):
            holes += 0 if isinstance(part, Cell) else len(part.holes)
            _check(part)
            solids += 1
    except (GeometryError, InputError, PartError) as error:
        refusal = error
    print(f"{solids} solids, {holes} holes; refused: {refusal}")
    if refusal is None:
        assert solids > 0
    else:
        assert refusal.where
        assert refusal.cure


def _check(part: Plate | Cell) -> None:
    """A solid that is made is valid, closed, of its volume."""
    if isinstance(part, Cell):
        prism, bored, solid = part.prism, 0.0, prism_solid(part.prism)
    else:
        prism = plate_prism(part)
        bored, solid = bored_volume(prism, part.holes), plate_solid(part)
    found = prism_properties(prism)
    assert found.orientation > 0.0
    report = check_solid(solid, 1e-4)
    assert report.sound, part.mark
    assert report.tolerance <= 1e-3, part.mark
    assert report.volume == pytest.approx(found.volume - bored, rel=1e-6), part.mark
