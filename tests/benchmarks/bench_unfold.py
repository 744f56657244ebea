"""Time of unfolding with certificates and of writing part files, per part and for 3,600 parts.

Run: python tests/benchmarks/bench_unfold.py [parts]
     python tests/benchmarks/bench_unfold.py whole [parts]     the wall clock, two processes
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from fabgeo import spline
from fabgeo.panels.flat import FlatPart
from fabgeo.panels.unfold import unfold
from fabgeo.sheets.drawn import with_contour
from fabgeo.sheets.dxf import DxfStyle, drawn, write_nests, write_part, write_parts
from fabgeo.sheets.stock import Nest, Placement, Sheet, Stock
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Hole

ALL = 3600


def patch(k: int) -> RuledPatch:
    """A slightly different conical panel for every number: about 2 m x 0.7 m, four knot spans."""
    random = np.random.default_rng(k)
    radius, slope, reach = random.uniform(4e3, 2e4), random.uniform(-0.2, 0.2), 700.0
    knots = spline.clamped_knots(0.0, 1.0, 4)
    u = spline.greville(knots)
    angle = u * 2000.0 / radius

    def ring(v: float) -> np.ndarray:
        r = radius * (1.0 + slope * v / radius)
        return np.stack([r * np.cos(angle), r * np.sin(angle), v + 30.0 * np.sin(2 * u)], axis=-1)

    return RuledPatch.through(knots, u, ring(0.0), ring(reach))


def hole_in(mid: RuledPatch) -> Hole:
    at = mid.points(np.array([0.3]), np.array([0.5]))[0]
    a, b = mid.edges(np.array([0.3]))[:, 0]
    along = mid.edges(np.array([0.3]), 1).mean(axis=0)[0]
    axis = np.cross(along, b - a)
    return Hole(at, axis / np.linalg.norm(axis), 14.0)


def main(count: int) -> None:
    mids = [patch(k) for k in range(count)]
    holes = [hole_in(mid) for mid in mids]
    start = time.process_time()
    parts: list[FlatPart] = [
        unfold(mid, f"P-{k:04d}", "al", 3.0, [hole])
        for k, (mid, hole) in enumerate(zip(mids, holes, strict=True))
    ]
    report("unfold with certificate", time.process_time() - start, count)
    for key in ("edge_length_error_mm", "area_error_rel", "stretch_max", "refold_error_mm"):
        worst = max(part.certificate[key] for part in parts)
        print(f"    worst {key} {worst:.2g}")
    style = DxfStyle()
    start = time.process_time()
    made = [drawn(part, style) for part in parts]
    report("arcs and marks", time.process_time() - start, count)
    pieces = [len(item.outer.vertices) for item in made]
    print(f"    lines and arcs a part {np.mean(pieces):.1f}")
    with tempfile.TemporaryDirectory() as folder:
        write_part(parts[0], Path(folder) / "warm.dxf", style)  # imports and the template
        start = time.process_time()
        for part in parts:
            write_part(part, Path(folder) / f"{part.mark}.dxf", style)
        report("part files, arcs included", time.process_time() - start, count)


def whole(count: int) -> None:
    """Unroll all parts, then write all files and sheets of five parts, two processes each time."""
    from joblib import Parallel, delayed

    work = [(f"P-{k:04d}", mid, hole_in(mid)) for k, mid in enumerate(map(patch, range(count)))]
    style = DxfStyle()
    start = time.perf_counter()
    found = Parallel(n_jobs=2)(delayed(one)(*w, style) for w in work)
    parts = [part for part in found if part is not None]
    print(f"{count} parts with certificates and arcs {time.perf_counter() - start:.1f} s")
    stock = Stock("4000", "al", 3.0, 4000.0, 4000.0)
    sheets = [
        Sheet(
            f"SHEET-{k:03d}",
            stock,
            tuple(
                Placement(part.mark, 10.0, 10.0 + 780.0 * j, 0.0)
                for j, part in enumerate(parts[5 * k : 5 * k + 5])
            ),
            0.5,
        )
        for k in range(count // 5)
    ]
    nest = Nest("al", 3.0, tuple(sheets), {}, 0.5, 6.0, 10.0)
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        made = write_parts(parts, Path(folder) / "parts", style, 2)
        write_nests([nest], made, Path(folder) / "nests", style, 2)
        seconds = time.perf_counter() - start
        files = len(list(Path(folder).rglob("*.dxf")))
    print(f"{files} DXF files, with pictures of sheets and bend tables {seconds:.1f} s")
    print(f"load {os.getloadavg()[0]:.1f}")


def one(mark: str, mid: RuledPatch, hole: Hole, style: DxfStyle) -> FlatPart:
    return with_contour(unfold(mid, mark, "al", 3.0, [hole]), style)


def report(what: str, seconds: float, count: int) -> None:
    print(
        f"{what:28s} {1e3 * seconds / count:7.2f} ms a part, "
        f"{ALL * seconds / count:6.1f} CPU s for {ALL}, "
        f"{ALL * seconds / count / 2:5.1f} s on 2 cores"
    )


if __name__ == "__main__":
    if sys.argv[1:2] == ["whole"]:
        whole(int(sys.argv[2]) if len(sys.argv) > 2 else ALL)
    else:
        main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
