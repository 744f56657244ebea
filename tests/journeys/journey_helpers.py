"""The command as a user calls it, and the project of the small dome."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

DOME = """
name = "Dome"
[surface]
unit = "m"
u = [-3.0, 3.0]
v = [-4.0, 4.0]
x = "u"
y = "v"
z = "3 - 0.05*u**2 - 0.03*v**2"
[strips]
count = 4
start = "iso"
[panels]
length = 2700.0
joint = 8.0
tolerance = 3.0
[nesting]
seconds = 3.0
[[stock]]
material = "aluminium"
length = 6000.0
width = 2000.0
"""


@dataclass(frozen=True)
class Run:
    """What a run of the command said."""

    code: int
    out: str
    err: str


def fabgeo(*arguments: str | Path) -> Run:
    done = subprocess.run(
        [sys.executable, "-m", "fabgeo.cli", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    return Run(done.returncode, done.stdout, done.stderr)
