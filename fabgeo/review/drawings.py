"""drawings/panels.pdf: one page a flat part in the style of a shop drawing.

Outline to scale with overall, edge and diagonal dimensions, bend lines with radii, holes with a
table of coordinates, mark, up-side, material, thickness and mass; a small view in space and the
place in the building. Beams follow: each segment's web and flanges with a table of its camber.
"""

from __future__ import annotations

import os
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.panels.flat import FlatPart
from fabgeo.review.page_flats import contour
from fabgeo.review.paper import Box, Paper, fit
from fabgeo.review.paper_views import PlaceView, space_view
from fabgeo.review.record import ReviewRecord, Row, Shown
from fabgeo.review.sheet_part import draw_flat, tables_of_part
from fabgeo.review.verdicts import judged

PAGE = (1190.55, 841.89)  # A3 landscape, points


def write_panel_drawings(path: Path, record: ReviewRecord) -> Path:
    """Write the drawings of all panels, then of all beams.

    Equal records give equal files; SOURCE_DATE_EPOCH sets the date in the file.

    Parameters
    ----------
    path : Path
        Usually ``DIR/drawings/panels.pdf``.
    """
    from reportlab import rl_config
    from reportlab.pdfgen.canvas import Canvas

    rl_config.useA85 = 0  # streams as bytes: a fifth smaller and quicker than as letters
    record = judged(record)
    path.parent.mkdir(parents=True, exist_ok=True)
    invariant = 0 if os.environ.get("SOURCE_DATE_EPOCH") else 1
    canvas = Canvas(str(path), pagesize=PAGE, invariant=invariant, pageCompression=1)
    canvas.setTitle(f"{record.name}: panels")
    canvas.setAuthor("fabgeo")
    paper = Paper(canvas, PAGE)
    shown = {part.mark: part for part in record.shown}
    skin = [part for part in record.shown if part.family == "panels"]
    pages = [row for row in record.panels if row["mark"] in record.flats]
    beams = [row for row in record.beams if _plates_of(record, row)]
    total = max(len(pages) + len(beams), 1)
    overview = PlaceView(skin or list(record.shown))
    for number, row in enumerate(pages, start=1):
        _panel_page(paper, record, row, shown, overview, f"{number} / {total}")
        canvas.bookmarkPage(str(row["mark"]))
        canvas.addOutlineEntry(str(row["mark"]), str(row["mark"]), 0)
        canvas.showPage()
    for number, row in enumerate(beams, start=len(pages) + 1):
        _beam_page(paper, record, row, shown, overview, f"{number} / {total}")
        canvas.showPage()
    if not pages and not beams:
        paper.text(60, 780, "No flat parts were asked for.", 12)
        canvas.showPage()
    canvas.save()
    return path


def _panel_page(
    paper: Paper,
    record: ReviewRecord,
    row: Row,
    shown: dict[str, Shown],
    overview: PlaceView,
    number: str,
) -> None:
    mark = str(row["mark"])
    part = record.flats[mark]
    paper.frame()
    scale = draw_flat(paper, Box(50, 130, 770, 660), part)
    paper.heading(860, 790, "In space, outer side")
    space_view(paper, Box(860, 590, 290, 185), shown.get(mark))
    paper.heading(860, 565, "Place in the building")
    overview.draw(paper, Box(860, 385, 290, 165), {mark})
    tables_of_part(paper, 860, 360, part)
    _title(paper, record, row, part, scale, number)


