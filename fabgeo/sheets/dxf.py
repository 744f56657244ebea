"""DXF files that machines take: one part a file and whole sheets, to the hand-over contract.

Glossary
--------
layer
    CUT_OUTER, CUT_INNER, HOLES are cut; RULINGS are bend lines; MARK holds strokes; SHEET is the
    stock's rectangle; INFO holds live text for people and checkers. Names are the shop's to set.
bulge
    See `fabgeo.sheets.contour`.
"""

from __future__ import annotations

import pickle
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fabgeo.panels.flat import FlatEdge, FlatPart
from fabgeo.sheets.contour import Contour
from fabgeo.sheets.drawn import Drawn, drawn
from fabgeo.sheets.dxf_document import DxfStyle, Template
from fabgeo.sheets.dxf_forms import Entities
from fabgeo.sheets.preview import sheet_svg
from fabgeo.sheets.stock import Nest, Placement, Sheet

FEW = 8  # files that one process writes by itself: others take seconds to start


def write_part(part: FlatPart | Drawn, path: Path, style: DxfStyle | None = None) -> Drawn:
    """Write one part's file and, where it is bent, its bend table ``<mark>.bends.csv`` beside."""
    style = style or DxfStyle()
    made = drawn(part, style) if isinstance(part, FlatPart) else part
    template = Template.of(style)
    entities = Entities(template.forms)
    _add_part(entities, made, Placement(made.mark, 0.0, 0.0, 0.0), style)
    template.save(entities, path)
    if made.part.bends:
        table = bend_table(made.part)
        path.with_suffix(".bends.csv").write_text(table, encoding="utf-8", newline="")
    return made


def write_sheet(
    sheet: Sheet, parts: Mapping[str, FlatPart | Drawn], path: Path, style: DxfStyle | None = None
) -> None:
    """Write one nested sheet: the stock's rectangle, every part in its place, a title.

    Beside it lies its picture, ``SHEET-001.svg``.
    """
    style = style or DxfStyle()
    parts = {
        mark: drawn(part, style) if isinstance(part, FlatPart) else part
        for mark, part in parts.items()
        if mark in {placement.mark for placement in sheet.placements}
    }
    template = Template.of(style)
    entities, stock = Entities(template.forms), sheet.stock
    corners = [(0.0, 0.0), (stock.length, 0.0), (stock.length, stock.width), (0.0, stock.width)]
    vertices = np.array([(x, y, 0.0) for x, y in corners])
    entities.polyline(style.layer("SHEET"), vertices, closed=True)
    title = (
        f"{sheet.name}  {stock.material} {stock.thickness:g} mm  {stock.length:g} x "
        f"{stock.width:g}  {len(sheet.placements)} parts  {100 * sheet.utilisation:.1f} %"
    )
    entities.write(style.layer("INFO"), title, (0.0, -50.0), 30.0)
    for placement in sheet.placements:
        _add_part(entities, parts[placement.mark], placement, style)
    template.save(entities, path)
    path.with_suffix(".svg").write_text(sheet_svg(sheet, parts), encoding="utf-8", newline="")


def write_nests(
    nests: Iterable[Nest],
    parts: Mapping[str, FlatPart | Drawn],
    folder: Path,
    style: DxfStyle | None = None,
    jobs: int | None = None,
) -> list[Path]:
    """Write ``<material>_<t>mm/SHEET-001.dxf`` ... of all nests, `jobs` at a time; their paths."""
    from joblib import Parallel, delayed

    wanted: list[tuple[Sheet, Path]] = []
    for nest in nests:
        group = folder / f"{nest.material}_{nest.thickness:g}mm"
        group.mkdir(parents=True, exist_ok=True)
        wanted += [(sheet, group / f"{sheet.name}.dxf") for sheet in nest.sheets]
    own = ({p.mark: parts[p.mark] for p in sheet.placements} for sheet, _ in wanted)
    work = (
        delayed(_sheet_written)(pickle.dumps((sheet, on_it)), path, style)
        for (sheet, path), on_it in zip(wanted, own, strict=True)
    )
    Parallel(n_jobs=jobs if len(wanted) > FEW else 1, batch_size="auto")(work)
    return [path for _, path in wanted]


