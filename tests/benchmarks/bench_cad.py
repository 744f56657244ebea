"""Seconds and memory for 1,000 cells, 1,000 panels, beams and connectors: built and written.

Run as ``python tests/benchmarks/bench_cad.py [jobs]``. Target: built in 8 s and written in 12 s
on 2 cores, under 2 GiB.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "cad"))

from cad_helpers import circles, revolution, square_hole

from fabgeo.cad import kernel
from fabgeo.cad.assembly import Node
from fabgeo.cad.connectors import fixing_product, place_connectors
from fabgeo.cad.measure import check_solid
from fabgeo.cad.plates import plate_solid
from fabgeo.cad.solids import prism_solid
from fabgeo.cad.step import write_step
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.fixing import Fixing
from fabgeo.structures.parts import Connector, Plate

STRIPS, CELLS = 40, 25


def profile(i: int) -> tuple[np.ndarray, np.ndarray]:
    """Two neighbouring points of a barrel's profile and their offsets 300 mm inside."""
    z = -10000.0 + 500.0 * np.array([i, i + 1])
    r = 12000.0 - z**2 / 40000.0
    normal = np.array([-z / 20000.0, -np.ones(2)])
    normal = normal / np.linalg.norm(normal, axis=0)
    inner = np.stack([r, z]) + 300.0 * np.array([normal[1], -normal[0]])[:, ::1]
    return np.array([r[0], r[1], inner[0, 1], inner[0, 0]]), np.array(
        [z[0], z[1], inner[1, 1], inner[1, 0]]
    )


def cells():
    step = 2.0 * np.pi / CELLS / 2.0
    return [
        revolution(f"C-{i:02d}-{j:02d}", profile(i), j * step, (j + 1) * step)
        for i in range(STRIPS)
        for j in range(CELLS)
    ]


def plates(holes: bool):
    step = 2.0 * np.pi / CELLS / 2.0
    out = []
    for i in range(STRIPS):
        r, z = profile(i)
        for j in range(CELLS):
            mark = f"P-{i:02d}-{j:02d}"
            mid = RuledPatch(*circles(r[:2] + 60.0, z[:2], j * step, (j + 1) * step))
            at = [(u, v) for u in (0.2, 0.8) for v in (0.15, 0.85)]
            drilled = [square_hole(mid, (j + u) * step, v, 14.0) for u, v in at] if holes else []
            out.append(Plate(mark, mark, "panel", mid, 4.0, "aluminium", holes=tuple(drilled)))
    return out


def beams():
    return [
        revolution(f"B-{i:02d}-{k}", _i_section(profile(i)), k * 0.8, (k + 1) * 0.8, spans=10)
        for i in range(STRIPS)
        for k in range(3)
    ]


def _i_section(points):
    r, z = points[0][0] - 400.0, points[1][0]
    half = np.array([80, 80, 5, 5, 80, 80, -80, -80, -5, -5, -80, -80.0])
    level = np.array([0, 12, 12, 288, 288, 300, 300, 288, 288, 12, 12, 0.0])
    return r + level - 300.0, z + half


def measured(name: str, work: Callable[[], object]) -> object:
    wall, cpu = time.perf_counter(), time.process_time()
    result = work()
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    print(f"{name:42s} {wall:8.2f} s wall {cpu:8.2f} s CPU {size:8.0f} MiB")
    return result


def _cell(prism) -> bytes:
    return kernel.to_bytes(prism_solid(prism))


def _plate(plate) -> bytes:
    return kernel.to_bytes(plate_solid(plate))


def main(jobs: int = 1) -> None:
    cell_prisms, panels, drilled, beam_prisms = cells(), plates(False), plates(True), beams()

    def build(function, parts):
        if jobs == 1:
            return [function(part) for part in parts]
        made = Parallel(jobs, batch_size=64)(delayed(function)(part) for part in parts)
        return [kernel.from_bytes(data) for data in made]  # type: ignore[arg-type]

    serial = jobs == 1
    solids = {}
    for name, function, parts in (
        ("cells", prism_solid if serial else _cell, cell_prisms),
        ("panels", plate_solid if serial else _plate, panels),
        ("beams", prism_solid if serial else _cell, beam_prisms),
    ):
        made = measured(f"build {len(parts)} {name}", lambda f=function, p=parts: build(f, p))
        solids[name] = (parts, made)
    measured(
        f"build {len(drilled)} panels with 4 holes each",
        lambda: build(plate_solid if serial else _plate, drilled),
    )
    reports = measured(
        "check all", lambda: [check_solid(s) for _, made in solids.values() for s in made]
    )
    print("sound:", sum(r.sound for r in reports), "of", len(reports))
    print("largest tolerance:", max(r.tolerance for r in reports), "mm")
    fixing = fixing_product(Fixing(), panel=4.0, flange=12.0)
    frames = np.repeat(np.eye(4)[None], 1000, axis=0)
    frames[:, 0, 3] = 200.0 * np.arange(1000)
    connectors = [Connector(f"K-{i}", fixing.name, f, "", "") for i, f in enumerate(frames)]
    placed = place_connectors(connectors, {fixing.name: fixing})
    groups = [
        Node(
            name,
            children=tuple(
                Node(p.mark, s, colour=(0.8, 0.7, 0.5), layer=name)
                for p, s in zip(parts, made, strict=True)
            ),
        )
        for name, (parts, made) in solids.items()
    ]
    root = Node("bench", children=(*groups, Node("connectors", children=tuple(placed))))
    with tempfile.TemporaryDirectory() as folder:
        for curves in (False, True):
            path = Path(folder) / f"{curves}.step"
            measured(
                f"write STEP, parameter curves {'on' if curves else 'off'}",
                lambda p=path, c=curves: write_step(p, root, curves_on_surfaces=c),
            )
            print(f"{'':42s} {path.stat().st_size / 1e6:8.1f} MB")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1)
