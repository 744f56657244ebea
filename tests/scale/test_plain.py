"""Stored nouns come back equal; stored bytes make nothing but nouns."""

from __future__ import annotations

import contextlib
import json
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fabgeo.build.plain import HEAD, digest, pack, unpack
from fabgeo.errors import InputError
from fabgeo.panels.unfold import unfold
from fabgeo.strips.ruled import RuledPatch
from fabgeo.structures.parts import Hole, Plate

KNOTS = np.array([0.0, 0, 0, 0, 1, 1, 1, 1])
POLES = np.array([[[x, y, 0.1 * x] for x in (0.0, 400, 800, 1200)] for y in (0.0, 900)])


def same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b, equal_nan=True)
    if is_dataclass(a):
        return type(a) is type(b) and all(
            same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a)
        )
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[k], b[k]) for k in a)
    if isinstance(a, list | tuple):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    return type(a) is type(b) and (a == b or (a != a and b != b))


def plate() -> Plate:
    hole = Hole(np.array([600.0, 450, 60]), np.array([0.0, 0, 1]), 11.0)
    return Plate(
        "P-00-01", "P", "panel", RuledPatch(KNOTS, POLES), 3.0, "steel", (hole,), {"a": "b"}
    )


def test_nouns_come_back_to_the_last_digit() -> None:
    flat = unfold(plate().mid, "P-00-01", "steel", 3.0)
    value = {"plate": plate(), "flat": flat, 3: (b"bytes", [None, True, np.inf, "ä"])}
    data = pack(value)
    assert same(unpack(data), value)
    known = unpack(data, known=True)
    assert same(known, value)
    array = known["flat"].outline[0].points
    assert array.flags.aligned
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 0.0


def test_equal_nouns_are_kept_field_by_field_and_mixed_ones_one_by_one() -> None:
    x, z = np.eye(3)[[0, 2]]
    holes = tuple(Hole(k * np.ones(3), z, 9.0 + k, 4.0, x) for k in range(5))
    short = RuledPatch(KNOTS, POLES)
    longer = RuledPatch(np.insert(KNOTS, 4, 0.5), np.arange(30.0).reshape(2, 5, 3))
    value = {"equal": holes, "unequal": (short, short, short, longer), "mixed": (*holes, plate())}
    assert same(unpack(pack(value)), value)
    assert same(unpack(pack(value), known=True), value)
    assert len(pack(holes)) < 0.6 * sum(len(pack(hole)) for hole in holes)


def test_a_digest_depends_on_every_part_of_its_inputs() -> None:
    moved = POLES.copy()
    moved[1, 2, 0] = np.nextafter(moved[1, 2, 0], 1e9)
    digests = {digest(x) for x in (POLES, moved, POLES.tolist(), plate(), ("a", "b"), ("ab",))}
    assert len(digests) == 6
    assert digest(plate()) == digest(plate())


class Stranger:
    """Not one of the nouns."""


@pytest.mark.parametrize("value", [Stranger(), {1, 2}, np.array([Stranger()]), print])
def test_nothing_else_is_stored(value: Any) -> None:
    with pytest.raises(InputError, match="is not stored"):
        pack(value)


@pytest.mark.parametrize(
    "tree",
    [
        {"@": "Popen", "args": ["touch", "x"]},
        {"@": "Plate"},
        {"@": "Hole", "centre": 1},
        {"@array": [[0, 8], "|O", [1]]},
        {"@array": [[0, 8], "3*,<f8", [1]]},
        {"@array": [[0, 8], "<f8", [10**30]]},
        {"@array": [[0, 800], "<f8", [100]]},
        {"@bytes": 3},
    ],
)
def test_stored_bytes_cannot_make_anything_else(tree: Any) -> None:
    text = json.dumps(tree).encode()
    with pytest.raises(InputError, match="damaged"):
        unpack(len(text).to_bytes(HEAD, "big") + text + bytes(8))


@settings(max_examples=200, deadline=None)
@given(st.integers(0, 10**6), st.integers(0, 255))
def test_damaged_bytes_are_refused_or_give_plain_data(place: int, value: int) -> None:
    data = bytearray(pack((plate(), POLES)))
    data[place % len(data)] = value
    with contextlib.suppress(InputError):
        unpack(bytes(data))
