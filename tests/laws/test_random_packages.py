"""Random projects built whole: what a package says of itself is what its files measure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fabgeo import build_package
from fabgeo.errors import GeometryError, InputError
from fabgeo.review.check import check_package

MATERIALS = ("aluminium", "steel", "glass", "wood")


def _surface(rng: np.random.Generator) -> dict[str, Any]:
    """A quadric with a little of third order, turned in its plan, 2 to 9 m wide."""
    width = rng.uniform(2.0, 9.0)
    length = width * rng.uniform(1.0, 2.0)
    k1, k2 = rng.uniform(0.06, 0.6, 2) * rng.choice([-1.0, 1.0], 2) / width
    turn = rng.choice([0.0, rng.uniform(0.0, 1.5)])
    define = {
        "x1": f"u*{np.cos(turn)} + v*{np.sin(turn)}",
        "y1": f"v*{np.cos(turn)} - u*{np.sin(turn)}",
    }
    third = f"({rng.uniform(-0.3, 0.3) * k1 / width})*x1**3"
    return {
        "unit": "m",
        "u": [-width / 2.0, width / 2.0],
        "v": [-length / 2.0, length / 2.0],
        "define": define,
        "x": "u",
        "y": "v",
        "z": f"({k1 / 2.0})*x1**2 + ({k2 / 2.0})*y1**2 + {third}",
    }


def _project(seed: int) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    kind = str(rng.choice(["general", "conical", "circular", "geodesic"]))
    panels: dict[str, Any] = {
        "count": int(rng.integers(2, 6)),
        "joint": float(rng.choice([0.0, 6.0, 15.0])),
        "thickness": float(rng.choice([2.0, 6.0, 12.0])),
        "material": str(rng.choice(MATERIALS)),
        "tolerance": float(rng.choice([0.5, 1.0, 3.0])),
        "choice": str(rng.choice(["single", "joint"])),
        "offset": float(rng.choice([-20.0, 0.0, 40.0])),
    }
    out = {
        "name": f"Random {seed}",
        "surface": _surface(rng),
        "strips": {"kind": kind, "count": int(rng.integers(4, 9))},
        "panels": panels,
        "nesting": {"steps": 1, "split": True},
        "cutting": {"curves": str(rng.choice(["arcs", "splines", "polylines"]))},
        "stock": [{"material": m, "length": 13_000.0, "width": 4000.0} for m in MATERIALS],
        "drawings": False,
    }
    if kind == "conical" and rng.uniform() < 0.7:
        out["beams"] = {
            "section": str(rng.choice(["I", "T", "box"])),
            "depth": float(rng.choice([120.0, 300.0])),
            "flange_width": 140.0,
            "flanges": str(rng.choice(["trajectory", "envelope"])),
            "end_plate": float(rng.choice([0.0, 12.0])),
        }
        panels["offset"] = 0.0
    return out


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_a_random_package_is_what_it_says_or_refused(seed: int, tmp_path: Path) -> None:
    """Panels off their limits are told as such; files off what they are told to be never are."""
    print(f"seed {seed}")
    refusal = None
    try:
        package = build_package(_project(seed), tmp_path / "out")
    except (GeometryError, InputError) as error:
        refusal = error
    if refusal is not None:
        print(f"refused: {refusal}")
        assert refusal.where
        assert refusal.cure
        return
    assert package.review["summary"]["invalid_solids"] == 0
    report = check_package(tmp_path / "out")
    assert report.ok, list(report.lines())
