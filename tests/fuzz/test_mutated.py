"""Every reader on files changed at random: an answer or an error of fabgeo (see mutate.py)."""

from __future__ import annotations

import random
import warnings

import pytest
from mutate import mutated
from readers import READERS

FILES = 25
FEWER = {"step": 8, "iges": 8, "3dm": 8}  # take longest
SLOW = ("package",)  # is built first


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] if name in SLOW else []) for name in READERS],
)
def test_changed_files(name: str) -> None:
    reader, rng = READERS[name], random.Random(8)
    seeds = reader.seeds()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # foreign readers warn of foreign bytes
        for data in seeds[:4]:
            reader.read_bytes(data)  # sound themselves; a package's are all one package
        for _ in range(FEWER.get(name, FILES)):
            reader(mutated(seeds, rng))
