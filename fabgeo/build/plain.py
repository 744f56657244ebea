"""Nouns as plain bytes and back: JSON with arrays behind it. Reading runs no code of the data.

Glossary
--------
noun
    One of the frozen dataclasses of `NOUNS`; nothing else is ever made from stored bytes.
blob
    The raw bytes of an array, or bytes as such, behind the JSON text.
table
    A tuple of equal nouns field by field, arrays of equal shape as one: a flat part has dozens of
    bend lines of two points each.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from hashlib import sha256
from typing import Any

import numpy as np

from fabgeo.build.built import Built
from fabgeo.cad.report import SolidReport
from fabgeo.errors import InputError
from fabgeo.fitting.fit import FitResult
from fabgeo.panels.classify import PanelChoice
from fabgeo.panels.flat import BendLine, FlatEdge, FlatHole, FlatPart
from fabgeo.panels.shapes import Cone, Cylinder, Plane
from fabgeo.sheets.stock import Nest, Placement, Sheet, Stock
from fabgeo.strips.model import Patch, StripModel
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Beam, Cell, Connector, Hole, Plate, Prism

_CLASSES = (
    *(FitResult, StripModel, Patch, RuledPatch, PanelChoice, Plane, Cylinder, Cone),
    *(Plate, Hole, Prism, Cell, Beam, Connector, FlatPart, FlatEdge, FlatHole, BendLine),
    *(Stock, Placement, Sheet, Nest, Built, SolidReport),
)
NOUNS: dict[str, type[Any]] = {cls.__name__: cls for cls in _CLASSES}
HEAD = 8  # bytes of the length of the JSON text
ALIGNED = 8  # bytes that arrays begin at a multiple of
FEW = 3  # nouns that are no table yet
_DAMAGE = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)
_NUMBERS = re.compile(r"[<>|][biufcSU]\d+")  # how numpy writes kinds of numbers and texts


def pack(value: Any) -> bytes:
    """Bytes of nouns, arrays, bytes, numbers, texts, None, and tuples, lists, mappings of them.

    Raises
    ------
    InputError
        For anything else.
    """
    blobs = bytearray()
    text = json.dumps(_plain(value, blobs), separators=(",", ":")).encode()
    text += b" " * (-len(text) % ALIGNED)
    return b"".join([len(text).to_bytes(HEAD, "big"), text, blobs])


def unpack(data: bytes, known: bool = False) -> Any:
    """The value of `pack`.

    Parameters
    ----------
    data : bytes
    known : bool
        The bytes are those that were packed, by their checksum: nouns are not checked again,
        which takes most of the time.

    Raises
    ------
    InputError
        If the bytes are damaged.
    """
    try:
        begin = HEAD + int.from_bytes(data[:HEAD], "big")
        make = _restored if known else _made
        return _noun(json.loads(data[HEAD:begin]), memoryview(data)[begin:], make)
    except _DAMAGE as error:
        raise InputError("stored data", f"is damaged: {error}") from error


def digest(*values: Any) -> str:
    """Hexadecimal sha256 over values as `pack` writes them."""
    return sha256(pack(values)).hexdigest()


def _plain(value: Any, blobs: bytearray) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        array = np.ascontiguousarray(value)
        return {"@array": [_store(array.tobytes(), blobs), array.dtype.str, list(array.shape)]}
    if isinstance(value, bytes):
        return {"@bytes": _store(value, blobs)}
    if isinstance(value, list):
        return [_plain(item, blobs) for item in value]
    if isinstance(value, tuple):
        table = _table(value, blobs) if len(value) > FEW else None
        return table or {"@tuple": [_plain(item, blobs) for item in value]}
    if isinstance(value, Mapping):
        return {"@map": [[_plain(k, blobs), _plain(v, blobs)] for k, v in value.items()]}
    if is_dataclass(value) and _is_noun(type(value)):
        kept = {f.name: _plain(getattr(value, f.name), blobs) for f in fields(value) if f.init}
        return {"@": type(value).__name__, **kept}
    raise InputError(type(value).__name__, "is not stored: expected one of fabgeo's plain nouns")


def _table(nouns: tuple[Any, ...], blobs: bytearray) -> dict[str, Any] | None:
    """Equal nouns field by field; None where they are not equal, or no nouns."""
    cls = type(nouns[0])
    if not _is_noun(cls) or any(type(noun) is not cls for noun in nouns):
        return None
    columns = {}
    for name in (f.name for f in fields(cls) if f.init):
        column = [getattr(noun, name) for noun in nouns]
        kinds = {(x.dtype, x.shape) if isinstance(x, np.ndarray) else None for x in column}
        equal = len(kinds) == 1 and None not in kinds
        columns[name] = _plain(np.array(column) if equal else column, blobs)
    return {"@table": cls.__name__, **columns}


def _is_noun(cls: type[Any]) -> bool:
    return NOUNS.get(cls.__name__) is cls


def _store(data: bytes, blobs: bytearray) -> list[int]:
    blobs += bytes(-len(blobs) % ALIGNED)
    begin = len(blobs)
    blobs += data
    return [begin, len(blobs)]


type _Make = Callable[[type[Any], dict[str, Any]], Any]


def _made(cls: type[Any], fields_of: dict[str, Any]) -> Any:
    return cls(**fields_of)


def _restored(cls: type[Any], fields_of: dict[str, Any]) -> Any:
    """A noun as it was: its arrays are bytes of the entry, which nobody can write to."""
    noun = object.__new__(cls)
    vars(noun).update(fields_of)
    return noun


def _noun(tree: Any, blobs: memoryview, make: _Make) -> Any:
    if isinstance(tree, list):
        return [_noun(item, blobs, make) for item in tree]
    if not isinstance(tree, dict):
        return tree
    if "@array" in tree:
        (begin, end), kind, shape = tree["@array"]
        if not _NUMBERS.fullmatch(kind):  # numpy would parse what it is given as Python
            raise ValueError(f"{kind!r} is no kind of array")
        return np.frombuffer(blobs[begin:end], dtype=kind).reshape(shape)
    if "@bytes" in tree:
        begin, end = tree["@bytes"]
        return bytes(blobs[begin:end])
    if "@tuple" in tree:
        return tuple([_noun(item, blobs, make) for item in tree["@tuple"]])
    if "@map" in tree:
        return {_noun(key, blobs, make): _noun(item, blobs, make) for key, item in tree["@map"]}
    if "@table" in tree:
        cls = NOUNS[tree["@table"]]
        columns = {key: _noun(item, blobs, make) for key, item in tree.items() if key != "@table"}
        rows = zip(*columns.values(), strict=True)
        return tuple([make(cls, dict(zip(columns, row, strict=True))) for row in rows])
    given = {name: _noun(item, blobs, make) for name, item in tree.items() if name != "@"}
    return make(NOUNS[tree["@"]], given)
