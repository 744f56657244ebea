"""Checks of a bare install: `import fabgeo` is quick and light, the maths rooms work."""

import importlib.util
import subprocess
import sys

BUDGET = 0.2  # seconds, the best of five fresh interpreters
HEAVY = ("OCP", "build123d", "cadquery", "ezdxf", "matplotlib", "trimesh")

probe = (
    "import sys, time; t = time.perf_counter(); import fabgeo; "
    "print(time.perf_counter() - t); "
    f"print([m for m in {HEAVY!r} if m in sys.modules])"
)
runs = [
    subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    for _ in range(5)
]
seconds = min(float(run.stdout.split()[0]) for run in runs)
loaded = runs[0].stdout.splitlines()[1]
print(f"import fabgeo: {seconds:.3f} s, heavy libraries loaded: {loaded}")
assert seconds < BUDGET and loaded == "[]"
for extra in ("cadquery", "rhino3dm", "ifcopenshell", "pypardiso"):
    assert importlib.util.find_spec(extra) is None, f"{extra} came along with the bare install"

import numpy as np  # noqa: E402 (after the timing above)

import fabgeo  # noqa: E402

u = np.linspace(0.0, 4.0, 9)
t = np.linspace(0.0, 4.0, 5)
row = np.stack([t, 0.1 * t**2, 0.0 * t], axis=-1)
model = fabgeo.StripModel(fabgeo.spline.interpolate(np.stack([row, row + [0.0, 0.0, 1.0]])))
assert np.abs(model.points(u)[0, :, 1] - 0.1 * u**2).max() < 1e-12
assert fabgeo.measure(model).twist_deg.value < 1e-9
print("bare install: 1 passed, 0 failed")
