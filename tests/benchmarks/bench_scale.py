"""Growth with the number of panels: seconds and memory by stage, of whole builds.

    python tests/benchmarks/bench_scale.py 36 144 506      # default; 3600 takes long
    python tests/benchmarks/bench_scale.py --jobs 2 506

The roof is that of fixtures/hall (conical, every panel different, with cells, beams and fixings),
as large as its panels of about 1.5 x 2 m make it. CPU seconds are of all processes, so that a busy
machine does not blur them.
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

HALL = Path(__file__).resolve().parents[2] / "fixtures/hall/project.toml"
SIDE = 60  # strips of the hall, and panels a strip
SIZE = 94  # its radius in metres


def roof(panels: int, seconds: float) -> str:
    """The hall's project with about as many panels of the same size, in a part of its curvature."""
    strips = max(3, round(math.sqrt(panels)))
    cuts = max(1, round(panels / strips))
    text = HALL.read_text()
    for old, new in (
        ('size = "94"', f'size = "{SIZE * strips / SIDE:g}"'),
        ("count = 60\nsegments", f"count = {strips}\nsegments"),
        ("count = 60 ", f"count = {cuts} "),
        ("seconds = 240.0", f"seconds = {seconds:g}"),
    ):
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


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
