"""Seconds for the closest points of 10,000 queries on every kind of design surface.

`python tests/benchmarks/bench_closest.py` from the project's root; CPU seconds, medians of 5.
"""

from __future__ import annotations

import statistics
import time
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.cad.read_surface import read_surface
from fabgeo.surfaces.formula import FormulaSurface

ROOT = Path(__file__).resolve().parents[2]
QUERIES = 10_000


def timed(call: Callable[[], Any]) -> tuple[float, Any]:
    start = time.process_time()
    result = call()
    return time.process_time() - start, result


def great_court() -> FormulaSurface:
    text = (ROOT / "fixtures" / "great-court" / "project.toml").read_text()
    table = tomllib.loads(text)["surface"]
    table.pop("unit")
    return FormulaSurface(**table, scale=1000.0, name="great-court")


def main() -> None:
    shared = ROOT.parent / "shared" / "data" / "surfaces"
    cases: list[tuple[str, Callable[[], Any]]] = [("great-court (formula)", great_court)]
    files = [
        ROOT / "fixtures" / "tower" / "sections.csv",
        ROOT / "fixtures" / "canopy" / "canopy.step",
        shared / "conical1.obj",
        shared / "botanic-garden-bubble-0.obj",
        shared / "half-hull.step",
    ]
    cases += [(f.name, lambda f=f: read_surface(f)) for f in files if f.is_file()]
    print(f"{'surface':32s} {'kind':16s} {'set-up s':>9s} {'closest s':>10s}")
    for name, make in cases:
        setup, surface = timed(make)
        points = surface.sample(QUERIES).point
        off = np.random.default_rng(0).normal(size=points.shape) * 0.003 * surface.size
        runs = [timed(lambda s=surface, x=points + off: s.closest(x))[0] for _ in range(5)]
        kind = type(surface).__name__
        print(f"{name:32s} {kind:16s} {setup:9.2f} {statistics.median(runs):10.2f}")


if __name__ == "__main__":
    main()
