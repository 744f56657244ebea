"""Nesting figures on the shared instances: sheets, area bought, strip densities.

Run: python tests/benchmarks/bench_nest.py sheets|stocks|strip [seconds] [name]
     python tests/benchmarks/bench_nest.py steps [tries a sheet]
The wall clock limits engines: note the CPU seconds and how busy the machine is.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "sheets"))
from sheet_parts import shared_panels, shared_strip

from fabgeo.sheets.biarc import part_contour
from fabgeo.sheets.nest import nest
from fabgeo.sheets.pieces import piece_of
from fabgeo.sheets.stock import Stock
from fabgeo.sheets.strip import nest_strip
from fabgeo.sheets.verify import check_nest

START = time.monotonic()
DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
ONE = [Stock("3000", "al", 3.0, 3000.0, 1500.0)]
THREE = [
    Stock("2500", "al", 3.0, 2500.0, 1250.0),
    *ONE,
    Stock("4000", "al", 3.0, 4000.0, 2000.0),
]


def sheets(stocks: list[Stock], seconds: float, steps: int | None = None) -> None:
    parts = shared_panels(DATA, 200)
    used = sum(part.area for part in parts)
    long = sum(
        part_contour(part).bounds()[2] - part_contour(part).bounds()[0] > 1500 for part in parts
    )
    usable = 2980.0 * 1480.0
    print(f"bounds on 3000 x 1500: area {-(-used // usable):.0f} sheets; {long} of 200 over half")
    start, cpu = time.monotonic(), time.process_time()
    (made,) = nest(parts, stocks, 6.0, 10.0, seconds=seconds, steps=steps, listener=told)
    problems = check_nest(made, {part.mark: part_contour(part) for part in parts})
    bought = sum(sheet.stock.length * sheet.stock.width for sheet in made.sheets) / 1e6
    print(
        f"{len(made.sheets)} sheets, {bought:.2f} m2 bought for {used / 1e6:.2f} m2, "
        f"{100 * made.utilisation:.1f} %, problems {problems}, unplaced {made.unplaced}"
    )
    tell(start, cpu)


def strip(name: str, seconds: float) -> None:
    parts, width = shared_strip(DATA, name)
    start, cpu = time.monotonic(), time.process_time()
    made = nest_strip([piece_of(part, growth=1e-6 * width) for part in parts], width, 0.0, seconds)
    print(f"{name}: density {100 * made.density:.1f} % by {made.engine}, length {made.length:.1f}")
    tell(start, cpu)


def told(words: str) -> None:
    print(f"{time.monotonic() - START:6.1f} s  {words}", flush=True)


def tell(start: float, cpu: float) -> None:
    print(
        f"wall {time.monotonic() - start:.0f} s, CPU {time.process_time() - cpu:.0f} s, "
        f"load {os.getloadavg()[0]:.1f}"
    )


if __name__ == "__main__":
    case = sys.argv[1] if len(sys.argv) > 1 else "sheets"
    amount = float(sys.argv[2]) if len(sys.argv) > 2 else 60.0
    if case == "strip":
        for one in sys.argv[3:] or ["albano", "dagli", "mao", "shirts"]:
            strip(one, amount)
    elif case == "steps":
        sheets(ONE, 0.0, steps=int(amount))
    else:
        sheets(THREE if case == "stocks" else ONE, amount)
