"""Seconds to classify and jointly choose 3,600 panels: ``python tests/benchmarks/bench_panels.py``.

With the name of a fixture: what choosing its panels together saves at 3 mm and 1 degree
(``python tests/benchmarks/bench_panels.py great-court``).

Sixty strips of sixty panels on a vault whose curvature varies along and across the strips, at
3 mm, 1 degree and a gap of 2 mm. Prints wall seconds, processor seconds
of this process, costs and bounds.
"""

from __future__ import annotations

import os
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "panels"))

from panel_patches import panels_of

from fabgeo import spline
from fabgeo.build.fitted import patches_of, side_by_side, starts_of
from fabgeo.build.model import fit_of
from fabgeo.build.progress import Clock
from fabgeo.build.skin import inputs_of
from fabgeo.build.surface import surface_of
from fabgeo.panels.choose import choose
from fabgeo.panels.limits import Tolerances
from fabgeo.panels.samples import PanelInput
from fabgeo.project import read_project
from fabgeo.strips.model import StripModel


def vault(strips: int = 60, segments: int = 120) -> StripModel:
    """Strips between parallel, similar curves of varying curvature: developable without a fit."""
    i, u = np.arange(strips + 1)[:, None] / strips, np.arange(segments + 1)[None] / segments
    turn = 0.9 * (u - 0.5)
    radius = 60000.0 * (1.0 + 0.08 * np.sin(9.0 * turn)) + 0.0 * i
    scale = 1.0 + 0.12 * np.sin(2.5 * i)
    x, z = radius * np.sin(turn) * scale, radius * np.cos(turn) * scale
    return StripModel(spline.interpolate(np.stack([x, 90000.0 * i + 0.0 * u, z], -1)))


def fixture(name: str) -> list[PanelInput]:
    """The gross panels of a fixture's fitted model."""
    path = Path(__file__).resolve().parents[2] / "fixtures" / name / "project.toml"
    project = read_project(path)
    starts = starts_of(project, surface_of(project, path.parent), path.parent)
    models = side_by_side([project], starts, [fit_of(project, starts[0], Clock(None))])
    return inputs_of(project, models, patches_of(project, models[0].lanes))


def main() -> None:
    asked = sys.argv[1:]
    panels = fixture(asked[0]) if asked else panels_of(vault(), 60)
    wall, cpu = time.perf_counter(), time.process_time()
    limits = Tolerances(deviation_mm=3.0, kink_deg=1.0)
    found = choose(panels, limits, jobs=os.cpu_count())
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    print(f"{len(panels)} panels: {wall:.1f} s, {cpu:.1f} s of processor time")
    print(f"cost {found.cost:g}, bound {found.bound:g}, floor {found.floor:g}")
    print(f"panel by panel {found.one_by_one:g}: saved {100 * found.saving:.1f} %")
    print(dict(Counter(p.cls for p in found.panels)), found.history, found.candidates)
    print("largest gap", max(p.gap_mm for p in found.panels), "mm")


if __name__ == "__main__":
    main()
