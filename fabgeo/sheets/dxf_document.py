"""One empty DXF document a style, written by ezdxf once, filled many times.

Glossary
--------
template
    An empty document with the shop's layers; its text before and after the entities never changes,
    and the entities are filled into forms (`fabgeo.sheets.dxf_forms`): a tenth of the time that
    making and exporting them one by one takes. Handles start anew for every file: the same
    content gives the same bytes, whatever was written before.
"""

from __future__ import annotations

import io
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path

from fabgeo.errors import InputError
from fabgeo.sheets.dxf_forms import Entities, Forms

LAYERS: dict[str, str] = {
    name: name for name in ("CUT_OUTER", "CUT_INNER", "HOLES", "RULINGS", "MARK", "SHEET", "INFO")
}
COLOURS = {
    "CUT_OUTER": 1,
    "CUT_INNER": 6,
    "HOLES": 5,
    "RULINGS": 3,
    "MARK": 4,
    "SHEET": 8,
    "INFO": 2,
}
VERSIONS = ("R12", "R2000", "R2010")
OUTLINES = ("arcs", "splines", "polylines")


@dataclass(frozen=True)
class DxfStyle:
    """How files are written.

    Attributes
    ----------
    version : str
        "R2010", "R2000" or "R12" (POLYLINE with bulges, no splines, no unit in the header).
    outline : str
        "arcs", "splines" or "polylines".
    tolerance : float
        mm between the outline and the flat part's own curve.
    layers : mapping
        The shop's names by the contract's names; missing ones keep the contract's.
    mark_height : float
        Largest height of the mark's capitals in mm.
    """

    version: str = "R2010"
    outline: str = "arcs"
    tolerance: float = 0.05
    layers: Mapping[str, str] = field(default_factory=dict)
    mark_height: float = 20.0

    def __post_init__(self) -> None:
        if self.version not in VERSIONS:
            raise InputError("dxf.version", f"expected one of {VERSIONS}, found {self.version!r}")
        if self.outline not in OUTLINES:
            raise InputError("dxf.outline", f"expected one of {OUTLINES}, found {self.outline!r}")
        if self.version == "R12" and self.outline == "splines":
            raise InputError("dxf.outline", "R12 has no splines", 'choose "arcs" or R2000')
        if not self.tolerance > 0.0:
            raise InputError("dxf.tolerance", f"expected more than 0 mm, found {self.tolerance}")
        unknown = set(self.layers) - set(LAYERS)
        if unknown:
            raise InputError("dxf.layers", f"unknown layers {sorted(unknown)}", f"use {[*LAYERS]}")

    def layer(self, name: str) -> str:
        """The shop's name of a layer."""
        return self.layers.get(name, LAYERS[name])


START = "  0\nSECTION\n  2\nENTITIES\n"
SEED = "FFFFF"  # next free handle in the header, far above what a sheet needs


class Template:
    """The text around the entities of a style's documents, and the forms of their entities.

    Attributes
    ----------
    forms : Forms
    """

    def __init__(self, style: DxfStyle) -> None:
        from ezdxf.filemanagement import new

        with _undated():
            document = new(style.version, setup=False)
            if style.version != "R12":
                document.header["$INSUNITS"] = 4
                document.header["$MEASUREMENT"] = 1
            for name in LAYERS:
                document.layers.add(style.layer(name), color=COLOURS[name])
            document.write(io.StringIO())  # registers its classes, in the order of a set
            classes = document.classes
            classes.classes = dict(sorted(classes.classes.items()))
            out = io.StringIO()
            document.write(out)
            self.forms = Forms(document)
        seed = "$HANDSEED\n  5\n"
        text = out.getvalue().replace(f"{seed}{self.forms.first:X}\n", f"{seed}{SEED}\n")
        self._head, rest = text.split(START)
        self._tail = rest[rest.index("  0\nENDSEC\n") :]

    @staticmethod
    def of(style: DxfStyle) -> Template:
        """The template of a style, made once."""
        return _template(style.version, tuple(sorted(style.layers.items())))

    def save(self, entities: Entities, path: Path) -> None:
        """Write a document of these entities beside and move it into place."""
        text = _dated(self._head) + START + entities.text + _dated(self._tail)
        beside = path.with_name(path.name + ".part")
        beside.write_text(text, encoding=self.forms.encoding, errors="dxfreplace", newline="")
        beside.replace(path)


@lru_cache(maxsize=4)
def _template(version: str, layers: tuple[tuple[str, str], ...]) -> Template:
    return Template(DxfStyle(version=version, layers=dict(layers)))


@contextmanager
def _undated() -> Iterator[None]:
    """Let ezdxf write a fixed date and fixed identifiers."""
    from ezdxf._options import options

    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def _dated(text: str) -> str:
    """The fixed date 2000-01-01 replaced by SOURCE_DATE_EPOCH where that is set."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if not epoch:
        return text
    day = int(epoch) / 86400.0 + 2440587.5
    stamp = datetime.fromtimestamp(int(epoch), UTC).isoformat(timespec="microseconds")
    return text.replace("2451544.5", f"{day:.9f}").replace(
        "2000-01-01T00:00:00.000000+00:00", stamp
    )
