"""Time of a fit against its unknowns, and against scipy's trust-region solver.

Run: python tests/benchmarks/bench_fit.py [small | all | scipy] [repeats]. Seconds are CPU seconds,
medians of the repeats (5); beside the table it draws bench_fit.png in the current folder.
"""

from __future__ import annotations

import resource
import sys
import time
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from scipy.optimize import least_squares

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "fitting"))

from fit_helpers import iso_start, quadric

from fabgeo.fitting import FitOptions, fit
from fabgeo.fitting.levenberg import minimise
from fabgeo.fitting.run import Run

SIZES = [(16, 24), (40, 80), (100, 200)]


def times(sizes: list[tuple[int, int]], repeats: int) -> None:
    surface = quadric(-0.5e-4, -1.5e-4)
    fit(surface, iso_start(surface, 4, 4))  # imports and first calls are not the fit's
    rows = []
    print("strips segments unknowns  seconds steps solver   twist deg  deviation/sag  MiB")
    for strips, segments in sizes:
        start = iso_start(surface, strips, segments)
        seconds = []
        for _ in range(repeats):
            begin = time.process_time()
            result = fit(surface, start)
            seconds.append(time.process_time() - begin)
        found = result.statistics
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        rows.append((found["unknowns"], float(np.median(seconds))))
        print(
            f"{strips:6d} {segments:8d} {found['unknowns']:8d} {rows[-1][1]:8.2f} "
            f"{found['steps']:5d} {found['solver']:8s} {found['twist_max_deg']:.5f}  "
            f"{found['deviation_over_sag_limit']:13.3f} {memory:5.0f}",
            flush=True,
        )
    if len(rows) > 1:
        exponent, level = np.polyfit(*np.log(np.array(rows)).T, 1)
        print(f"seconds grow with the unknowns to the power {exponent:.2f}")
        plot(np.array(rows), float(exponent), float(level))


def plot(rows: np.ndarray, exponent: float, level: float) -> None:
    """Seconds over unknowns, with the fitted power."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(5.0, 3.5), layout="constrained")
    x = np.geomspace(rows[0, 0], rows[-1, 0], 20)
    axes.loglog(x, np.exp(level) * x**exponent, "-", label=f"n^{exponent:.2f}")
    axes.loglog(*rows.T, "o", label="fits")
    axes.set(xlabel="unknowns", ylabel="CPU seconds")
    axes.legend()
    figure.savefig("bench_fit.png", dpi=120)


def against_scipy(strips: int = 16, segments: int = 24) -> None:
    """The same residuals and Jacobian, one stage at a developability weight of 10, to one cost."""
    surface = quadric(-0.5e-4, -1.5e-4)
    run = Run(surface, iso_start(surface, strips, segments), "general", FitOptions(), None)
    problem = run.level.problem(run.control, run.control, 10.0, 0.0)
    x0 = run.control.reshape(-1, 3)

    def residual(x: np.ndarray) -> np.ndarray:
        return np.concatenate([b.residual.ravel() for b in problem.blocks(x.reshape(-1, 3))])

    def jacobian(x: np.ndarray) -> sp.csr_array:
        parts = []
        for b in problem.blocks(x.reshape(-1, 3)):
            k, r = b.jacobian.shape[1:3]
            row = np.broadcast_to(np.arange(k * r).reshape(1, k, r, 1), b.jacobian.shape)
            column = b.nodes[None, :, None, :] * 3 + np.arange(3)[:, None, None, None]
            column = np.broadcast_to(column, b.jacobian.shape)
            entries = (b.jacobian.ravel(), (row.ravel(), column.ravel()))
            parts.append(sp.csr_array(entries, shape=(k * r, x.size)))
        return sp.csr_array(sp.vstack(parts))

    begin = time.process_time()
    theirs = least_squares(
        residual, x0.ravel(), jacobian, method="trf", tr_solver="lsmr", ftol=1e-6, max_nfev=200
    )
    other = time.process_time() - begin
    own = []
    for _ in range(5):  # until the same objective is reached
        begin = time.process_time()
        ours = minimise(
            problem,
            x0,
            run.level.equations(problem),
            gain=1e-9,
            listener=lambda step: step.cost > theirs.cost,
        )
        own.append(time.process_time() - begin)
    mine = float(np.median(own))
    print(f"Levenberg-Marquardt: cost {ours.cost:.6e} in {mine:.2f} s, {len(ours.steps)} steps")
    print(f"scipy trf (lsmr):    cost {theirs.cost:.6e} in {other:.2f} s, {theirs.nfev} calls")
    print(f"{other / mine:.1f} times the time")


if __name__ == "__main__":
    what = sys.argv[1] if len(sys.argv) > 1 else "all"
    if what != "scipy":
        times(SIZES[:2] if what == "small" else SIZES, int(sys.argv[2]) if sys.argv[2:] else 5)
    if what != "small":
        against_scipy()
