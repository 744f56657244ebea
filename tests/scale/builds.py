"""A small project with all kinds of parts, and packages built from it in processes of their own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

# A torus with waves: conical strips, so that panels, cells and beams are all there.
ROOF = """
name = "Small roof"
[surface]
unit = "m"
u = [-0.30, 0.30]
v = [-0.45, 0.45]
x = "8*(1 + r*cos(v)) * sin(u)"
y = "8*r * sin(v)"
z = "8*(1 + r*cos(v)) * cos(u)"
[surface.define]
r = "1 + 0.004*sin(5*u + 1)*cos(4*v)"
[strips]
kind = "conical"
count = 4
start = "iso"
direction = "v"
segments = 8
[panels]
count = 3
tolerance = 5.0
[cells]
depth = -150.0
[beams]
depth = 140.0
flange_width = 100.0
[nesting]
seconds = 5.0
steps = 1
[[stock]]
material = "aluminium"
length = 6000.0
width = 2500.0
[[stock]]
material = "steel"
length = 12000.0
width = 2500.0
"""


def start(folder: Path, text: str, *arguments: str, name: str = "out") -> subprocess.Popen[str]:
    """`fabgeo build` into folder/name."""
    (folder / "project.toml").write_text(text)
    command = [sys.executable, "-m", "fabgeo.cli", "build", str(folder / "project.toml")]
    return subprocess.Popen(
        [*command, "--out", str(folder / name), "--json", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "SOURCE_DATE_EPOCH": "1700000000"},
        # Where tests run in the background, interrupts may be ignored.
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
    )


def build(folder: Path, text: str, *arguments: str, name: str = "out") -> None:
    """Build to the end."""
    process = start(folder, text, *arguments, name=name)
    out, err = process.communicate(timeout=800)
    assert process.returncode in (0, 1), out[-2000:] + err[-2000:]


def files(out: Path) -> dict[str, bytes]:
    """All files of a package by name."""
    return {
        path.relative_to(out).as_posix(): path.read_bytes()
        for path in sorted(out.rglob("*"))
        if path.is_file() and ".fabgeo" not in path.parts
    }


def entries(out: Path) -> dict[str, int]:
    """Entries of the cache and the time each was written."""
    return {
        f"{path.parent.name}/{path.name}": path.stat().st_mtime_ns
        for path in (out / ".fabgeo/cache").glob("*/*")
    }
