"""How large the review page is and how fast Chromium shows it.

Run `python tests/benchmarks/bench_page.py`.
A made-up record: every panel with its cell, four fixings, a flat part of lines and bend lines, two
holes, setting-out and a place on a sheet. Headless, WebGL in software; median of three loads.
"""

from __future__ import annotations

import shutil
import statistics
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "review"))

from review_synthetic import record

from fabgeo.review.page import write_page

GL = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SIZES = ((25, 20), (60, 60))
RUNS = 3


def main() -> None:
    """Print a table: panels, size, seconds to write, to load, and first frame included."""
    from playwright.sync_api import sync_playwright

    print("| panels | MB | written in s | ready in s | drawn in s |")
    print("|---:|---:|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as play:
        browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=GL)
        for strips, cells in SIZES:
            made = record(strips, cells)
            begin = time.perf_counter()
            path = write_page(Path(folder) / f"{strips}.html", made)
            written = time.perf_counter() - begin
            ready, drawn = [], []
            for _ in range(RUNS):
                page = browser.new_page(viewport={"width": 1400, "height": 900})
                begin = time.perf_counter()
                page.goto(path.as_uri())
                page.wait_for_selector("body[data-ready]", timeout=120_000)
                ready.append(time.perf_counter() - begin)
                page.evaluate("() => new Promise(done => requestAnimationFrame(() => done(0)))")
                page.screenshot()
                drawn.append(time.perf_counter() - begin)
                page.close()
            size = path.stat().st_size / 1e6
            print(f"| {strips * cells} | {size:.2f} | {written:.1f} | "
                  f"{statistics.median(ready):.1f} | {statistics.median(drawn):.1f} |")  # fmt: skip
        browser.close()


if __name__ == "__main__":
    main()
