"""drawings/panels.pdf: one page a flat part in the style of a shop drawing.

Outline to scale with overall, edge and diagonal dimensions, bend lines with radii, holes with a
table of coordinates, mark, up-side, material, thickness and mass; a view in space and the place in
the building. Beams follow: each segment's web and flanges with their holes and their camber.

Glossary
--------
page
    What one part or beam is drawn from, by itself: pages are drawn in any process, in any order.
content
    A page as PDF operators. Tables that find no room go on, on further sheets of the same page.
"""

from __future__ import annotations

import io
import os
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.arrays import Array
from fabgeo.panels.flat import FlatPart
from fabgeo.review.page_flats import contour
from fabgeo.review.paper import Box, Paper, fit, fonts
from fabgeo.review.paper_tables import Set, Table, draw_tables, flow
from fabgeo.review.paper_views import Building, draw_building, draw_place, space_view
from fabgeo.review.record import ReviewRecord, Row, Shown
from fabgeo.review.sheet_part import (
    camber_table,
    draw_flat,
    figure,
    plates_table,
    tables_of_part,
)
from fabgeo.review.verdicts import judged

PAGE = (1190.55, 841.89)  # A3 landscape, points
SIDE = Box(860, 100, 290, 265)  # tables beside the drawing
STRIP = (60.0, 110.0, 160.0, 210.0)  # heights of the strip of tables under the drawing
HIGHER = (*STRIP, 260.0, 310.0, 360.0)  # under plates of beams, which are long and narrow
WIDE = [Box(x, 100, 250, 690) for x in (50.0, 322.0, 594.0, 866.0)]  # columns of further sheets
PLACE = Box(860, 385, 290, 165)  # of the building
MOST = 6  # plates on a page
SIGNS = "²Ø–"  # letters beyond ASCII that every page may use


@dataclass(frozen=True)
class DrawnFrom:
    """What a page is drawn from.

    Attributes
    ----------
    project, number : str
        Name of the project; the page's number out of how many.
    row : Row
        Of the panel or beam.
    parts : tuple of FlatPart
        The panel's, or those of the beam's plates.
    plates : tuple of Row
        Schedule rows of a beam's plates; none for a panel.
    shown : tuple of Shown
        The same parts in space.
    window : (2, 2) array
        Lowest and highest place of the building in its picture.
    letters : str
        Those beyond ASCII of the whole file, in one order for all pages.
    """

    project: str
    number: str
    row: Row
    parts: tuple[FlatPart, ...]
    plates: tuple[Row, ...]
    shown: tuple[Shown, ...]
    window: Array
    letters: str

    @property
    def plain(self) -> tuple[Any, ...]:
        """All of it but its parts as plain data."""
        shown = tuple((part.mark, part.rails, part.normal) for part in self.shown)
        given = (self.project, self.number, dict(self.row), self.letters, self.window)
        return (*given, tuple(dict(row) for row in self.plates), shown)


def write_panel_drawings(
    path: Path, record: ReviewRecord, contents: Iterable[tuple[str, ...]] | None = None
) -> Path:
    """Write the drawings of all panels, then of all beams.

    Equal records give equal files; SOURCE_DATE_EPOCH sets the date in the file.

    Parameters
    ----------
    path : Path
        Usually ``DIR/drawings/panels.pdf``.
    record : ReviewRecord
    contents : iterable, optional
        `drawn_page` of all `pages_of` the record, where somebody has drawn them already.
    """
    pages = pages_of(record)
    path.parent.mkdir(parents=True, exist_ok=True)
    canvas = _canvas(str(path), _letters(record))
    canvas.setTitle(f"{record.name}: panels")
    canvas.setAuthor("fabgeo")
    paper = Paper(canvas, PAGE)
    draw_building(paper, PLACE, building_of(record))
    for page, content in zip(pages, contents or map(drawn_page, pages), strict=True):
        mark = str(page.row["mark"])
        for number, words in enumerate(content or ("",)):
            if number == 0:
                canvas.bookmarkPage(mark)
                canvas.addOutlineEntry(mark, mark, 0)
                canvas.doForm("building")
            canvas.addLiteral(words)
            if not words:
                paper.text(60, 780, f"{mark} could not be drawn.", 12)
            canvas.showPage()
    if not pages:
        paper.text(60, 780, "No flat parts were asked for.", 12)
        canvas.showPage()
    canvas.save()
    return path


def pages_of(record: ReviewRecord) -> list[DrawnFrom]:
    """What every page is drawn from, in their order."""
    record = judged(record)
    shown = {part.mark: part for part in record.shown}
    plates: dict[str, list[Row]] = defaultdict(list)
    for row in record.plates:
        if row["mark"] in record.flats:
            plates[str(row.get("parent"))].append(row)
    wanted: list[tuple[Row, list[Row]]] = [
        (row, []) for row in record.panels if row["mark"] in record.flats
    ]
    for row in record.beams:
        own = plates[str(row["mark"])]
        wanted += [(row, own[k : k + MOST]) for k in range(0, len(own), MOST)]
    window, letters = building_of(record).window, _letters(record)
    pages = []
    for number, (row, own) in enumerate(wanted, start=1):
        marks = [str(plate["mark"]) for plate in own or [row]]
        parts = tuple(_bare(record.flats[mark]) for mark in marks)
        there = tuple(shown[mark] for mark in marks if mark in shown)
        count = f"{number} / {len(wanted)}"
        page = DrawnFrom(record.name, count, row, parts, tuple(own), there, window, letters)
        pages.append(page)
    return pages


def building_of(record: ReviewRecord) -> Building:
    """The picture of the building: its panels, or all there is."""
    skin = [part for part in record.shown if part.family == "panels"]
    return Building.of(skin or list(record.shown))


