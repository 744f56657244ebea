"""Growth with the number of panels: seconds and memory by stage, of whole builds.

    python tests/benchmarks/bench_scale.py 36 144 506      # default; 3600 takes long
    python tests/benchmarks/bench_scale.py --jobs 2 506

The roof is a torus with waves, every panel different, conical, with cells and beams. It is as
large as its panels of about 1.5 x 2 m make it (90 x 120 m at 3,600). CPU seconds are of all
processes, so that a busy machine does not blur them.
"""

from __future__ import annotations

import argparse
import math
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROOF = """
name = "Roof of {panels} panels"
[surface]
unit = "m"
u = [-0.30, 0.30]
v = [-0.45, 0.45]
x = "{size}*(1 + r*cos(v)) * sin(u)"
y = "{size}*r * sin(v)"
z = "{size}*(1 + r*cos(v)) * cos(u) - 1.8*{size}"
[surface.define]
r = "1 + 0.006*sin(5*u + 1)*cos(4*v)"
[strips]
kind = "conical"
count = {strips}
start = "iso"
direction = "v"
segments = 12
[panels]
count = {cuts}
joint = 8.0
tolerance = 5.0
[cells]
depth = -200.0
[beams]
depth = 160.0
standoff = 60.0
flange_width = 120.0
[nesting]
seconds = {seconds}
[[stock]]
material = "aluminium"
length = 4000.0
width = 2000.0
[[stock]]
material = "steel"
length = 12000.0
width = 2500.0
"""


def roof(panels: int, seconds: float) -> str:
    """Project of a roof of about as many panels."""
    strips = max(3, round(math.sqrt(panels)))
    cuts = max(1, round(panels / strips))
    return ROOF.format(
        panels=strips * cuts, strips=strips, cuts=cuts, size=strips / 0.6, seconds=seconds
    )


def measure(project: str, out: str, jobs: int) -> None:
    """Build in this process and print a line a stage."""
    from fabgeo.build import build_package
    from fabgeo.build.progress import Progress

    spent = [cpu()]

    def listen(news: Progress) -> None:
        if news.finished:
            now = cpu()
            print(f"  {news.stage:<11}{now - spent[0]:8.1f} CPU s", flush=True)
            spent[0] = now

    package = build_package(project, out, jobs=jobs, listener=listen)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    wall = sum(package.seconds.values())
    print(
        f"  {len(package.design.panels)} panels, {len(package.built)} solids: {wall:.0f} s of wall"
    )
    print(f"  peak memory of the main process {peak:.2f} GB; {len(package.failures)} verdicts fail")


def cpu() -> float:
    """CPU seconds of this process and its workers, the living ones too."""
    ticks = 0
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if os.getpid() in (int(stat.parent.name), int(fields[1])):
            ticks += sum(map(int, fields[11:15]))
    return ticks / os.sysconf("SC_CLK_TCK")


def main() -> None:
    """Builds of growing size, each in a fresh process."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("panels", type=int, nargs="*", default=[36, 144, 506])
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--nesting", type=float, default=10.0, help="seconds of nesting")
    parser.add_argument("--twice", action="store_true", help="once more, from the cache")
    parser.add_argument("--inside", nargs=2, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.inside:
        return measure(*asked.inside, asked.jobs)
    for panels in asked.panels:
        with tempfile.TemporaryDirectory() as folder:
            project = Path(folder) / "project.toml"
            project.write_text(roof(panels, asked.nesting))
            for words in ("", " again, from the cache")[: 1 + asked.twice]:
                print(f"{panels} panels{words}", flush=True)
                inside = ["--inside", str(project), str(Path(folder) / "out")]
                command = [sys.executable, __file__, "--jobs", str(asked.jobs), *inside]
                subprocess.run(command, check=True)
    return None


if __name__ == "__main__":
    main()
