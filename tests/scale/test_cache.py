"""The cache finds what was made from equal inputs, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from fabgeo.build import design
from fabgeo.build.cache import Cache


def test_equal_inputs_are_made_once(tmp_path: Path) -> None:
    calls: list[int] = []

    def make() -> tuple[float, ...]:
        calls.append(1)
        return (1.5, 2.5)

    assert Cache(tmp_path).once("fit", (1, "a"), make) == (1.5, 2.5)
    again = Cache(tmp_path)
    assert again.once("fit", (1, "a"), make) == (1.5, 2.5)
    assert (len(calls), again.found, again.made) == (1, 1, 0)
    again.once("fit", (1, "b"), make)
    again.once("nest", (1, "a"), make)
    assert len(calls) == 3


def test_fresh_finds_nothing_but_keeps(tmp_path: Path) -> None:
    Cache(tmp_path).once("fit", (), lambda: 1)
    assert Cache(tmp_path, fresh=True).once("fit", (), lambda: 2) == 2
    assert Cache(tmp_path).once("fit", (), lambda: 3) == 2


@pytest.mark.parametrize("damage", [b"", b"short", None])
def test_a_damaged_entry_is_made_again(tmp_path: Path, damage: bytes | None) -> None:
    Cache(tmp_path).once("fit", (), lambda: [1, 2, 3])
    (entry,) = tmp_path.glob("fit/*")
    whole = entry.read_bytes()
    entry.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]) if damage is None else damage)
    assert Cache(tmp_path).once("fit", (), lambda: [4]) == [4]


def test_entries_without_use_are_pruned(tmp_path: Path) -> None:
    first = Cache(tmp_path)
    first.once("fit", (1,), lambda: 1)
    first.once("fit", (2,), lambda: 2)
    second = Cache(tmp_path)
    second.once("fit", (2,), lambda: 2)
    second.prune()
    third = Cache(tmp_path)
    assert third.once("fit", (2,), lambda: 3) == 2
    assert third.once("fit", (1,), lambda: 3) == 3


def test_without_a_folder_nothing_is_kept() -> None:
    store = Cache()
    assert [store.once("fit", (), lambda k=k: k) for k in (1, 2)] == [1, 2]


@pytest.mark.slow
def test_limits_of_fits_and_choices_are_among_their_inputs(tmp_path: Path) -> None:
    dome = {
        "name": "Dome",
        "surface": {
            **{"unit": "m", "u": [-3.0, 3.0], "v": [-4.0, 4.0]},
            **{"x": "u", "y": "v", "z": "3 - 0.05*u**2 - 0.03*v**2"},
        },
        "strips": {"kind": "conical", "count": 2, "start": "principal"},
        "panels": {"count": 2, "trim": False},
    }

    def made(**tables: object) -> list[int]:
        design({**dome, **tables}, cache=Cache(tmp_path))
        return [len(list(tmp_path.glob(f"{kind}/*"))) for kind in ("fit", "choice")]

    assert made() == [1, 1]
    assert made(limits={"edge_length_error_mm": 0.03}) == [1, 1]
    assert made(limits={"twist_max_deg": 0.001})[0] == 2
    fits, choices = made(cells={"depth": -200.0})  # cells ask for less twist
    assert fits == 3
    assert made(cells={"depth": -200.0, "walls": True}) == [3, choices + 1]
