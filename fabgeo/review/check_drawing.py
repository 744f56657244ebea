"""What stands on which layer of a DXF file, and whether the engraved marks read as they should.

Glossary
--------
cut layer
    CUT_OUTER, CUT_INNER, HOLES: a machine cuts all that stands there, so closed curves alone may.
strokes
    The polylines of layer MARK: a mark's letters in single strokes, then its up-side arrow.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import shapely

from fabgeo.arrays import Array
from fabgeo.review.dxf_text import Drawing
from fabgeo.review.findings import Findings
from fabgeo.review.package import WrittenPackage

CUT_LAYERS = ("CUT_OUTER", "CUT_INNER", "HOLES")
LAYERS = (*CUT_LAYERS, "RULINGS", "MARK", "SHEET", "INFO")
LIKE = 0.05  # of a capital's height: strokes off the letters of the mark
ROOM = 25.0  # mm from a part's outline: where so much is free, a mark has place


def check_layers(
    package: WrittenPackage, drawing: Drawing, subject: str, findings: Findings, name: str
) -> None:
    """Millimetres; closed curves on cut layers, text on INFO, nothing on layers of no meaning."""
    unit = None if package.setting("cutting", "version", "R2010") == "R12" else 4
    if drawing.unit not in (unit, 4):
        findings.add(subject, "$INSUNITS", 4, drawing.unit or "none", name)
    cut, info = {package.layer(own) for own in CUT_LAYERS}, package.layer("INFO")
    used = {layer for layer, *_ in drawing.lines} | {curve.layer for curve in drawing.curves}
    for layer in sorted(used - {package.layer(own) for own in LAYERS}):
        findings.add(subject, "layer", "one of the shop's", layer, name)
    joined = {curve.layer for curve in drawing.curves if curve.joined}
    for layer in sorted({layer for layer, *_ in drawing.lines if layer in cut - joined}):
        findings.add(subject, f"layer {layer}", "closed curves alone", "a single line", name)
    for layer in sorted({c.layer for c in drawing.curves if not c.closed and c.layer in cut}):
        if layer != package.layer("CUT_OUTER"):  # named with its part elsewhere
            findings.add(subject, f"layer {layer}", "closed curves alone", "an open curve", name)
    for layer, text, _, _ in drawing.texts:
        if layer != info:
            findings.add(subject, f"layer {layer}", "no text", repr(text), name)
    for kind, layer in drawing.others:
        findings.add(subject, f"layer {layer}", "curves, lines and texts alone", kind, name)


def strokes_of(package: WrittenPackage, drawing: Drawing) -> list[Array]:
    """All strokes (k, 2) of a drawing."""
    layer = package.layer("MARK")
    return [curve.vertices[:, :2] for curve in drawing.curves if curve.layer == layer]


def label_of(strokes: list[Array]) -> Array:
    """Middle (2,) of an engraved mark; nan without strokes."""
    return np.concatenate(strokes).mean(axis=0) if strokes else np.full(2, np.nan)


def check_strokes(
    strokes: list[Array], mark: str, polygon: shapely.Polygon, findings: Findings, name: str
) -> None:
    """The strokes within a part's outline are its mark, of any size and however turned."""
    if not strokes and polygon.buffer(-ROOM).is_empty:
        return
    letters = _letters(mark)
    own = strokes[: len(letters)]
    if [len(stroke) for stroke in own] != [len(stroke) for stroke in letters]:
        found = "none" if not strokes else f"{len(strokes)} strokes of another text"
        findings.add(mark, "engraved mark", mark, found, name)
        return
    z, w = (points @ [1.0, 1j] for points in (np.concatenate(letters), np.concatenate(own)))
    z, w = z - z.mean(), w - w.mean()
    scale = np.vdot(z, w) / np.vdot(z, z)  # no mirror: a similarity of complex numbers
    if not np.abs(w - scale * z).max() <= LIKE * abs(scale):
        findings.add(mark, "engraved mark", mark, "other letters", name)


@cache
def _letters(text: str) -> list[Array]:
    """The strokes of a text with capitals of height 1, x to the right and y upwards."""
    return [np.array(stroke) / [21.0, -21.0] for stroke in _font().strokes_for_text(text)]


@cache
def _font() -> Any:
    from HersheyFonts import HersheyFonts

    font = HersheyFonts()
    font.load_default_font("futural")
    return font
