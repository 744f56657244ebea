"""Random conical projects: every part valid, or refused by name and with the reason."""

from __future__ import annotations

import numpy as np
import pytest

from fabgeo.errors import GeometryError, InputError
from fabgeo.strips import exact
from fabgeo.strips.circular import conical_curves
from fabgeo.structures.beams import BeamRule, Section, beams
from fabgeo.structures.cells import cells
from fabgeo.structures.panels import Joint, Layer, panels
from fabgeo.structures.patches import CutRule, cut
from fabgeo.structures.prisms import plate_prism, prism_properties


def _project(seed: int) -> int:
    """Build one random project; the number of parts that stand."""
    rng = np.random.default_rng(seed)
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
    strips = model.interpolant(4)
    patches = cut(strips, CutRule(length=rng.uniform(600.0, 4000.0)))
    made = cells(strips, patches, rng.uniform(-1.0, 1.0) * rng.choice([300.0, 3000.0, 12_000.0]))
    parts = [cell.prism for cell in made]
    joint = Joint(rng.uniform(0.0, 30.0), rng.uniform(0.0, 30.0))
    parts += [
        plate_prism(p)
        for p in panels(strips, patches, Layer("a", rng.uniform(-99, 99), 12.0, "steel"), joint)
    ]
    section = Section(depth=rng.uniform(100.0, 600.0), web=rng.uniform(6.0, 20.0))
    for beam in beams(strips, section, BeamRule(end_plate=15.0), edges=[0, strips.edges // 2]):
        parts += [plate_prism(plate) for plate in beam.plates]
    for part in parts:
        found = prism_properties(part)
        assert found.orientation > 0.0
        assert found.volume > 0.0
    return len(parts)


@pytest.mark.parametrize("seed", range(10))
def test_random_conical_project_is_valid_or_refused(seed: int) -> None:
    print(f"seed {seed}")
    refusal = None
    try:
        parts = _project(seed)
    except (GeometryError, InputError) as error:
        refusal, parts = error, 0
    if refusal is None:
        assert parts > 0
    else:
        print(f"refused: {refusal}")
        assert refusal.where
        assert refusal.cure
