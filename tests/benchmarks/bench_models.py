"""Figures of conical, circular and geodesic models on surfaces that no model was made for.

Run: python tests/benchmarks/bench_models.py [conical | circular | geodesic | all] [obj file ...].
Angles in degrees, lengths in mm; mesh files given are references of conical fits besides. Figures
are medians of five surfaces, whose curvatures are up to 5 % off those named; files are fitted once.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from fabgeo.arrays import Array
from fabgeo.cad.read_surface import read_surface
from fabgeo.errors import FabgeoError
from fabgeo.fitting import FitResult, fit
from fabgeo.fitting.planks import opposite_congruence
from fabgeo.fitting.starts import start
from fabgeo.strips.circular import to_circular, to_conical
from fabgeo.strips.measures import Measures, Worst, measure
from fabgeo.strips.model import StripModel
from fabgeo.strips.offset import offset
from fabgeo.surfaces.base import DesignSurface
from fabgeo.surfaces.formula import FormulaSurface

FIXTURES = Path(__file__).resolve().parents[2] / "fixtures"
STRIPS, SEGMENTS = 16, 24
CASES, JITTER = 5, 0.05
DEPTH = 300.0
CURVATURES = {  # normal curvatures at the middle along x and y, a twist, in 1 / m
    "dome": (0.05, 0.15, 0.0),
    "dome, slender": (0.03, 0.30, 0.0),
    "dome, askew": (0.05, 0.15, 0.03),
    "saddle": (0.05, -0.10, 0.0),
    "saddle, slender": (0.03, -0.30, 0.0),
    "saddle, deep": (0.30, -0.30, 0.0),
    "saddle, askew": (0.05, -0.10, 0.04),
}


def quadric(name: str, seed: int) -> FormulaSurface:
    """z = -(a x^2 + b y^2) / 2 + c x y over 10 x 10 m, the first seed without jitter."""
    jitter = np.random.default_rng(seed).uniform(-JITTER, JITTER, 3) if seed else np.zeros(3)
    a, b, c = np.array(CURVATURES[name]) * (1.0 + jitter)
    formula = f"-({a}*u**2 + {b}*v**2) / 2 + {c}*u*v"
    return FormulaSurface("u", "v", formula, (-5.0, 5.0), (-5.0, 5.0), scale=1000.0, name=name)


def surfaces(files: list[str]) -> Iterator[Sequence[DesignSurface]]:
    """The cases, each with the surfaces that its figures are medians of."""
    yield from ([quadric(name, seed) for seed in range(CASES)] for name in CURVATURES)
    yield [read_surface(FIXTURES / "canopy" / "canopy.step")]
    yield from ([read_surface(file)] for file in files)


type Fitted = tuple[FitResult, list[float]]


def row(cases: Sequence[DesignSurface], fitted: Callable[[DesignSurface], Fitted]) -> None:
    """One line of a table: the case, medians of its CPU seconds and figures, what went wrong."""
    rows, told = [], []
    for surface in cases:
        begin = time.process_time()
        try:
            result, figures = fitted(surface)
        except FabgeoError as error:
            told.append(str(error))
            continue
        rows.append([time.process_time() - begin, *figures])
        if result.status != "converged":
            told.append(f"{result.status}: {result.reason}")
    seconds, *medians = np.median(rows, axis=0) if rows else [np.nan]
    words = " ".join(f"{x:10.2e}" for x in medians)
    short = f"  {len(told)} of {len(cases)} {told[0]}" if told else ""
    print(f"{cases[0].name:24s} {seconds:6.1f} {words}{short}", flush=True)


def fitted(surface: DesignSurface, method: str, kind: str) -> tuple[FitResult, Measures]:
    begun = start(surface, method, STRIPS, SEGMENTS)
    result = fit(begun.reference, begun.model, kind)  # pyright: ignore[reportArgumentType]
    return result, measure(result.model, surface)


def value(found: Worst | None) -> float:
    return found.value if found else np.nan


def ruling_error(model: StripModel) -> float:
    """How far rulings of both offsets are off their distance, over that distance."""
    return max(offset(model, d).errors.ruling for d in (DEPTH, -DEPTH)) / DEPTH


def back(model: StripModel, circular: StripModel) -> float:
    """How far the conical model over the circular one lies from the one it came from."""
    u, again = model.parameters(4), to_conical(circular)
    finer = again.segments / model.segments  # conversions halve segments where it takes it
    gap: Array = np.linalg.norm(again.points(u * finer) - model.points(u)[1:-1], axis=-1)
    return float(gap.max())


def conical(files: list[str]) -> None:
    print("conical                      s  twist      conical    offset / d dev / sag")

    def figures(surface: DesignSurface) -> Fitted:
        result, found = fitted(surface, "principal", "conical")
        figures = [found.twist_deg.value, value(found.conicality), ruling_error(result.model)]
        return result, [*figures, found.deviation_over_sag_limit or 0.0]

    for cases in surfaces(files):
        row(cases, figures)


def circular(files: list[str]) -> None:
    print("circular                     s  twist      circular   vertex / d | of the conical one:")
    print("                                                                 twist circular back mm")

    def figures(surface: DesignSurface) -> Fitted:
        result, found = fitted(surface, "principal", "circular")
        vertex = offset(result.model, DEPTH).errors.vertex / DEPTH
        cones, _ = fitted(surface, "principal", "conical")
        made = to_circular(cones.model)
        turned = measure(made)
        values = [found.twist_deg.value, np.degrees(found.circularity.value), vertex]
        of_cones = [turned.twist_deg.value, np.degrees(turned.circularity.value)]
        return result, [*values, *of_cones, back(cones.model, made)]

    for cases in surfaces(files):
        row(cases, figures)


def geodesic(files: list[str]) -> None:
    print("geodesic                     s  twist      geodesic   congruent  dev / sag")

    def figures(surface: DesignSurface) -> Fitted:
        result, found = fitted(surface, "geodesic", "geodesic")
        congruent = float(opposite_congruence(result.model).max())
        values = [found.twist_deg.value, np.degrees(value(found.geodesic)), congruent]
        return result, [*values, found.deviation_over_sag_limit or 0.0]

    for cases in surfaces(files):
        row(cases, figures)


if __name__ == "__main__":
    tables = {"conical": conical, "circular": circular, "geodesic": geodesic}
    asked = sys.argv[1] if len(sys.argv) > 1 else "all"
    for name, table in tables.items():
        if asked in (name, "all"):
            table(sys.argv[2:])