def drawn_page(page: DrawnFrom) -> tuple[str, ...]:
    """The contents of a page: the drawing, and further sheets of tables where it has many."""
    paper = Paper(_canvas(io.BytesIO(), page.letters), PAGE)
    tables = list(_tables(page))
    found, rest = _set(tables, HIGHER if page.plates else STRIP)
    strip = max((s.y + 7.0 - SIDE.y for s in found if s.x < SIDE.x), default=0.0)
    sheets = [found]
    while rest:
        found, rest = flow(rest, WIDE)
        sheets.append(found)
    contents = []
    for k, sheet in enumerate(sheets):
        paper.frame()
        scale = _drawing(paper, page, strip) if k == 0 else None
        draw_tables(paper, sheet)
        number = f"{page.number}, sheet {k + 1} of {len(sheets)}" if sheets[1:] else page.number
        _title(paper, page, scale, number)
        contents.append(paper.canvas.getCurrentPageContent())
        paper.canvas.showPage()
    return tuple(contents)


def _set(tables: list[Table], strips: tuple[float, ...]) -> tuple[list[Set], list[Table]]:
    """Tables beside the drawing and, if that is not enough, in a strip under it."""
    found, rest = flow(tables, [SIDE])
    for high in strips:
        if not rest:
            break
        under = [Box(x, SIDE.y, 250, high) for x in (50.0, 312.0, 574.0)]
        found, rest = flow(tables, [SIDE, *under])
    return found, rest


def _tables(page: DrawnFrom) -> Iterator[Table]:
    if not page.plates:
        yield from tables_of_part(page.parts[0])
        return
    yield plates_table(page.plates)
    for part in page.parts:
        yield camber_table(part)
    for part in page.parts:
        yield from tables_of_part(part, holes_only=True)


def _drawing(paper: Paper, page: DrawnFrom, strip: float) -> float:
    """Flat parts over the strip, views beside them; returns the scale."""
    paper.heading(860, 790, "In space, outer side" if not page.plates else "In space")
    space_view(paper, Box(860, 590, 290, 185), page.shown)
    paper.heading(860, 565, "Place in the building")
    draw_place(paper, PLACE, page.window, page.shown)
    low = 100.0 + strip
    if not page.plates:
        return draw_flat(paper, Box(50, low + 5.0, 770, 785.0 - low), page.parts[0])
    # Developments of a segment's plates under each other, at one scale.
    sizes = np.array([np.ptp(contour(part), axis=0) for part in page.parts])
    room = Box(0, 0, 700, 790.0 - low - 66.0 * len(page.parts))
    scale = fit(room, sizes[:, 0].max(), sizes[:, 1].sum())
    top = 790.0
    for part, plate, size in zip(page.parts, page.plates, sizes, strict=True):
        high = float(size[1] / scale) * 72.0 / 25.4 + 56.0
        sheet = f", {_sheet(plate)}" if plate.get("sheet") else ""
        words = f"{part.mark}   t = {part.thickness:g} mm, {part.material}{sheet}"
        paper.heading(50, top, words)
        draw_flat(paper, Box(50, top - high, 770, high - 6.0), part, scale, small=True)
        top -= high + 8.0
    return scale


def _title(paper: Paper, page: DrawnFrom, scale: float | None, number: str) -> None:
    """The title block."""
    row = page.row
    fields: list[tuple[str, object]] = [("Project", page.project), ("Mark", row["mark"])]
    if not page.plates:
        part = page.parts[0]
        fields += [
            ("Material", part.material),
            ("Thickness", f"{part.thickness:g} mm"),
            ("Class", row.get("class") or "–"),
            ("Forming", row.get("forming") or "–"),
            ("Net area", f"{part.area / 1e6:.4f} m²"),
            ("Sheet", _sheet(row)),
        ]
    else:
        fields += [("Length", f"{figure(row.get('length_mm'), 1)} mm")]
    fields += [
        ("Mass", f"{figure(row.get('mass_kg'), 2)} kg"),
        ("Verdict", row.get("verdict") or "–"),
        ("Scale", "–" if scale is None else f"1 : {scale:g}"),
        ("Page", number),
    ]
    paper.title_block(fields, "Seen on the up-side (outer side). Net size, all dimensions in mm.")


def _sheet(row: Row) -> str:
    return str(row.get("sheet") or "–").rsplit("/", 1)[-1]


def _bare(part: FlatPart) -> FlatPart:
    """A flat part without what is not drawn."""
    return replace(part, certificate={}, refold=None, contour=None)


def _letters(record: ReviewRecord) -> str:
    """Letters beyond ASCII that the pages may hold."""
    tables = (record.panels, record.plates, record.beams)
    words = {v for rows in tables for row in rows for v in row.values() if isinstance(v, str)}
    every = "".join({*words, record.name, SIGNS})
    return "".join(sorted({letter for letter in every if ord(letter) > 126}))


def _canvas(target: Any, letters: str) -> Any:
    """A canvas that numbers its fonts and their letters as all others of the file do.

    A form that is never shown uses them first, in one order.
    """
    from reportlab import rl_config
    from reportlab.pdfgen.canvas import Canvas

    rl_config.useA85 = 0  # streams as bytes: a fifth smaller and quicker than as letters
    invariant = 0 if os.environ.get("SOURCE_DATE_EPOCH") else 1
    canvas = Canvas(target, pagesize=PAGE, invariant=invariant, pageCompression=1)
    canvas.beginForm("letters")
    for font in fonts():
        canvas.setFont(font, 8.0)
        canvas.drawString(0, 0, letters)
    canvas.endForm()
    return canvas