def write_parts(
    parts: Sequence[FlatPart | Drawn],
    folder: Path,
    style: DxfStyle | None = None,
    jobs: int | None = None,
) -> dict[str, Drawn]:
    """Write ``<mark>.dxf`` of all parts, `jobs` at a time; returns what sheets can reuse."""
    from joblib import Parallel, delayed

    folder.mkdir(parents=True, exist_ok=True)
    work = (
        delayed(_part_written)(pickle.dumps(part), folder / f"{part.mark}.dxf", style)
        for part in parts
    )
    found = Parallel(n_jobs=jobs if len(parts) > FEW else 1, batch_size="auto")(work)
    made: list[Drawn] = [pickle.loads(item) for item in found if item is not None]
    return {item.mark: item for item in made}


# To other processes go bytes that were pickled once: joblib would look at each array by itself.


def _sheet_written(data: bytes, path: Path, style: DxfStyle | None) -> None:
    sheet, parts = pickle.loads(data)
    write_sheet(sheet, parts, path, style)


def _part_written(data: bytes, path: Path, style: DxfStyle | None) -> bytes:
    return pickle.dumps(write_part(pickle.loads(data), path, style))


def bend_table(part: FlatPart) -> str:
    """CSV of the bend lines: number, ends, length, radius (signed, towards the up-side)."""
    ends = np.array([[*bend.start, *bend.end] for bend in part.bends]).reshape(-1, 4)
    length = np.hypot(*(ends[:, 2:] - ends[:, :2]).T)
    rows = np.column_stack([ends, length, [bend.radius for bend in part.bends]])
    lines = ["bend,x1_mm,y1_mm,x2_mm,y2_mm,length_mm,radius_mm"]
    lines += [f"{k}," + ",".join(f"{v:.3f}" for v in row) for k, row in enumerate(rows.tolist(), 1)]
    return "\n".join(lines) + "\n"


def _add_part(entities: Entities, made: Drawn, placement: Placement, style: DxfStyle) -> None:
    part, move = made.part, _motion(placement)
    # Lines alone are an outline as anyone draws one: a polyline.
    if style.outline == "splines" and any(len(edge.points) > 2 for edge in part.outline):
        for edge in part.outline:
            _spline(entities, edge, move, style.layer("CUT_OUTER"))
    else:
        _contour(entities, made.outer, placement, style.layer("CUT_OUTER"))
    for hole, contour in zip(part.holes, made.holes, strict=True):
        if hole.slot > 0.0:
            _contour(entities, contour, placement, style.layer("HOLES"))
        else:
            centre = move(hole.centre[None])[0]
            entities.circle(style.layer("HOLES"), centre, hole.diameter / 2.0)
    for bend in part.bends:
        entities.line(style.layer("RULINGS"), *move(np.stack([bend.start, bend.end])).tolist())
    label = made.label
    if label.strokes:
        points = move(np.concatenate(label.strokes))
        vertices = np.column_stack([points, np.zeros(len(points))])
        for own in np.split(vertices, np.cumsum([len(stroke) for stroke in label.strokes[:-1]])):
            entities.polyline(style.layer("MARK"), own, closed=False)
    # The text stands small under its strokes, within the room they were given.
    down = 0.64 * label.height * np.array([np.sin(label.angle), -np.cos(label.angle)])
    at = move((label.centre + down)[None])[0]
    degrees = float(np.degrees(label.angle + placement.rotation))
    entities.write(style.layer("INFO"), part.mark, at, 0.13 * label.height or 2.5, degrees)


def _motion(placement: Placement) -> Any:
    c, s = np.cos(placement.rotation), np.sin(placement.rotation)
    turn, shift = np.array([[c, s], [-s, c]]), np.array([placement.x, placement.y])
    return lambda points: np.asarray(points) @ turn + shift


def _contour(entities: Entities, contour: Contour, placement: Placement, layer: str) -> None:
    moved = contour.moved(placement.x, placement.y, placement.rotation)
    entities.polyline(layer, moved.vertices, closed=True)


def _spline(entities: Entities, edge: FlatEdge, move: Any, layer: str) -> None:
    """The edge exactly: its Hermite curves as one cubic B-spline with double inner knots."""
    if len(edge.points) == 2:
        entities.line(layer, *move(edge.points).tolist())
        return
    h = np.diff(edge.arc)[:, None]
    leave = edge.points[:-1] + h * edge.tangents[:-1] / 3.0
    arrive = edge.points[1:] - h * edge.tangents[1:] / 3.0
    inner = np.stack([leave, arrive], axis=1).reshape(-1, 2)
    poles = move(np.concatenate([edge.points[:1], inner, edge.points[-1:]]))
    knots = np.concatenate([[edge.arc[0]] * 4, np.repeat(edge.arc[1:-1], 2), [edge.arc[-1]] * 4])
    entities.spline(layer, poles, knots)