def _beam_page(
    paper: Paper,
    record: ReviewRecord,
    row: Row,
    shown: dict[str, Shown],
    overview: PlaceView,
    number: str,
) -> None:
    """Developments of a segment's plates under each other, at one scale."""
    plates = _plates_of(record, row)
    parts = [record.flats[str(plate["mark"])] for plate in plates]
    paper.frame()
    sizes = np.array([np.ptp(contour(part), axis=0) for part in parts])
    scale = fit(Box(0, 0, 700, 600 - 60 * len(parts)), sizes[:, 0].max(), sizes[:, 1].sum())
    top = 790.0
    for part, size in zip(parts, sizes, strict=True):
        high = float(size[1] / scale) * 72.0 / 25.4 + 56.0
        paper.heading(50, top, f"{part.mark}   t = {part.thickness:g} mm, {part.material}")
        draw_flat(paper, Box(50, top - high, 770, high - 6.0), part, scale, small=True)
        top -= high + 8.0
    paper.heading(860, 790, "Place in the building")
    overview.draw(paper, Box(860, 600, 290, 175), {part.mark for part in parts}, shown)
    paper.heading(860, 570, "Camber of the plates")
    heads = ("plate", "length", "width", "camber", "radius min", "mass kg")
    lines = [
        (
            str(plate["mark"]),
            _figure(plate.get("length_mm"), 1),
            _figure(plate.get("width_mm"), 1),
            _figure(plate.get("camber_mm"), 2),
            _figure(plate.get("radius_min_mm"), 0),
            _figure(plate.get("mass_kg"), 2),
        )
        for plate in plates
    ]
    y = paper.table(860, 555, heads, lines, (82, 46, 40, 40, 48, 40))
    for part in parts:
        y = camber_table(paper, 860, y - 14, part)
    _title(paper, record, row, None, scale, number)


def camber_table(paper: Paper, x: float, y: float, part: FlatPart, stations: int = 9) -> float:
    """Rise of a plate's first long edge over its chord at even stations; the next line's y."""
    edge = next((e for e in part.outline if e.name == "first"), part.outline[0])
    if len(edge.points) < 3 or y < 190:
        return y
    chord = edge.points[-1] - edge.points[0]
    length = float(np.linalg.norm(chord))
    along = (edge.points - edge.points[0]) @ chord / length
    rise = (edge.points - edge.points[0]) @ np.array([-chord[1], chord[0]]) / length
    sites = np.linspace(0.0, length, stations)
    heights = np.interp(sites, along, rise)
    heads = (part.mark, *("" for _ in range(stations - 1)))
    lines = [
        tuple(f"{s:.0f}" for s in sites),
        tuple(f"{h + 0.0:.1f}" for h in np.round(heights, 1)),
    ]
    return paper.table(x, y, heads, lines, (32.6,) * stations)


def _title(
    paper: Paper,
    record: ReviewRecord,
    row: Row,
    part: FlatPart | None,
    scale: float,
    number: str,
) -> None:
    """The title block."""
    fields = [("Project", record.name), ("Mark", row["mark"])]
    if part is not None:
        fields += [
            ("Material", part.material),
            ("Thickness", f"{part.thickness:g} mm"),
            ("Class", row.get("class") or "–"),
            ("Forming", row.get("forming") or "–"),
            ("Net area", f"{part.area / 1e6:.4f} m²"),
        ]
    else:
        fields += [("Length", f"{_figure(row.get('length_mm'), 1)} mm")]
    fields += [
        ("Mass", f"{_figure(row.get('mass_kg'), 2)} kg"),
        ("Sheet", str(row.get("sheet") or "–").rsplit("/", 1)[-1]),
        ("Verdict", row.get("verdict") or "–"),
        ("Scale", f"1 : {scale:g}"),
        ("Page", number),
    ]
    paper.title_block(fields, "Seen on the up-side (outer side). Net size, all dimensions in mm.")


def _plates_of(record: ReviewRecord, row: Row) -> list[Row]:
    by_parent: dict[str, list[Row]] = defaultdict(list)
    for plate in record.plates:
        if plate["mark"] in record.flats:
            by_parent[str(plate.get("parent"))].append(plate)
    return by_parent[str(row["mark"])]


def _figure(value: Any, decimals: int) -> str:
    if value is None or not np.isfinite(float(value)):
        return "–"
    return f"{float(value):.{decimals}f}"
